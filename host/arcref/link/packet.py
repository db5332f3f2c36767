"""Packets of the serial link.

A packet on the wire is the COBS form of its bytes and one zero byte behind it, so a zero always ends a packet and a
lost or broken byte costs no more than the packet it belongs to. The bytes are: kind, number, payload, and a CRC-16
over all of them, high byte first, so that a register run over the whole packet ends at 0. Words and addresses are
little-endian.

| kind          | from | payload                                      |
|---------------|------|----------------------------------------------|
| READ          | host | address (2), number of words (1)             |
| WRITE         | host | address (2), words                           |
| READ_ANSWER   | FPGA | status (1), address (2), words               |
| WRITE_ANSWER  | FPGA | status (1), address (2)                      |
| CAPTURE       | FPGA | one capture record; see `capture_record`     |
| OVERRUN       | FPGA | captures lost since the FIFO was emptied (4) |

The number of a request is chosen by the host and comes back in its answer. A WRITE with the number of the WRITE
before it is answered again and not carried out again, so that a host may repeat one whose answer was lost; a READ
between the two makes it a new one. The numbers of CAPTURE and OVERRUN packets count up together, 0 after 255, so that
a gap shows.
"""

import binascii
from dataclasses import dataclass
from enum import IntEnum

from cobs import cobs

DEFAULT_BAUD = 3_000_000
"""Speed of the UART where neither a board file nor the user says another."""

MOST_WORDS = 24
"""Words of one READ or WRITE, at the most."""

CRC_START = 0xFFFF
"""CRC-16/IBM-3740: polynomial 0x1021, this start, not reflected."""

DELIMITER = b"\0"

MOST_BODY_BYTES = 2 + 3 + 2 * MOST_WORDS + 2
"""Bytes of the longest packet before COBS: kind, number, status and address, words, CRC."""


class Kind(IntEnum):
    """Kind of a packet, its first byte."""

    READ = 0x01
    WRITE = 0x02
    READ_ANSWER = 0x41
    WRITE_ANSWER = 0x42
    CAPTURE = 0x80
    OVERRUN = 0x81


class Status(IntEnum):
    """Whether a request took."""

    DONE = 0
    UNKNOWN_ADDRESS = 1
    READ_ONLY = 2
    OUT_OF_RANGE = 3
    NOT_NOW = 4


class BrokenPacket(ValueError):
    """Bytes that are no packet: bad COBS, bad CRC, unknown kind or wrong length."""


@dataclass(frozen=True)
class Packet:
    """One packet without its CRC. `number` is 0..255."""

    kind: Kind
    number: int
    payload: bytes

    def encode(self) -> bytes:
        """The packet as it goes over the wire, delimiter included."""
        body = bytes([self.kind, self.number]) + self.payload
        return cobs.encode(body + crc16(body).to_bytes(2, "big")) + DELIMITER

    @classmethod
    def decode(cls, wire: bytes) -> "Packet":
        """The packet out of the bytes before a delimiter. Raises `BrokenPacket`."""
        try:
            body = cobs.decode(wire)
        except cobs.DecodeError as error:
            raise BrokenPacket(str(error)) from None
        if len(body) < 4 or crc16(body[:-2]) != int.from_bytes(body[-2:], "big"):
            raise BrokenPacket(f"{len(body)} bytes whose CRC does not hold")
        try:
            kind = Kind(body[0])
        except ValueError:
            raise BrokenPacket(f"a packet of the unknown kind {body[0]:#04x}") from None
        payload = body[2:-2]
        if not _length_fits(kind, len(payload)):
            raise BrokenPacket(f"{len(payload)} bytes in a packet of kind {kind.name}")
        return cls(kind, body[1], payload)


def crc16(body: bytes) -> int:
    """CRC-16/IBM-3740 of `body`."""
    return binascii.crc_hqx(body, CRC_START)


def _length_fits(kind: Kind, length: int) -> bool:
    words = range(1, MOST_WORDS + 1)
    lengths = {
        Kind.READ: (3,),
        Kind.WRITE: [2 + 2 * n for n in words],
        Kind.READ_ANSWER: [3 + 2 * n for n in range(MOST_WORDS + 1)],
        Kind.WRITE_ANSWER: (3,),
        Kind.CAPTURE: (15,),
        Kind.OVERRUN: (4,),
    }
    return length in lengths[kind]
