"""Captures as a NumPy array, with units in the names of its fields."""

from collections.abc import Iterable

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref.link.capture_record import CaptureRecord

CAPTURE_DTYPE = np.dtype(
    [
        ("time_s", "f8"),
        ("angle_deg", "f8"),
        ("position_counts", "i8"),
        ("raw_position_counts", "i8"),
        ("time_samples", "i8"),
        ("flags", "u1"),
        ("lost_before", "i8"),
    ]
)
"""One capture. Time since the instrument's reset, in seconds and in sample periods; corrected angle 0..360 deg;
corrected and raw position, turns included; the flag byte; captures lost just before this one, -1 when it is not known
how many (a packet was lost, or the cable had been pulled)."""

TIME_BITS = 48
"""Bits of the time in a record."""

UNKNOWN_LOSS = -1


def capture_array(records: Iterable[tuple[int, CaptureRecord]], sample_rate_hz: float) -> np.ndarray:
    """`records`, pairs of (lost before, record), as an array of `CAPTURE_DTYPE`."""
    rows = [(0.0, 0.0, record.corrected, record.raw, record.time, record.flags, lost) for lost, record in records]
    captures = np.array(rows, CAPTURE_DTYPE)
    captures["time_s"] = captures["time_samples"] / sample_rate_hz
    captures["angle_deg"] = (captures["position_counts"] % COUNTS_PER_TURN) * (360.0 / COUNTS_PER_TURN)
    return captures


def lost_together(first: int, second: int) -> int:
    """Losses of two gaps in a row, unknown when one of them is."""
    return UNKNOWN_LOSS if UNKNOWN_LOSS in (first, second) else first + second


def after(before: int, time: int) -> int:
    """The time of a record whose clock counts modulo 2^48, made to go on from `before`, that of the record before it.

    A step back of less than half the range stays one: then the clock did not come round.
    """
    turn = 1 << TIME_BITS
    time += before - before % turn
    return time + turn if time < before - turn // 2 else time
