"""Who an instrument is: its gateware, its clocks, and the calibration it carries."""

from dataclasses import dataclass

from arcref.instrument.register_access import RegisterAccess
from arcref.instrument_error import InstrumentError
from arcref.link.registers import REGISTERS
from arcref.rom_identity import RomIdentity, decode_identity


@dataclass(frozen=True)
class Identity:
    """What `arcref info` prints. `rom` is None, with `rom_problem` set, when the identity memory cannot be read."""

    gateware: str
    protocol: int
    samples_per_word: int
    word_clock_hz: int
    capture_depth: int
    has_test_generator: bool
    rom_state: str
    rom_is_trial: bool
    rom_crc32: int
    rom: RomIdentity | None
    rom_problem: str | None = None

    @property
    def sample_rate_hz(self) -> float:
        """Samples of A and B in a second."""
        return float(self.word_clock_hz * self.samples_per_word)


def read_identity(registers: RegisterAccess) -> Identity:
    """Read it out of the instrument. Raises `InstrumentError` as `Link` does."""
    gateware = registers.gateware
    state, features = registers.rom_state, registers.features
    state_field, trial_field = REGISTERS["rom_state"].fields
    number = state_field.extract(state)
    words = registers.read_window("identity")
    try:
        rom, problem = decode_identity(words), None
    except ValueError as error:
        rom, problem = None, str(error)
    clock, samples = registers.word_clock_hz, registers.samples_per_word
    if not clock or not samples:
        raise InstrumentError("the instrument states no word clock; its gateware is incomplete")
    return Identity(
        gateware=f"{gateware >> 8}.{gateware & 0xFF}",
        protocol=registers.protocol,
        samples_per_word=samples,
        word_clock_hz=clock,
        capture_depth=registers.capture_depth,
        has_test_generator=bool(features & 1),
        rom_state=state_field.choices[number] if number < len(state_field.choices) else f"unknown ({number})",
        rom_is_trial=bool(trial_field.extract(state)),
        rom_crc32=registers.rom_crc32,
        rom=rom,
        rom_problem=problem,
    )
