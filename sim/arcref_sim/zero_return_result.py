"""What the zero-return test found, and whether that is a pass."""

from dataclasses import asdict, dataclass, field

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag, describe_faults
from arcref_sim.core_log import Difference

CORRECTION_LIMIT_COUNTS = 0.6
"""Largest distance of a corrected position from the reading less the fitted curve: 0.5 is rounding to whole counts, the
rest is how far the curve moves within the grating line that shares one entry of the table."""

TWO_TABLES_LIMIT_COUNTS = 0.7
"""The same with a second table: both entries are rounded, and the error moves within the four counts of a cell."""

HARMLESS_FLAGS = Flag.EDGE_SPACING_LIMIT
"""Fault flags that do not fail the test: this one says that no margin is left, not that a count is lost."""


@dataclass(frozen=True)
class IndexPass:
    """The zero mark going by: `turn` as the core counted it, `direction` 1 forward and -1 reverse, `time_s` from the
    start, `closure_error_counts` (0 at the first index, which homes), `homes` for that one.
    """

    time_s: float
    direction: int
    turn: int
    closure_error_counts: int
    homes: bool


@dataclass(frozen=True)
class Waveform:
    """The lines around one index: samples `time` (from the index's sample), `state` from each on, up to `end`."""

    direction: int
    time: np.ndarray
    state: np.ndarray
    end: int


@dataclass(frozen=True)
class ErrorOverTurn:
    """Errors against the truth in arc seconds, in cells of the turn with their middles at `angle_deg`.

    `before_...` is the reading's own error, `after_...` the corrected one's; low and high are the limits that occurred.
    """

    angle_deg: np.ndarray
    before_low: np.ndarray
    before_high: np.ndarray
    after_low: np.ndarray
    after_high: np.ndarray


@dataclass(frozen=True)
class ErrorFigures:
    """Root mean square and largest size of an error, in arc seconds, over so many readings."""

    rms_arcsec: float
    max_arcsec: float
    readings: int


@dataclass(frozen=True)
class Check:
    """One line of the verdict: what must hold, what was found, and whether it holds."""

    sentence: str
    found: str
    passed: bool


@dataclass(frozen=True)
class ZeroReturnResult:
    """Everything the test measured.

    `counts` is the way of the shaft, there and back. `simulation_s` is the time the core took, `total_s` that of all:
    compiling, making the signals, and the checks that were not done meanwhile.
    """

    speed_rps: float
    revolutions: int
    samples_per_word: int
    sample_rate_hz: float
    counts: int
    index_passes: tuple[IndexPass, ...]
    illegal_steps: int
    lost_counts: int
    flags: int
    shortest_edge_spacing_samples: int
    before: ErrorFigures
    after: ErrorFigures
    correction_deviation_counts: float
    spi_frames: int
    spi_frames_wrong: int
    words: int
    difference: Difference | None
    simulation_s: float
    total_s: float
    error_over_turn: ErrorOverTurn = field(repr=False)
    waveforms: tuple[Waveform, ...] = field(repr=False)
    provenance: dict = field(default_factory=dict)
    correction_limit_counts: float = CORRECTION_LIMIT_COUNTS

    @property
    def closure_errors_counts(self) -> list[int]:
        """Closure error at each index after the one that homed."""
        return [index.closure_error_counts for index in self.index_passes if not index.homes]

    @property
    def counts_per_turn(self) -> list[int]:
        """Counts between two indices a turn apart, in the order they came."""
        pairs = zip(self.index_passes, self.index_passes[1:], strict=False)
        return [
            COUNTS_PER_TURN + later.direction * (later.closure_error_counts - earlier.closure_error_counts)
            for earlier, later in pairs
            if earlier.direction == later.direction and abs(later.turn - earlier.turn) == 1
        ]

    @property
    def zero_drift_counts(self) -> int | None:
        """Position of the last index in reverse, where the first one had homed; None when it did not come back."""
        back = [index for index in self.index_passes if index.direction < 0 and index.turn == 0]
        return back[-1].closure_error_counts if back else None

    @property
    def shortest_edge_spacing_ns(self) -> float:
        """Shortest spacing of two edges as the core saw it; its resolution is one sample."""
        return self.shortest_edge_spacing_samples / self.sample_rate_hz * 1e9

    @property
    def counts_per_s(self) -> float:
        """Counts simulated in a second of computing."""
        return self.counts / self.simulation_s

    @property
    def samples_per_s(self) -> float:
        """Samples simulated in a second of computing."""
        return self.words * self.samples_per_word / self.simulation_s

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
        """The verdict, line by line."""
        turns = range(self.revolutions + 1)
        expected = [(turn, 1) for turn in turns] + [(turn, -1) for turn in reversed(turns)]
        seen = [(index.turn, index.direction) for index in self.index_passes]
        closure, drift = self.closure_errors_counts, self.zero_drift_counts
        harmful = describe_faults(Flag(self.flags) & ~HARMLESS_FLAGS)
        deviation, right = self.correction_deviation_counts, self.spi_frames - self.spi_frames_wrong
        return [
            Check("every zero mark was seen", f"{len(seen)} of {len(expected)}", seen == expected),
            Check("every closure error is 0", _counts_text(closure), bool(closure) and not any(closure)),
            Check("zero drift is 0", "not back" if drift is None else f"{drift} counts", drift == 0),
            Check("no count was lost", f"{self.lost_counts} lost or added", self.lost_counts == 0),
            Check("no illegal step", f"{self.illegal_steps}", self.illegal_steps == 0),
            Check("no fault flag but edge spacing", ", ".join(self.faults) or "none up", not harmful),
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

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(check.passed for check in self.checks)

    def to_json(self) -> dict:
        """The figures for a program; units stand in the names."""
        return {
            "format": "arcref-zero-return",
            "version": 1,
            "passed": self.passed,
            "checks": {check.sentence: check.passed for check in self.checks},
            "speed_rps": self.speed_rps,
            "revolutions": self.revolutions,
            "samples_per_word": self.samples_per_word,
            "sample_rate_hz": self.sample_rate_hz,
            "samples_per_count": self.samples_per_count,
            "counts": self.counts,
            "counts_per_turn": self.counts_per_turn,
            "closure": [asdict(index) for index in self.index_passes],
            "zero_drift_counts": self.zero_drift_counts,
            "lost_counts": self.lost_counts,
            "illegal_steps": self.illegal_steps,
            "shortest_edge_spacing_samples": self.shortest_edge_spacing_samples,
            "shortest_edge_spacing_ns": self.shortest_edge_spacing_ns,
            "flags": self.flags,
            "error_before_rms_arcsec": self.before.rms_arcsec,
            "error_before_max_arcsec": self.before.max_arcsec,
            "error_after_rms_arcsec": self.after.rms_arcsec,
            "error_after_max_arcsec": self.after.max_arcsec,
            "fit_difference_max_counts": self.correction_deviation_counts,
            "spi_frames_read": self.spi_frames,
            "spi_frames_wrong": self.spi_frames_wrong,
            "first_difference": None if self.difference is None else str(self.difference),
            "words": self.words,
            "seconds": self.simulation_s,
            "counts_per_s": self.counts_per_s,
            "samples_per_s": self.samples_per_s,
            "provenance": self.provenance,
        }


def _counts_text(values: list[int]) -> str:
    """`0 counts` where all agree, else each of them."""
    if not values:
        return "no zero mark came back"
    if len(set(values)) == 1:
        return f"{values[0]} counts"
    shown = " ".join(str(value) for value in values[:30])
    return f"{shown}{' ...' if len(values) > 30 else ''} counts"
