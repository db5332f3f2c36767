"""SPI frames that the simulated controller reads from the core, and what they say."""

import ctypes
from dataclasses import dataclass, field

import numpy as np

from arcref.position_frame import FRAME_BITS, FRAME_BYTES, FrameError, PositionFrame
from arcref_gateware.position_spi import LOWEST_CLOCK_RATIO

SNAPSHOT_CLOCKS = 1
"""A frame holds what the outputs show after the clock this many behind the first one that sees chip select low:
two registers bring chip select into the word clock, and the edge after the next takes the snapshot."""


class _PlanStructure(ctypes.Structure):
    _fields_ = [
        ("start", ctypes.c_void_p),
        ("bits", ctypes.c_void_p),
        ("sent", ctypes.c_void_p),
        ("frames", ctypes.c_int64),
        ("half_period_256ths", ctypes.c_int64),
        ("lead", ctypes.c_int64),
        ("gap", ctypes.c_int64),
    ]


@dataclass
class PlanArrays:
    """A plan as the harness reads it; `structure` points into the arrays, which live as long as this does."""

    start: np.ndarray
    bits: np.ndarray
    sent: np.ndarray
    structure: _PlanStructure = field(default_factory=_PlanStructure)


@dataclass(frozen=True)
class SpiPlan:
    """Frames to read. All times are in word clocks.

    `start`: when chip select falls in each frame, or as soon after as the frame before allows: zeros read back to
    back. `clock_ratio`: word clocks in one SCK period, 8 or more, fractions rounded to 1/128. `bits`: after how many
    bits chip select rises, 64 unless a frame is to be aborted. `sent`: eight bytes a frame on COPI, zeros unless
    given. `lead`: chip select to the first rising edge of SCK; `gap`: chip select high between frames.
    """

    start: np.ndarray
    clock_ratio: float = LOWEST_CLOCK_RATIO
    bits: np.ndarray | None = None
    sent: np.ndarray | None = None
    lead: int = 4
    gap: int = 4

    @classmethod
    def back_to_back(cls, frames: int, **options) -> "SpiPlan":
        """So many frames, one right after the other."""
        return cls(np.zeros(frames, np.int64), **options)

    def arrays(self) -> PlanArrays:
        """The plan for the harness. Raises ValueError when lengths do not match."""
        start = np.ascontiguousarray(self.start, np.int64)
        bits = np.full(len(start), FRAME_BITS) if self.bits is None else self.bits
        sent = np.zeros((len(start), FRAME_BYTES), np.uint8) if self.sent is None else self.sent
        plan = PlanArrays(start, np.ascontiguousarray(bits, np.int64), np.ascontiguousarray(sent, np.uint8))
        if len(plan.bits) != len(start) or plan.sent.shape != (len(start), FRAME_BYTES):
            raise ValueError("an SPI plan needs one start, one number of bits and eight bytes for each frame")
        half_period = round(self.clock_ratio * 128)
        places = (plan.start.ctypes.data, plan.bits.ctypes.data, plan.sent.ctypes.data)
        plan.structure = _PlanStructure(*places, len(start), half_period, self.lead, self.gap)
        return plan


def decode_frames(frames: np.ndarray) -> list[PositionFrame | None]:
    """Whole frames of SPI_FRAME records, decoded by the host; None for one that the host refuses."""

    def decode(data: bytes) -> PositionFrame | None:
        try:
            return PositionFrame.decode(data)
        except FrameError:
            return None

    return [decode(frame["data"].tobytes()) for frame in frames if frame["bits"] == FRAME_BITS]


def snapshot_words(frames: np.ndarray, latency_words: int) -> np.ndarray:
    """The sample word whose state each frame holds."""
    return frames["clock"] + SNAPSHOT_CLOCKS - latency_words
