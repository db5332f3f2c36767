"""What the zero-return test found, and whether that is a pass."""

from dataclasses import dataclass, field

from arcref.angle import COUNTS_PER_TURN
from arcref.check import Check
from arcref.flags import Flag, describe_faults
from arcref.zero_return.index_pass import IndexPass, closure_text, missing_text
from arcref.zero_return.instrument_parts import InstrumentParts
from arcref.zero_return.truth_parts import ErrorFigures, ErrorOverTurn, Waveform

CORRECTION_LIMIT_COUNTS = 0.6
"""Largest distance of a corrected position from the reading less the fitted curve: 0.5 is rounding to whole counts, the
rest is how far the curve moves within the grating line that shares one entry of the table."""

TWO_TABLES_LIMIT_COUNTS = 0.7
"""The same with a second table: both entries are rounded, and the error moves within the four counts of a cell."""

HARMLESS_FLAGS = Flag.EDGE_SPACING_LIMIT
"""Fault flags that do not fail the test: this one says that no margin is left, not that a count is lost."""


@dataclass(frozen=True, kw_only=True)
class ZeroReturnResult:
    """Everything the test measured.

    `counts` is the way of the shaft, there and back; `first_turn` that of the first zero mark. What is None was not
    checked: an instrument does not know the truth, nor does it run beside a golden model. `simulation_s` is the time
    that the core took.
    """

    speed_rps: float
    revolutions: int
    samples_per_word: int
    sample_rate_hz: float
    counts: int
    index_passes: tuple[IndexPass, ...]
    illegal_steps: int
    flags: int
    shortest_edge_spacing_samples: int
    provenance: dict = field(default_factory=dict)
    first_turn: int = 0
    lost_counts: int | None = None
    before: ErrorFigures | None = None
    after: ErrorFigures | None = None
    correction_deviation_counts: float | None = None
    error_over_turn: ErrorOverTurn | None = field(default=None, repr=False)
    waveforms: tuple[Waveform, ...] = field(default=(), repr=False)
    spi_frames: int | None = None
    spi_frames_wrong: int | None = None
    words: int | None = None
    difference: object | None = None
    """The first difference from the golden model, as `str` tells it; None when `words` words agree."""
    simulation_s: float | None = None
    instrument: InstrumentParts | None = None
    correction_limit_counts: float = CORRECTION_LIMIT_COUNTS

    @property
    def expected_passes(self) -> list[tuple[int, int]]:
        """Turn and direction of every zero mark that must come."""
        turns = range(self.first_turn, self.first_turn + self.revolutions + 1)
        return [(turn, 1) for turn in turns] + [(turn, -1) for turn in reversed(turns)]

    @property
    def missing_passes(self) -> list[tuple[int, int]]:
        """Those of them that did not come, or not in their order; marks that came besides do no harm."""
        seen = [(index.turn, index.direction) for index in self.index_passes]
        missing, place = [], 0
        for expected in self.expected_passes:
            try:
                place = seen.index(expected, place) + 1
            except ValueError:
                missing.append(expected)
        return missing

    @property
    def closure_errors_counts(self) -> list[int | None]:
        """Closure error at each index after the one that homed."""
        return [index.closure_error_counts for index in self.index_passes if not index.homes]

    @property
    def counts_per_turn(self) -> list[int]:
        """Counts between two indices a turn apart, in the order they came."""
        pairs = zip(self.index_passes, self.index_passes[1:], strict=False)
        return [
            COUNTS_PER_TURN + later.direction * (later.closure_error_counts - earlier.closure_error_counts)
            for earlier, later in pairs
            if earlier.direction == later.direction
            and abs(later.turn - earlier.turn) == 1
            and None not in (earlier.closure_error_counts, later.closure_error_counts)
        ]

    @property
    def zero_drift_counts(self) -> int | None:
        """Position of the last index in reverse, where the first one was; None when it did not come back."""
        back = [index for index in self.index_passes if index.direction < 0 and index.turn == self.first_turn]
        return back[-1].closure_error_counts if back else None

    @property
    def shortest_edge_spacing_ns(self) -> float:
        """Shortest spacing of two edges as the core saw it; its resolution is one sample."""
        return self.shortest_edge_spacing_samples / self.sample_rate_hz * 1e9

    @property
    def counts_per_s(self) -> float | None:
        """Counts simulated in a second of computing."""
        return None if self.simulation_s is None else self.counts / self.simulation_s

    @property
    def samples_per_s(self) -> float | None:
        """Samples simulated in a second of computing."""
        return None if self.simulation_s is None else self.words * self.samples_per_word / self.simulation_s

    @property
    def samples_per_count(self) -> float:
        """Samples from edge to edge."""
        return self.sample_rate_hz / (self.speed_rps * COUNTS_PER_TURN)

    @property
    def faults(self) -> list[str]:
        """Names of the fault flags that were up."""
        return describe_faults(self.flags)

    @property
    def checks(self) -> list[Check]:
        """The verdict, line by line; a line for everything that was checked."""
        harmful = describe_faults(Flag(self.flags) & ~HARMLESS_FLAGS)
        checks = [*self._zero_mark_checks()]
        if self.lost_counts is not None:
            checks.append(Check("no count was lost", f"{self.lost_counts} lost or added", self.lost_counts == 0))
        checks += [
            Check("no illegal step", f"{self.illegal_steps}", self.illegal_steps == 0),
            Check("no fault flag but edge spacing", ", ".join(self.faults) or "none up", not harmful),
        ]
        return checks + (self._simulation_checks() if self.instrument is None else self._instrument_checks())

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def _zero_mark_checks(self) -> list[Check]:
        expected, closure, drift = self.expected_passes, self.closure_errors_counts, self.zero_drift_counts
        came_back = any(index.direction < 0 and index.turn == self.first_turn for index in self.index_passes)
        if self.instrument is None:
            seen = [(index.turn, index.direction) for index in self.index_passes]
            found, all_seen, largest = f"{len(seen)} of {len(expected)}", seen == expected, 0
        else:
            # A hand or a motor may go to and fro over a mark, or past the last one: more marks than these are no fault.
            missing = self.missing_passes
            found = f"{len(expected) - len(missing)} of {len(expected)}{missing_text(missing)}"
            all_seen, largest = not missing, self.instrument.largest_closure_error_counts
        closed = bool(closure) and not any(error != 0 for error in closure) and largest == 0
        drift_text = "not back" if not came_back else "not read" if drift is None else f"{drift} counts"
        return [
            Check("every zero mark was seen", found, all_seen),
            Check("every closure error is 0", closure_text(closure, largest), closed),
            Check("zero drift is 0", drift_text, drift == 0),
        ]

    def _simulation_checks(self) -> list[Check]:
        deviation, right = self.correction_deviation_counts, self.spi_frames - self.spi_frames_wrong
        return [
            Check("every SPI frame is right", f"{right} of {self.spi_frames}", 0 < self.spi_frames == right),
            Check(
                "core and golden model agree at every word",
                str(self.difference or f"{self.words:,} words compared"),
                self.difference is None,
            ),
            Check(
                f"corrected within {self.correction_limit_counts} counts of the fit",
                f"{deviation:.3f} counts at most",
                self.after.readings > 0 and deviation <= self.correction_limit_counts,
            ),
        ]

    def _instrument_checks(self) -> list[Check]:
        parts = self.instrument
        checks = [Check("the correction ROM is good", parts.rom_state, parts.rom_state == "good")]
        if parts.rom_readings_wrong is not None:
            right = parts.readings - parts.rom_readings_wrong
            found = f"{right} of {parts.readings}"
            checks.append(Check("every reading is corrected as the ROM image says", found, right == parts.readings))
        return checks
