"""The bitstream of an iCE40: a head with comments, commands, and the contents of the block RAMs in four banks.

Format: Project IceStorm, "iCE40 FPGA bitstream format" (clifford.at/icestorm/format.html). A command's low four bits
are the number of payload bytes. The CRC is the CCITT one, from the reset command to the check.
"""

import binascii

import numpy as np

from arcref_gateware.boards.bitstream import Bitstream, BitstreamError, OtherFormatError
from arcref_gateware.boards.block_ram_geometry import ICE40_BLOCK_RAM

PREAMBLE = bytes.fromhex("7eaa997e")

CRC_START = 0xFFFF


class Ice40Bitstream(Bitstream):
    """A bitstream of the iCE40 family. A block RAM's name is its bank, its number there, and its first row.

    Raises `BitstreamError`.
    """

    geometry = ICE40_BLOCK_RAM

    def __init__(self, content: bytes):
        self.content = content
        start = content.find(PREAMBLE)
        if start < 0:
            raise OtherFormatError("no iCE40 bitstream: there is no preamble 7E AA 99 7E")
        self.comments = [part.decode("latin-1") for part in content[2 : max(start - 2, 2)].split(b"\0") if part]
        self.configuration_start = start
        self._banks: dict[int, list[tuple[int, int, int]]] = {}  # of each block: file offset, bytes, columns
        self._crc_place = self._crc_start = None
        try:
            self._read(start + len(PREAMBLE))
        except IndexError:
            raise BitstreamError("the bitstream ends in the middle of a command") from None
        self._first: dict[int, int] = {}  # of each bank: index of its first bit
        self.blocks = {}
        parts, count = [], 0
        for bank, blocks in sorted(self._banks.items()):
            bits = np.concatenate([np.unpackbits(np.frombuffer(content, np.uint8, size, at)) for at, size, _ in blocks])
            parts.append(bits)
            self._first[bank] = count
            self._name_blocks(bank, count + np.arange(len(bits)).reshape(-1, blocks[0][2]))
            count += len(bits)
        self.bits = np.concatenate(parts) if parts else np.zeros(0, np.uint8)

    def _name_blocks(self, bank: int, indices: np.ndarray) -> None:
        """The block RAMs of a bank stand side by side in its rows."""
        rows, bits = self.geometry.rows, self.geometry.row_bits
        for row in range(0, len(indices) - rows + 1, rows):
            for number in range(indices.shape[1] // bits):
                block = indices[row : row + rows, number * bits : (number + 1) * bits]
                self.blocks[bank, number, row] = block[:, ::-1]  # the most significant bit comes first

    def _read(self, place: int) -> None:
        content = self.content
        bank = width = height = 0
        while True:
            command, size = content[place] & 0xF0, content[place] & 0x0F
            payload = int.from_bytes(content[place + 1 : place + 1 + size], "big")
            place += 1 + size
            if place > len(content):
                raise IndexError
            if command == 0x00 and payload in (1, 3):
                size = width * height // 8
                if content[place + size : place + size + 2] != b"\0\0":
                    raise BitstreamError(f"the data at byte {place} does not end in two zero bytes")
                if payload == 3:
                    self._banks.setdefault(bank, []).append((place, size, width))
                place += size + 2
            elif command == 0x00 and payload == 5:
                self._crc_start = place
            elif command == 0x00 and payload == 6:
                break
            elif command == 0x10:
                bank = payload
            elif command == 0x20:
                if self._crc_start is None or binascii.crc_hqx(content[self._crc_start : place], CRC_START):
                    raise BitstreamError("its CRC does not hold: the file is damaged")
                self._crc_place = place - 2
            elif command == 0x60:
                width = payload + 1
            elif command == 0x70:
                height = payload
            elif command not in (0x50, 0x80, 0x90):
                raise BitstreamError(f"no known command 0x{content[place - 1 - size]:02X} at byte {place - 1 - size}")
        if self._crc_place is None:
            raise BitstreamError("it carries no CRC")

    def with_bits(self, bits: np.ndarray) -> bytes:
        """The file with other contents, and its CRC."""
        content = bytearray(self.content)
        for bank, blocks in self._banks.items():
            first = self._first[bank]
            for at, size, _ in blocks:
                content[at : at + size] = np.packbits(bits[first : first + 8 * size]).tobytes()
                first += 8 * size
        crc = binascii.crc_hqx(bytes(content[self._crc_start : self._crc_place]), CRC_START)
        content[self._crc_place : self._crc_place + 2] = crc.to_bytes(2, "big")
        return bytes(content)
