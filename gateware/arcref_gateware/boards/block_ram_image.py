"""What every form of a bitstream has: the bits that its block RAMs hold after configuration."""

from collections.abc import Iterator

import numpy as np

from arcref_gateware.boards.block_ram_geometry import BlockRamGeometry

Place = tuple[int, ...]
"""Where a column lies: the name of the block RAM in the form it was found in, the port's width, and the column."""


class BlockRamImage:
    """The initial contents of the block RAMs, and the columns that a table may lie in.

    A *column* is one data bit of one block RAM at consecutive addresses. A table of words is made of columns: which
    bit of which words each of them holds is found out from placeholder contents, see `table_layout`.
    """

    geometry: BlockRamGeometry
    """The family's block RAM."""

    bits: np.ndarray
    """Every bit of every block RAM, uint8 of 0 and 1."""

    blocks: dict[Place, np.ndarray]
    """For each block RAM the indices in `bits` of its rows, int[rows, bits of a row]."""

    def columns(self) -> Iterator[tuple[Place, np.ndarray]]:
        """Each column that the block RAMs can have: its place, and the indices of its bits in `bits`."""
        for block in self.blocks:
            for width in self.geometry.port_widths:
                for column in range(self.geometry.columns_of(width)):
                    place = (*block, width, column)
                    yield place, self.column(place)

    def column(self, place: Place) -> np.ndarray:
        """Indices in `bits` of the column at `place`. Raises `KeyError` when there is none."""
        *block, width, column = place
        row, bit = self.geometry.column_bits(width, column)
        return self.blocks[tuple(block)][row, bit]
