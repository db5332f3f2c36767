"""The on-board self-test: what its square-wave generator is to do, so that a bare board runs the zero-return test."""

from dataclasses import dataclass
from math import ceil

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref.link.registers import GENERATOR_FAULTS, GENERATOR_RATE_STEP, REGISTERS
from arcref_gateware.boards.self_test_course import LEG_WORDS
from arcref_gateware.boards.square_wave_generator import RATE_BITS


@dataclass(frozen=True)
class SelfTest:
    """Forward for one leg, back for one leg, and so on, at constant speed.

    `speed_rps` in revolutions a second, `leg_turns` the length of a leg, `fault` one of
    `GENERATOR_FAULTS` or None. On a board with a link it turns forward until the host turns it. Raises `InputError` for
    what cannot be had.
    """

    speed_rps: float = 10.0
    leg_turns: float = 2.001
    fault: str | None = None

    def __post_init__(self):
        if self.fault is not None and self.fault not in GENERATOR_FAULTS:
            raise InputError(f"no fault {self.fault!r} can be injected; there are {', '.join(GENERATOR_FAULTS)}")
        if not 0 < self.leg_turns <= 1000:
            raise InputError(f"a leg of the self-test is more than 0 and at most 1000 turns, not {self.leg_turns!r}")

    def rate(self, samples_per_s: float) -> int:
        """Counts a sample, in 2 ** -24. Raises `InputError` for a speed beyond one count a sample, or none at all."""
        rate = round(self.speed_rps * COUNTS_PER_TURN / samples_per_s * (1 << RATE_BITS))
        if not 1 <= rate < 1 << RATE_BITS:
            fastest_rps = samples_per_s / COUNTS_PER_TURN
            raise InputError(
                f"the self-test turns at more than 0 and at most {fastest_rps:.4g} r/s "
                f"(one count a sample), not at {self.speed_rps!r} r/s"
            )
        return rate

    def reached_rps(self, samples_per_s: float) -> float:
        """The speed that the rate, a whole number, gives."""
        return self.rate(samples_per_s) / (1 << RATE_BITS) * samples_per_s / COUNTS_PER_TURN

    def legs(self, samples_per_word: int, samples_per_s: float) -> int:
        """Length of a leg in `LEG_WORDS` words: at least `leg_turns`."""
        counts_per_leg = self.rate(samples_per_s) * samples_per_word * LEG_WORDS / (1 << RATE_BITS)
        return max(1, ceil(self.leg_turns * COUNTS_PER_TURN / counts_per_leg))

    def settings(self, samples_per_s: float) -> dict[str, int]:
        """Reset values of the registers that turn the generator, on a board with a link."""
        names = {"run", self.fault}
        control = sum(1 << field.low for field in REGISTERS["generator_control"].fields if field.name in names)
        return {"generator_control": control, "generator_rate": self.rate(samples_per_s) * GENERATOR_RATE_STEP}
