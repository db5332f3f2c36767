"""The on-board test generator: A, B and Z made inside the FPGA in place of the encoder's.

Control: bit 0 runs it (and takes the encoder's lines off), bit 1 turns in reverse, the bits above are the kind of
fault it makes, 0 for none. Rate: counts in a sample period, in 1/2^32 count; 0 stands still.
"""

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref.instrument.register_access import RegisterAccess
from arcref.link.registers import REGISTERS

RUN, REVERSE, FAULT_SHIFT = 1, 2, 2
NO_FAULT = 0

RATE_BITS = REGISTERS["generator_rate"].width


def generator_rate(speed_rps: float, sample_rate_hz: float) -> int:
    """The rate for a speed. Raises `InputError` for a speed that the generator cannot make."""
    fastest_rps = (2**RATE_BITS - 1) / 2**RATE_BITS * sample_rate_hz / COUNTS_PER_TURN
    if not 0 < speed_rps <= fastest_rps:
        raise InputError(
            f"the test generator cannot turn at {speed_rps:g} r/s: with {sample_rate_hz / 1e6:g} M samples/s the speed "
            f"must be above 0 and {fastest_rps:.4g} r/s at most"
        )
    return max(1, round(speed_rps * COUNTS_PER_TURN / sample_rate_hz * 2**RATE_BITS))


class GeneratorControl:
    """Drives the generator. Leave it with `stop`, which gives the encoder its lines back."""

    def __init__(self, registers: RegisterAccess, sample_rate_hz: float):
        self._registers, self._sample_rate_hz = registers, sample_rate_hz

    def is_running(self) -> bool:
        """True while the generator is in place of the encoder."""
        return bool(self._registers.generator_control & RUN)

    def stand(self) -> None:
        """Put the generator in place of the encoder, at rest."""
        self._registers.generator_rate = 0
        self._registers.generator_control = RUN

    def turn(self, speed_rps: float, *, reverse: bool = False, fault: int = NO_FAULT) -> None:
        """Turn at a constant speed."""
        rate = generator_rate(speed_rps, self._sample_rate_hz)
        self._registers.generator_control = RUN | REVERSE * reverse | fault << FAULT_SHIFT
        self._registers.generator_rate = rate

    def stop(self) -> None:
        """Stop, and take the encoder's own lines again."""
        self._registers.generator_rate = 0
        self._registers.generator_control = 0
