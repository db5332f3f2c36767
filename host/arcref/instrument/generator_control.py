"""The on-board test generator: A, B, Z and strobe made inside the FPGA in place of the encoder's.

It is turned by the registers `generator_control` and `generator_rate`, whose declaration says what each bit does.
"""

from dataclasses import dataclass

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref.instrument.register_access import RegisterAccess
from arcref.link.registers import GENERATOR_FAULTS, GENERATOR_RATE_STEP, REGISTERS

_BIT = {field.name: 1 << field.low for field in REGISTERS["generator_control"].fields}
RUN, REVERSE = _BIT["run"], _BIT["reverse"]

RATE_BITS = REGISTERS["generator_rate"].width


def generator_rate(speed_rps: float, sample_rate_hz: float) -> int:
    """The rate for a speed. Raises `InputError` for a speed that the generator cannot make."""
    rate_for_1_rps = COUNTS_PER_TURN / sample_rate_hz * 2**RATE_BITS
    slowest_rps = GENERATOR_RATE_STEP / rate_for_1_rps
    fastest_rps = (2**RATE_BITS - GENERATOR_RATE_STEP) / rate_for_1_rps
    if not slowest_rps <= speed_rps <= fastest_rps:
        raise InputError(
            f"the test generator cannot turn at {speed_rps:g} r/s: with {sample_rate_hz / 1e6:g} M samples/s the speed "
            f"must be {slowest_rps:.2g} r/s at least and {fastest_rps:.4g} r/s at most"
        )
    return round(speed_rps * rate_for_1_rps / GENERATOR_RATE_STEP) * GENERATOR_RATE_STEP


def fault_bits(fault: str | None) -> int:
    """The bits of the control for a fault by name, or for none. Raises `InputError` for an unknown one."""
    if fault is None:
        return 0
    if fault not in GENERATOR_FAULTS:
        raise InputError(f"the test generator makes no fault {fault!r}; it makes {', '.join(GENERATOR_FAULTS)}")
    return _BIT[fault]


@dataclass(frozen=True)
class GeneratorState:
    """What its two registers hold."""

    control: int
    rate: int

    @property
    def runs(self) -> bool:
        """True while the generator is in place of the encoder."""
        return bool(self.control & RUN)

    @property
    def turns(self) -> bool:
        """True while it runs and does not stand."""
        return self.runs and self.rate >= GENERATOR_RATE_STEP

    @property
    def fault_bits(self) -> int:
        """The bits of the control that make faults."""
        return self.control & sum(_BIT[fault] for fault in GENERATOR_FAULTS)

    def speed_rps(self, sample_rate_hz: float) -> float:
        """The speed that its rate makes."""
        return self.rate / 2**RATE_BITS * sample_rate_hz / COUNTS_PER_TURN


class GeneratorControl:
    """Drives the generator. Leave it with `restore`, which sets it as it was, or `stop`."""

    def __init__(self, registers: RegisterAccess, sample_rate_hz: float):
        self._registers, self._sample_rate_hz = registers, sample_rate_hz

    def state(self) -> GeneratorState:
        """What it does now."""
        return GeneratorState(self._registers.generator_control, self._registers.generator_rate)

    def stand(self) -> None:
        """Put the generator in place of the encoder, at rest."""
        self._registers.generator_rate = 0
        self._registers.generator_control = RUN

    def turn(self, speed_rps: float, *, reverse: bool = False, faults: int = 0) -> None:
        """Turn at a constant speed, with the faults of these bits."""
        rate = generator_rate(speed_rps, self._sample_rate_hz)
        self._registers.generator_control = RUN | REVERSE * reverse | faults
        self._registers.generator_rate = rate

    def stop(self) -> None:
        """Stop, and take the encoder's own lines again."""
        self._registers.generator_rate = 0
        self._registers.generator_control = 0

    def restore(self, state: GeneratorState) -> None:
        """Set it as it was before."""
        self._registers.generator_rate = 0
        self._registers.generator_control = state.control
        self._registers.generator_rate = state.rate
