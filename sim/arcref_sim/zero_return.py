"""What a zero-return test is, and what one showed.

The shaft starts a little before its zero mark, passes it (which homes the core), turns on past the last mark and comes
back the same way.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.flags import describe_faults
from arcref_gateware.reference_encoder import FIRST_CORRECTED_WORD
from arcref_sim.motion import Motion
from arcref_sim.spi_plan import SpiPlan

WORD_CLOCK_HZ = 200_000_000
"""Word clock of the simulated board."""

RUN_UP_COUNTS = 3000
"""Counts before the first zero mark and after the last one, more than a grating line."""

REST_WORDS = FIRST_CORRECTED_WORD + 64
"""Words at rest before the shaft turns: the power-up check of the ROM takes that long."""

FRAMES_PER_TURN = 32
"""SPI frames read in each turn."""


@dataclass(frozen=True)
class ZeroReturnPlan:
    """What to run. `error_arcsec` is the encoder's true error by angle in degrees (array in, array out)."""

    rom: CorrectionRom
    error_arcsec: Callable
    speed_rps: float = 10.0
    revolutions: int = 10
    samples_per_word: int = 4

    @property
    def sample_rate_hz(self) -> int:
        """Samples a second."""
        return WORD_CLOCK_HZ * self.samples_per_word

    @property
    def samples_per_count(self) -> float:
        """Samples from edge to edge."""
        return self.sample_rate_hz / (self.speed_rps * COUNTS_PER_TURN)

    def motion(self) -> Motion:
        """Rest, forward past the last mark, rest, reverse to the start."""
        turns = self.revolutions + 2 * RUN_UP_COUNTS / COUNTS_PER_TURN
        pause_s = 64 / WORD_CLOCK_HZ
        start = Motion(-RUN_UP_COUNTS + 0.5).standstill(REST_WORDS / WORD_CLOCK_HZ)
        there = start.constant_speed(self.speed_rps, turns=turns).standstill(pause_s)
        return there.constant_speed(-self.speed_rps, turns=turns).standstill(pause_s)

    def spi_plan(self, words: int) -> SpiPlan:
        """Frames at even distances over a run of so many words, the last one at its end."""
        number = max(2 * self.revolutions * FRAMES_PER_TURN, 2)
        return SpiPlan(np.linspace(REST_WORDS, words - 1000, number).astype(np.int64))


@dataclass
class ZeroReturnResult:
    """What the run showed. Counts and words are integers, errors are in the unit of their name.

    `closure`: one row an index, (turn, direction +1 or -1, closure error in counts). `angle_deg`, `before_arcsec`,
    `after_arcsec`: sampled errors against the true angle, quantisation included. `checks`: sentence -> passed.
    """

    plan: ZeroReturnPlan
    closure: list[tuple[int, int, int]] = field(default_factory=list)
    zero_drift_counts: int | None = None
    lost_counts: int = 0
    illegal_steps: int = 0
    shortest_edge_spacing: int = 0
    flags: int = 0
    counts: int = 0
    words: int = 0
    seconds: float = 0.0
    frames_read: int = 0
    frames_wrong: int = 0
    first_difference: str | None = None
    fit_difference_counts: float = 0.0
    angle_deg: np.ndarray = field(default_factory=lambda: np.empty(0))
    before_arcsec: np.ndarray = field(default_factory=lambda: np.empty(0))
    after_arcsec: np.ndarray = field(default_factory=lambda: np.empty(0))
    checks: dict[str, bool] = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """Whether every check passed."""
        return all(self.checks.values())

    @property
    def faults(self) -> list[str]:
        """Names of the fault flags that are up at the end."""
        return describe_faults(self.flags)

    @property
    def samples_per_s(self) -> float:
        """Samples simulated in a second of real time, checks included."""
        return self.words * self.plan.samples_per_word / self.seconds

    @property
    def counts_per_turn(self) -> list[int]:
        """Counts from each index to the next."""
        return [
            COUNTS_PER_TURN * abs(later[0] - earlier[0]) + later[1] * (later[2] - earlier[2])
            for earlier, later in zip(self.closure, self.closure[1:], strict=False)
            if later[1] == earlier[1]
        ]
