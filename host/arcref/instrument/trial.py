"""Trial tables: a ROM image loaded into the running instrument, checked there, gone at power-off."""

import time

import numpy as np

from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.instrument.identity import Identity
from arcref.instrument.register_access import RegisterAccess
from arcref.instrument_error import InstrumentError
from arcref.link.packet import MOST_WORDS
from arcref.link.registers import REGISTERS, ROM_STATES
from arcref.rom_identity import decode_identity, identity_words

BEGIN, FINISH = 1, 2

CHECK_TIMEOUT_S = 1.0
"""The instrument reads its tables through in well under a millisecond."""


def check_encoder(rom: CorrectionRom, identity: Identity) -> None:
    """Raises `InputError` when both ROMs say whose they are, and `rom` is of another encoder than the instrument's."""
    mine = identity.rom.serial if identity.rom else None
    its = decode_identity(identity_words(rom)).serial
    if mine and its and mine != its:
        raise InputError(
            f"the ROM image belongs to another encoder: it was made for {its}, the instrument carries that of {mine}"
        )


def load_trial(registers: RegisterAccess, rom: CorrectionRom, progress=lambda part: None) -> None:
    """Write all three memories and have them checked. Raises `InstrumentError` when the check finds them bad."""
    tables = {
        "line_table": np.asarray(rom.line_table).view(np.uint16),
        "subdivision_table": np.asarray(rom.subdivision_table).view(np.uint16),
        "identity": identity_words(rom),
    }
    whole, done = sum(len(words) for words in tables.values()), 0
    registers.trial = BEGIN
    for name, words in tables.items():
        for first in range(0, len(words), MOST_WORDS):
            part = words[first : first + MOST_WORDS].tolist()
            registers.write_window(name, first, part)
            done += len(part)
            progress(done / whole)
    registers.trial = FINISH
    state = _state_after_check(registers)
    if state == "fault":
        raise InstrumentError("the trial ROM did not arrive whole: the instrument's CRC does not hold; load it again")
    if registers.rom_crc32 != rom.crc32:
        raise InstrumentError("the instrument carries another ROM than the one that was loaded")


def _state_after_check(registers: RegisterAccess) -> str:
    field = REGISTERS["rom_state"].fields[0]
    deadline = time.monotonic() + CHECK_TIMEOUT_S
    while True:
        number = field.extract(registers.rom_state)
        state = ROM_STATES[number] if number < len(ROM_STATES) else f"unknown state {number}"
        if state not in ("checking", "loading"):
            return state
        if time.monotonic() > deadline:
            raise InstrumentError(f"the instrument still says {state!r} {CHECK_TIMEOUT_S:g} s after a trial was loaded")
