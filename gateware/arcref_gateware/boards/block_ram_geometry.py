"""How the words of a block RAM's port lie in its storage, for both families.

The storage is rows of bits. A port as wide as a row takes one row a word; a narrower one takes several words to a row.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np


@dataclass(frozen=True)
class BlockRamGeometry:
    """One family's block RAM."""

    rows: int
    """Rows of storage."""
    row_bits: int
    """Bits of a row."""
    port_widths: tuple[int, ...]
    """Data widths that a port can have, in bits."""
    column_words: int
    """Words that a column spans, see `BlockRamImage`."""
    interleaved: bool
    """Whether words that share a row take turns bit by bit; else each has its bits side by side."""

    def columns_of(self, width: int) -> int:
        """Columns of a port `width` bits wide: its data bits, for each `column_words` of its words."""
        return self._used_bits(width) * self.rows // self.column_words

    @cache  # noqa: B019
    def column_bits(self, width: int, column: int) -> tuple[np.ndarray, np.ndarray]:
        """The rows of one column's words, and the bit in each row. Raises `KeyError` when there is no such column.

        Columns past the data width are the same bits of the next `column_words` words.
        """
        if width not in self.port_widths or not 0 <= column < self.columns_of(width):
            raise KeyError((width, column))
        part, bit = divmod(column, width)
        word = part * self.column_words + np.arange(self.column_words)
        if self.interleaved:
            sharing = self.row_bits // width
            # The lowest address line is the most significant one of the choice inside a row.
            choice = _reversed_bits(word % sharing, sharing.bit_length() - 1)
            return word // sharing, bit * sharing + choice
        flat = word * width + bit
        return flat // self._used_bits(width), flat % self._used_bits(width)

    def _used_bits(self, width: int) -> int:
        """Bits used of a row: an ECP5 port of 1, 2 or 4 bits leaves the ninth out."""
        return self.row_bits if width % self.row_bits == 0 or self.row_bits % width == 0 else 8


def _reversed_bits(value: np.ndarray, bits: int) -> np.ndarray:
    result = np.zeros_like(value)
    for bit in range(bits):
        result |= (value >> bit & 1) << bits - 1 - bit
    return result


ICE40_BLOCK_RAM = BlockRamGeometry(rows=256, row_bits=16, port_widths=(16, 8, 4, 2), column_words=256, interleaved=True)
"""Lattice TN1250, "Memory Usage Guide for iCE40 Devices"; the address lines as Yosys wires them."""

ECP5_BLOCK_RAM = BlockRamGeometry(
    rows=2048, row_bits=9, port_widths=(1, 2, 4, 9, 18, 36), column_words=512, interleaved=False
)
"""Lattice FPGA-TN-02204, "ECP5 and ECP5-5G Memory Usage Guide"."""
