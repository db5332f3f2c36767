"""What turns the shaft in the zero-return test: the user, or the on-board test generator."""

from collections.abc import Callable

from arcref.input_error import InputError
from arcref.instrument.generator_control import GeneratorControl, fault_bits, generator_rate
from arcref.instrument.instrument import Instrument


def _turns(number: int) -> str:
    return f"{number} turn{'s' * (number != 1)}"


class UserDrive:
    """The user turns, by hand or with a motor; `ask` shows a line that says how."""

    name = "hand or motor"

    def __init__(self, ask: Callable[[str], None]):
        self._ask = ask

    def prepare(self) -> None:
        """Nothing to prepare."""

    def forward(self, turns: int, homes: bool) -> None:
        """Ask for the way out."""
        start = "past the zero mark, which homes, and then" if homes else "to the next zero mark, and from there"
        on = f"{_turns(turns)} and a little further" if turns else "a little further"
        self._ask(f"Turn the shaft forward {start} {on}.")

    def reverse(self, turns: int) -> None:
        """Ask for the way back."""
        back = f"the same {_turns(turns)}" if turns else "past the same zero mark"
        self._ask(f"Now turn it back {back} and a little further.")

    def stop(self) -> None:
        """Nothing to stop."""


class GeneratorDrive:
    """The test generator turns, at `speed_rps` or else at the speed at which it turns already, with a fault by name.

    Without a name it keeps the faults that its register asks for. Its zero mark is not the encoder's, so an instrument
    that was homed on the encoder must be homed on it. Raises `InputError` when this bitstream has none, when it cannot
    turn so fast, stands and was given no speed, and when homing is needed and was not allowed.
    """

    name = "test generator"

    def __init__(
        self,
        instrument: Instrument,
        speed_rps: float | None,
        ask: Callable[[str], None],
        *,
        fault: str | None = None,
        may_home: bool,
    ):
        identity = instrument.identity
        if not identity.has_test_generator:
            raise InputError(
                f"{instrument.port}: this bitstream has no test generator; leave --generator out and turn the shaft, "
                "or build a bitstream that has one (`arcref build --self-test`)"
            )
        self._generator = GeneratorControl(instrument.registers, identity.sample_rate_hz)
        self._found = self._generator.state()
        if speed_rps is None:
            if not self._found.turns:
                raise InputError(
                    "the test generator is in place of the shaft and stands; name a speed with --generator, or take it "
                    "off with `arcref registers generator_control=0`"
                )
            speed_rps = self._found.speed_rps(identity.sample_rate_hz)
        generator_rate(speed_rps, identity.sample_rate_hz)
        self._faults = fault_bits(fault) or self._found.fault_bits
        if not may_home and not self._found.runs and instrument.snapshot().homed:
            raise InputError(
                "the test generator's zero mark is not the encoder's, so the zero must be set again: allow it with "
                "--rehome, and home on the encoder afterwards"
            )
        self._speed_rps, self._ask = speed_rps, ask

    def prepare(self) -> None:
        """Take the generator's lines, at rest, so that faults of the change are cleared before anything turns."""
        self._generator.stand()

    def forward(self, turns: int, homes: bool) -> None:
        """Turn forward."""
        self._generator.turn(self._speed_rps, faults=self._faults)

    def reverse(self, turns: int) -> None:
        """Turn in reverse."""
        self._generator.turn(self._speed_rps, reverse=True, faults=self._faults)

    def stop(self) -> None:
        """Leave it as it was found. Where that was the encoder's lines, the zero stays the generator's."""
        if self._found.runs:
            self._generator.restore(self._found)
            return
        self._generator.stop()
        self._ask("The zero is the test generator's now: home again on the encoder with `arcref registers home=1`.")


def shaft_drive(
    instrument: Instrument, speed_rps: float | None, fault: str | None, ask: Callable[[str], None], *, may_home: bool
) -> UserDrive | GeneratorDrive:
    """The generator when it was asked for, or is in place of the shaft already; else the user.

    Raises `InputError` as `GeneratorDrive` does, and for a fault without a generator.
    """
    identity = instrument.identity
    generates = (
        identity.has_test_generator and GeneratorControl(instrument.registers, identity.sample_rate_hz).state().runs
    )
    if speed_rps is not None or generates:
        return GeneratorDrive(instrument, speed_rps, ask, fault=fault, may_home=may_home)
    if fault is not None:
        raise InputError("only the test generator makes faults: name its speed with --generator")
    return UserDrive(ask)
