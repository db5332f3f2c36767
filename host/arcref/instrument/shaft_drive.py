"""What turns the shaft in the zero-return test: the user, or the on-board test generator."""

from collections.abc import Callable

from arcref.input_error import InputError
from arcref.instrument.encoder import Encoder
from arcref.instrument.generator_control import GeneratorControl, generator_rate


def _turns(number: int) -> str:
    return f"{number} turn{'s' * (number != 1)}"


class UserDrive:
    """The user turns, by hand or with a motor; `ask` shows a line that says how.

    Raises `InputError` while the test generator is in place of the encoder.
    """

    name = "hand or motor"

    def __init__(self, encoder: Encoder, ask: Callable[[str], None]):
        self._ask = ask
        identity = encoder.identity
        if identity.has_test_generator and GeneratorControl(encoder.registers, identity.sample_rate_hz).is_running():
            raise InputError(
                "the test generator runs, so the shaft is not seen; stop it with `arcref registers "
                "generator_control=0`, or name a speed with --generator"
            )

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
    """The test generator turns. Its zero mark is not the encoder's, so a homed instrument must be homed on it.

    Raises `InputError` when this bitstream has none, when it cannot turn so fast, and when homing is needed and was
    not allowed.
    """

    name = "test generator"

    def __init__(self, encoder: Encoder, speed_rps: float, ask: Callable[[str], None], *, may_home: bool):
        identity = encoder.identity
        if not identity.has_test_generator:
            raise InputError(
                f"{encoder.port}: this bitstream has no test generator; leave --generator out and turn the shaft, or "
                "build a bitstream that has one"
            )
        generator_rate(speed_rps, identity.sample_rate_hz)
        if not may_home and encoder.snapshot().homed:
            raise InputError(
                "the test generator's zero mark is not the encoder's, so the zero must be set again: allow it with "
                "--rehome, and home on the encoder afterwards"
            )
        self._generator = GeneratorControl(encoder.registers, identity.sample_rate_hz)
        self._speed_rps, self._ask = speed_rps, ask

    def prepare(self) -> None:
        """Take the generator's lines, at rest, so that faults of the change are cleared before anything turns."""
        self._generator.stand()

    def forward(self, turns: int, homes: bool) -> None:
        """Turn forward."""
        self._generator.turn(self._speed_rps)

    def reverse(self, turns: int) -> None:
        """Turn in reverse."""
        self._generator.turn(self._speed_rps, reverse=True)

    def stop(self) -> None:
        """Give the encoder its lines back; the zero stays the generator's."""
        self._generator.stop()
        self._ask("The zero is the test generator's now: home again on the encoder with `arcref registers home=1`.")
