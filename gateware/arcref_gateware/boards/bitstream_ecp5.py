"""The bitstream of an ECP5: a head with comments, frames of configuration, then the contents of the block RAMs.

Format: Project Trellis, "Bitstream format" (prjtrellis.readthedocs.io), after Lattice FPGA-TN-02039, "ECP5 and
ECP5-5G sysCONFIG". Each block RAM is written by itself and followed by a CRC-16 (polynomial 0x8005) of its own.
"""

import numpy as np

from arcref_gateware.boards.bitstream import Bitstream, BitstreamError, OtherFormatError
from arcref_gateware.boards.block_ram_geometry import ECP5_BLOCK_RAM

PREAMBLE = bytes.fromhex("ffffbdb3")

FRAME_BYTES = {1: 74, 2: 106, 3: 142}
"""Bytes of a frame, by the digit of the IDCODE that tells the size: 12F and 25F, 45F, 85F."""

BLOCK_BYTES = ECP5_BLOCK_RAM.rows * ECP5_BLOCK_RAM.row_bits // 8

# Commands of the configuration stream, and the bytes that follow each of those that are only passed over.
EBR_ADDRESS, EBR_WRITE, FRAMES, VERIFY_ID, DONE, DUMMY = 0xF6, 0xB2, 0x82, 0xE2, 0x5E, 0xFF
PASSED_OVER = {0x3B: 3, 0x22: 7, 0x46: 3, 0x79: 3, DONE: 3, 0xCE: 3, 0xC2: 9}
"""Reset of the CRC, control register, initial address, SPI mode, done, security, user code."""

HEAD_OF_BLOCK_RAMS = b"\xff\0\xff" + PREAMBLE + bytes.fromhex("ffffffff 3b000000 e2000000 21111043 3b000000")
"""The head of a bitstream that has block RAMs and nothing else, for the smallest part, the LFE5U-12F."""

PROGRAM_DONE = bytes.fromhex("5e000000 ffffffff")


class Ecp5Bitstream(Bitstream):
    """A bitstream of the ECP5 family. A block RAM's name is its number. Raises `BitstreamError`."""

    geometry = ECP5_BLOCK_RAM

    def __init__(self, content: bytes):
        self.content = content
        start = content.find(PREAMBLE)
        if start < 0 or content[:2] != b"\xff\0":
            raise OtherFormatError("no ECP5 bitstream: there is no preamble FF FF BD B3")
        self.comments = [part.decode("latin-1") for part in content[2 : start - 1].split(b"\0") if part.strip(b"\xff")]
        self.configuration_start = start
        self._blocks: dict[int, int] = {}  # file offset of the contents of each block RAM
        try:
            self._read(start + len(PREAMBLE))
        except IndexError:
            raise BitstreamError("the bitstream ends in the middle of a command") from None
        parts = [np.unpackbits(np.frombuffer(content, np.uint8, BLOCK_BYTES, at)) for at in self._blocks.values()]
        self.bits = np.concatenate(parts) if parts else np.zeros(0, np.uint8)
        # Words stand one behind the other, the most significant bit first.
        indices = np.arange(len(self.bits)).reshape(-1, self.geometry.rows, self.geometry.row_bits)[:, :, ::-1]
        self.blocks = {(block,): indices[order] for order, block in enumerate(self._blocks)}

    def _read(self, place: int) -> None:
        content = self.content
        block, frame_bytes, done = None, None, False
        while place < len(content):
            command = content[place]
            if command == DUMMY:
                place += 1
            elif command in PASSED_OVER:
                place += 1 + PASSED_OVER[command]
                done = done or command == DONE
            elif command == VERIFY_ID:
                size = content[place + 6] >> 4
                if size not in FRAME_BYTES:
                    raise BitstreamError(f"the IDCODE {content[place + 4 : place + 8].hex()} is none of an ECP5")
                frame_bytes = FRAME_BYTES[size]
                place += 8
            elif command == FRAMES and frame_bytes:
                after = content[place + 1] & 0x0F
                frames = int.from_bytes(content[place + 2 : place + 4], "big")
                place += 4 + frames * (frame_bytes + 2 + after)
            elif command == EBR_ADDRESS:
                block = int.from_bytes(content[place + 4 : place + 8], "big") >> 11 & 0x3FF
                start = place
                place += 8
            elif command == EBR_WRITE and block is not None:
                frames = int.from_bytes(content[place + 2 : place + 4], "big")
                end = place + 4 + BLOCK_BYTES
                if 9 * frames != BLOCK_BYTES or place != start + 8:
                    raise BitstreamError(f"block RAM {block} is not written whole")
                if end + 2 > len(content):
                    raise IndexError
                if crc16(content[start:end]) != int.from_bytes(content[end : end + 2], "big"):
                    raise BitstreamError(f"the CRC of block RAM {block} does not hold: the file is damaged")
                self._blocks[block] = place + 4
                place, block = end + 2, None
            else:
                raise BitstreamError(f"no known command 0x{command:02X} at byte {place}")
        if place > len(content) or not done:
            raise IndexError

    def with_bits(self, bits: np.ndarray) -> bytes:
        """The file with other contents, and their CRCs."""
        content = bytearray(self.content)
        for at, block in zip(self._blocks.values(), np.split(bits, len(self._blocks)), strict=True):
            end = at + BLOCK_BYTES
            content[at:end] = np.packbits(block).tobytes()
            content[end : end + 2] = crc16(bytes(content[at - 12 : end])).to_bytes(2, "big")
        return bytes(content)

    def block_rams_only(self) -> bytes:
        """The block RAMs alone, as of the smallest part: to unpack the frames of a large one takes 5 s.

        Nothing is lost by it, as `with_bits` leaves every byte of the frames as it is.
        """
        blocks = b"".join(self.content[at - 12 : at + BLOCK_BYTES + 2] for at in self._blocks.values())
        return HEAD_OF_BLOCK_RAMS + blocks + PROGRAM_DONE


def crc16(message: bytes) -> int:
    """The CRC-16 of the configuration stream: polynomial 0x8005, most significant bit first, from 0."""
    value = 0
    for byte in message:
        value = (value << 8 & 0xFFFF) ^ _CRC_TABLE[value >> 8 ^ byte]
    return value


def _crc_entry(byte: int) -> int:
    value = byte << 8
    for _ in range(8):
        value = value << 1 ^ (0x8005 if value & 0x8000 else 0)
    return value & 0xFFFF


_CRC_TABLE = [_crc_entry(byte) for byte in range(256)]
