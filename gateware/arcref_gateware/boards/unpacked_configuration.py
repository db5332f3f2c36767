"""The block RAMs in the text that the public tools unpack a bitstream into: a reading that shares nothing with ours.

`iceunpack` writes `.ram_data X Y` and 16 lines of 64 hexadecimal digits, `ecpunpack` writes `.bram_init N` and 2048
words of three hexadecimal digits.
"""

import re

import numpy as np

from arcref_gateware.boards.block_ram_geometry import ECP5_BLOCK_RAM, ICE40_BLOCK_RAM
from arcref_gateware.boards.block_ram_image import BlockRamImage


class Ice40Unpacked(BlockRamImage):
    """What `iceunpack` wrote. A block RAM's name is the x and y of its tile."""

    geometry = ICE40_BLOCK_RAM

    def __init__(self, text: str):
        blocks = re.findall(r"^\.ram_data (\d+) (\d+)\n((?:[0-9a-f]{64}\n){16})", text, re.MULTILINE)
        # The last digit of a line holds the lowest bits of the first of its 16 rows.
        lines = [bytes.fromhex(line)[::-1] for *_, block in blocks for line in block.split()]
        self.bits = np.unpackbits(np.frombuffer(b"".join(lines), np.uint8), bitorder="little")
        indices = np.arange(len(self.bits)).reshape(-1, self.geometry.rows, self.geometry.row_bits)
        self.blocks = {(int(x), int(y)): indices[order] for order, (x, y, _) in enumerate(blocks)}


class Ecp5Unpacked(BlockRamImage):
    """What `ecpunpack` wrote. A block RAM's name is its number."""

    geometry = ECP5_BLOCK_RAM

    def __init__(self, text: str):
        blocks = re.findall(r"^\.bram_init (\d+)\n((?:[0-9a-f]{3}[ \n]){2048})", text, re.MULTILINE)
        words = np.array([int(word, 16) for _, block in blocks for word in block.split()], np.uint16)
        self.bits = (words[:, np.newaxis] >> np.arange(9) & 1).astype(np.uint8).ravel()
        indices = np.arange(len(self.bits)).reshape(-1, self.geometry.rows, self.geometry.row_bits)
        self.blocks = {(int(block),): indices[order] for order, (block, _) in enumerate(blocks)}
