"""The record of one captured strobe as it stands in a CAPTURE packet: 15 bytes, little-endian.

| bytes  | content                                                                         |
|--------|---------------------------------------------------------------------------------|
| 0..5   | time of the due sample, in sample periods since reset                           |
| 6..11  | raw position, signed, in counts                                                 |
| 12, 13 | corrected less raw position, signed, in counts                                  |
| 14     | the flag byte at the record                                                     |
"""

from dataclasses import dataclass

RECORD_BYTES = 15
CORRECTION_BITS = 16
"""Bits of `corrected - raw` in the record; the tables give 14 at the most."""


@dataclass(frozen=True)
class CaptureRecord:
    """One capture. `time` in sample periods since reset, positions in counts."""

    time: int
    raw: int
    corrected: int
    flags: int

    def encode(self) -> bytes:
        """The 15 bytes. Raises OverflowError when a value does not fit."""
        return (
            self.time.to_bytes(6, "little")
            + self.raw.to_bytes(6, "little", signed=True)
            + (self.corrected - self.raw).to_bytes(2, "little", signed=True)
            + bytes([self.flags])
        )

    @classmethod
    def decode(cls, data: bytes) -> "CaptureRecord":
        """The record out of its bytes. Raises ValueError for another length."""
        if len(data) != RECORD_BYTES:
            raise ValueError(f"a capture record has {RECORD_BYTES} bytes, {len(data)} came")
        raw = int.from_bytes(data[6:12], "little", signed=True)
        correction = int.from_bytes(data[12:14], "little", signed=True)
        return cls(int.from_bytes(data[:6], "little"), raw, raw + correction, data[14])


@dataclass(frozen=True)
class Overrun:
    """Captures were lost: `total` since the FIFO was emptied, modulo 2^32."""

    total: int


@dataclass(frozen=True)
class Gap:
    """A packet of the stream was lost on the wire: nobody knows what it held."""
