"""A bitstream as a file: what it says of itself, its block RAMs, and the same bitstream with other contents in them."""

from abc import ABC, abstractmethod

import numpy as np

from arcref_gateware.boards.block_ram_image import BlockRamImage

BOARD_KEY = "arcref board"
"""Key of the comment at a bitstream's head that names the board it was built for."""


class BitstreamError(ValueError):
    """The bytes are no bitstream of this family, or a damaged one. The text says what was found where."""


class OtherFormatError(BitstreamError):
    """The bytes do not even begin as a bitstream of this family."""


class Bitstream(BlockRamImage, ABC):
    """A configuration file. The same contents give the same bytes."""

    content: bytes
    """The whole file."""

    comments: list[str]
    """Lines of text at the head, before the part that the FPGA reads."""

    configuration_start: int
    """Offset of the part that the FPGA reads."""

    @abstractmethod
    def with_bits(self, bits: np.ndarray) -> bytes:
        """The file with other contents in its block RAMs, its checksums made right."""

    def block_rams_only(self) -> bytes:
        """A file with the same contents of the block RAMs that unpacks quickly; the whole one where that is quick."""
        return self.content

    @property
    def board(self) -> str | None:
        """Name of the board that the head gives, None when it gives none."""
        for comment in self.comments:
            key, _, value = comment.partition(": ")
            if key == BOARD_KEY:
                return value
        return None


def board_comment(board: str) -> str:
    """The line that names the board."""
    return f"{BOARD_KEY}: {board}"
