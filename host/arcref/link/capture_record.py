"""The record of one captured strobe as it stands in a CAPTURE packet: 15 bytes, little-endian.

| bytes  | content                                                                           |
|--------|-----------------------------------------------------------------------------------|
| 0..5   | time of the due sample, in sample periods since reset                             |
| 6..11  | raw position, signed, in counts                                                   |
| 12, 13 | lowest 16 bits of the corrected position, which is less than 2^15 counts from raw |
| 14     | the flag byte at the record                                                       |
"""

from dataclasses import dataclass

RECORD_BYTES = 15
CORRECTED_BITS = 16
"""Bits of the corrected position in the record. The tables give a correction of 14 bits at the most."""


@dataclass(frozen=True)
class CaptureRecord:
    """One capture. `time` in sample periods since reset, positions in counts."""

    time: int
    raw: int
    corrected: int
    flags: int

    def encode(self) -> bytes:
        """The 15 bytes. Raises OverflowError when a value does not fit."""
        if not -(1 << CORRECTED_BITS - 1) <= self.corrected - self.raw < 1 << CORRECTED_BITS - 1:
            raise OverflowError(f"a correction of {self.corrected - self.raw} counts does not fit a capture record")
        return (
            self.time.to_bytes(6, "little")
            + self.raw.to_bytes(6, "little", signed=True)
            + (self.corrected % (1 << CORRECTED_BITS)).to_bytes(2, "little")
            + bytes([self.flags])
        )

    @classmethod
    def decode(cls, data: bytes) -> "CaptureRecord":
        """The record out of its bytes. Raises ValueError for another length."""
        if len(data) != RECORD_BYTES:
            raise ValueError(f"a capture record has {RECORD_BYTES} bytes, {len(data)} came")
        raw = int.from_bytes(data[6:12], "little", signed=True)
        half = 1 << CORRECTED_BITS - 1
        correction = (int.from_bytes(data[12:14], "little") - raw + half) % (2 * half) - half
        return cls(int.from_bytes(data[:6], "little"), raw, raw + correction, data[14])


@dataclass(frozen=True)
class Overrun:
    """Captures were lost: `total` since the FIFO was emptied, modulo 2^32."""

    total: int


@dataclass(frozen=True)
class Gap:
    """A packet of the stream was lost on the wire: nobody knows what it held."""
