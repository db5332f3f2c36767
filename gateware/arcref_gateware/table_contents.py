"""What the three memories hold: the words of a ROM, or the placeholder that a bitstream is placed and routed with."""

import hashlib
from typing import NamedTuple

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.correction_rom import SUBDIVISION_ENTRIES, CorrectionRom
from arcref.rom_identity import IDENTITY_WORDS, identity_words


class TableContents(NamedTuple):
    """Words of the memories of one core, uint16 arrays; the names are those of the memories."""

    line: np.ndarray
    """4096 words, one a grating line."""
    subdivision: np.ndarray
    """512 words, one for each 4 counts of a line."""
    identity: np.ndarray
    """512 words, see `arcref.rom_identity`."""


def rom_contents(rom: CorrectionRom) -> TableContents:
    """The words that carry `rom`."""
    return TableContents(
        np.asarray(rom.line_table).astype(np.int16).view(np.uint16),
        np.asarray(rom.subdivision_table).astype(np.int16).view(np.uint16),
        identity_words(rom),
    )


def placeholder_contents() -> TableContents:
    """Words that look random in every bit, always the same ones and different from memory to memory.

    A bitstream is built with them and given its ROM afterwards, so placement does not depend on the ROM. Structured
    words would let synthesis drop or merge bits, which could not be found again.
    """
    return TableContents(
        _placeholder("line", LINES_PER_TURN),
        _placeholder("subdivision", SUBDIVISION_ENTRIES),
        _placeholder("identity", IDENTITY_WORDS),
    )


def _placeholder(name: str, words: int) -> np.ndarray:
    digest = hashlib.shake_128(f"arcref placeholder {name}".encode()).digest(2 * words)
    return np.frombuffer(digest, "<u2").astype(np.uint16)
