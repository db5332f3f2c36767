"""Golden model of the zero reference: what every index proves."""

import numpy as np

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN


def nearest_turn_difference(position):
    """Position less the nearest whole turn, -2^22 .. 2^22 - 1 counts."""
    half = COUNTS_PER_TURN // 2
    return ((position + half) & (COUNTS_PER_TURN - 1)) - half


def is_near_whole_turn(position):
    """Whether a position lies within one grating line (2048 counts) of a whole turn."""
    return ((position + COUNTS_PER_LINE) & (COUNTS_PER_TURN - 1)) <= 2 * COUNTS_PER_LINE


class ClosureModel:
    """Judges indices and watches for missing ones, word by word in order. Starts at the word that homes."""

    def __init__(self):
        self.inside = True
        self.seen = True
        self.came_from_below = False
        self.closure_error = 0
        self.largest_closure_error = 0

    def start(self, position: int) -> None:
        """The word of the first index ended at `position`."""
        self.came_from_below = position < 0

    def word(self, position: int, index_position: int | None) -> tuple[bool, bool]:
        """Take the position after a homed word and that of the index in it, if any.

        Returns `(closure fault, index fault)`.
        """
        closure_fault = index_fault = False
        near = bool(is_near_whole_turn(position))
        below = nearest_turn_difference(position) < 0
        if near and not self.inside:
            self.inside, self.seen, self.came_from_below = True, False, below
        if index_position is not None:
            if is_near_whole_turn(index_position):
                self.seen = True
                self.closure_error = int(nearest_turn_difference(index_position))
                closure_fault = self.closure_error != 0
                if abs(self.closure_error) > abs(self.largest_closure_error):
                    self.largest_closure_error = self.closure_error
            else:
                index_fault = True
        if not near and self.inside:
            self.inside = False
            index_fault |= not self.seen and below != self.came_from_below
        return closure_fault, index_fault


def crossings(position: np.ndarray, inside_before: bool) -> np.ndarray:
    """Entries of `position` at which it enters or leaves the neighbourhood of a whole turn."""
    return np.flatnonzero(np.diff(is_near_whole_turn(position), prepend=inside_before))
