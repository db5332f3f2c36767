"""The input signals of the core as a list of changes, which is how the golden model and the simulation see them."""

from dataclasses import dataclass

import numpy as np

A_BIT = 0
B_BIT = 1
Z_BIT = 2
STROBE_BIT = 3

QUADRATURE_STATE = np.array([0, 1, 3, 2], dtype=np.int8)
"""Number of the quadrature state, by `A + 2 B`. Forward is 0, 1, 2, 3: (A,B) = 00, 10, 11, 01."""


@dataclass(frozen=True)
class SignalChanges:
    """Samples of A, B, Z and strobe from sample `start` up to, not including, sample `end`.

    `time` (int64, strictly increasing) holds the samples at which a line changed and `state` (uint8, same length) the
    lines from there on: bit 0 is A, 1 is B, 2 is Z, 3 is the strobe. The first entry stands at `start`, whether it
    differs from what came before or not. Sample 0 is the first one after reset. A long run is a row of such pieces,
    each starting where the one before ended.
    """

    time: np.ndarray
    state: np.ndarray
    end: int

    def __post_init__(self):
        if len(self.time) == 0 or len(self.time) != len(self.state) or self.time[-1] >= self.end:
            raise ValueError("changes need equal-length, non-empty time and state, all before the end")
        if np.any(np.diff(self.time) <= 0):
            raise ValueError("times of changes must increase strictly")

    @property
    def start(self) -> int:
        """The first sample of this piece."""
        return int(self.time[0])

    @classmethod
    def from_samples(cls, samples, start: int = 0) -> "SignalChanges":
        """Changes of `samples`, an array of states with one entry a sample, the first one at sample `start`."""
        samples = np.asarray(samples, dtype=np.uint8)
        changed = np.flatnonzero(np.concatenate(([True], samples[1:] != samples[:-1])))
        return cls(changed.astype(np.int64) + start, samples[changed], start + len(samples))

    def to_samples(self) -> np.ndarray:
        """One state a sample, uint8, from `start` to `end`."""
        return np.repeat(self.state, np.diff(np.append(self.time, self.end)))

    def to_words(self, samples_per_word: int) -> np.ndarray:
        """The samples as rows of `samples_per_word` states, the oldest first.

        Raises ValueError when start and end do not fall on word boundaries.
        """
        if self.start % samples_per_word or self.end % samples_per_word:
            raise ValueError(f"{self.start}..{self.end} is not a whole number of words of {samples_per_word} samples")
        return self.to_samples().reshape(-1, samples_per_word)
