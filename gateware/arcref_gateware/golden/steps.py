"""Golden model of the quadrature decoder and the edge-spacing watch."""

import numpy as np

from arcref_gateware.edge_spacing import SPACING_BITS, longest_quiet_words
from arcref_gateware.golden.signal_changes import QUADRATURE_STATE

_STEP_OF_DIFFERENCE = np.array([0, 1, 0, -1], dtype=np.int8)
ILLEGAL_DIFFERENCE = 2

NO_SPACING = (1 << SPACING_BITS) - 1
"""What the shortest spacing shows before there was one."""


def steps_of(state: np.ndarray, before: int) -> tuple[np.ndarray, np.ndarray]:
    """What each entry of `state` (bits A and B) did to the count, given the state `before` the first one.

    Returns `(step, illegal)`: int8 of -1, 0, +1, and bool.
    """
    number = QUADRATURE_STATE[state & 3]
    difference = np.diff(number, prepend=QUADRATURE_STATE[before & 3]) & 3
    return _STEP_OF_DIFFERENCE[difference], difference == ILLEGAL_DIFFERENCE


class EdgeSpacingModel:
    """Shortest spacing of two edges, in samples. An illegal step starts a spacing but does not end one."""

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        self.longest_quiet_words = longest_quiet_words(samples_per_word)
        self.last_edge: int | None = None
        self.shortest = NO_SPACING

    def run(self, time: np.ndarray, step: np.ndarray, illegal: np.ndarray) -> int | None:
        """Take the edges of a piece; returns the first word in which a spacing was one sample, or None."""
        is_edge = (step != 0) | illegal
        edges = time[is_edge]
        if len(edges) == 0:
            return None
        counted = step[is_edge] != 0
        before = edges[0] if self.last_edge is None else self.last_edge
        spacing = np.diff(edges, prepend=before)
        words = edges // self.samples_per_word
        # Only a spacing near the end of the range needs a look at the words without an edge inside it.
        measured = counted & (spacing < NO_SPACING)
        measured[0] &= self.last_edge is not None
        for i in np.flatnonzero(measured & (spacing >= (self.longest_quiet_words - 1) * self.samples_per_word)):
            quiet = words[i] - (words[i - 1] if i else before // self.samples_per_word) - 1
            measured[i] = quiet < self.longest_quiet_words
        self.last_edge = int(edges[-1])
        if measured.any():
            self.shortest = min(self.shortest, int(spacing[measured].min()))
        at_limit = np.flatnonzero(measured & (spacing == 1))
        return int(words[at_limit[0]]) if len(at_limit) else None
