"""What the Verilated core showed: the same lists of changes as the golden model's, and their comparison."""

import ctypes
from dataclasses import dataclass

import numpy as np

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE, CoreOutput

SPI_FRAME = np.dtype([("clock", "i8"), ("bits", "i8"), ("data", "u1", 8)])
"""One SPI frame: the first clock that saw chip select low, the bits clocked, and the bytes read."""


class NativeLog(ctypes.Structure):
    """Where the native code puts records: room for `capacity` of them, `used` so far."""

    _fields_ = [("records", ctypes.c_void_p), ("capacity", ctypes.c_int64), ("used", ctypes.c_int64)]


@dataclass(frozen=True)
class CoreLog:
    """Changes of the core's outputs: structured arrays of POSITION_CHANGE, STATUS_CHANGE, CAPTURE and SPI_FRAME.

    `end_word`: the outputs of every word before this one have been seen.
    """

    positions: np.ndarray
    status: np.ndarray
    captures: np.ndarray
    frames: np.ndarray
    end_word: int


@dataclass(frozen=True)
class Difference:
    """The first place where the core and the golden model disagree.

    `output` is "positions", "status" or "captures"; `core` and `model` are the records as text, or "none".
    """

    word: int
    output: str
    core: str
    model: str

    def __str__(self):
        return f"word {self.word}, {self.output}: core {self.core}, golden model {self.model}"


class Comparison:
    """Compares what the core showed with what the golden model says, word for word, as both arrive in pieces."""

    TYPES = {"positions": POSITION_CHANGE, "status": STATUS_CHANGE, "captures": CAPTURE}

    def __init__(self):
        self._waiting = {name: np.empty(0, dtype) for name, dtype in self.TYPES.items()}
        self.words = 0
        self.difference: Difference | None = None

    def add(self, log: CoreLog, model: CoreOutput | None = None) -> None:
        """Take the next piece of both; at the end the core alone has one, as it is behind by its latency."""
        for name in self.TYPES:
            expected, seen = self._waiting[name], getattr(log, name)
            if model is not None:
                expected = np.concatenate((expected, getattr(model, name)))
            ready = int(np.searchsorted(expected["word"], log.end_word))
            self._waiting[name] = expected[ready:].copy()
            if self.difference is None and not _equal(seen, expected[:ready]):
                self.difference = _first_difference(name, seen, expected[:ready])
        self.words = log.end_word


def _equal(seen: np.ndarray, expected: np.ndarray) -> bool:
    """Whether two arrays of packed records agree in every bit."""
    if len(seen) != len(expected):
        return False
    return np.array_equal(np.ascontiguousarray(seen).view(np.uint8), np.ascontiguousarray(expected).view(np.uint8))


def _first_difference(name: str, seen: np.ndarray, expected: np.ndarray) -> Difference:
    common = min(len(seen), len(expected))
    unequal = np.flatnonzero(seen[:common] != expected[:common])
    place = int(unequal[0]) if len(unequal) else common
    texts = [str(records[place]) if place < len(records) else "none" for records in (seen, expected)]
    words = [int(records["word"][place]) for records in (seen, expected) if place < len(records)]
    return Difference(min(words), name, *texts)
