"""Whether a count was lost or added: the core's raw position against an ideal counter, at every word."""

import numpy as np

from arcref_sim.core_log import CoreLog
from arcref_sim.encoder import EncoderPiece


class LostCounts:
    """Finds the largest distance between the raw position and the ideal count since the core homed.

    `largest` is that distance in counts. Both come as changes in order of words; the core's lag by its latency.
    """

    def __init__(self, samples_per_word: int):
        self._samples_per_word = samples_per_word
        self._waiting = (np.empty(0, np.int64), np.empty(0, np.int64))
        self._ideal = self._raw = 0
        self.largest = 0

    def add(self, piece: EncoderPiece | None, log: CoreLog, homed_word: int | None) -> None:
        """Take the next piece (None at the end) and log; `homed_word` is the word that homed, if any did so far."""
        if piece is not None:
            word = piece.count_sample // self._samples_per_word
            last_of_word = np.append(word[1:] != word[:-1], True)
            self._waiting = (
                np.concatenate((self._waiting[0], word[last_of_word])),
                np.concatenate((self._waiting[1], piece.count[last_of_word])),
            )
        ready = int(np.searchsorted(self._waiting[0], log.end_word))
        ideal = _changes(*(array[:ready] for array in self._waiting), self._ideal)
        self._waiting = tuple(array[ready:] for array in self._waiting)
        raw = _changes(
            np.ascontiguousarray(log.positions["word"]),
            np.ascontiguousarray(log.positions["raw_position"]),
            self._raw,
        )
        if homed_word is not None:
            self._compare(ideal, raw, homed_word)
        self._ideal = int(ideal[1][-1]) if len(ideal[1]) else self._ideal
        self._raw = int(raw[1][-1]) if len(raw[1]) else self._raw

    def _compare(self, ideal, raw, homed_word: int) -> None:
        first = [int(np.searchsorted(word, homed_word)) for word, _ in (ideal, raw)]
        homed_ideal, homed_raw = ([array[at:] for array in both] for both, at in zip((ideal, raw), first, strict=True))
        if all(np.array_equal(one, other) for one, other in zip(homed_ideal, homed_raw, strict=True)):
            return
        # Not the same row of changes: look at every word in which either changed.
        for words in (homed_ideal[0], homed_raw[0]):
            distance = _level(*ideal, self._ideal, words) - _level(*raw, self._raw, words)
            self.largest = max(self.largest, int(np.abs(distance).max(initial=0)))


def _changes(word: np.ndarray, value: np.ndarray, before: int) -> tuple[np.ndarray, np.ndarray]:
    """The entries that differ from the one before."""
    changed = np.diff(value, prepend=before) != 0
    return (word, value) if changed.all() else (word[changed], value[changed])


def _level(word: np.ndarray, value: np.ndarray, before: int, at: np.ndarray) -> np.ndarray:
    """The value that holds at each of the words `at`."""
    return np.append(before, value)[np.searchsorted(word, at, side="right")]
