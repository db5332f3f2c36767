"""What the compare output must do: one pulse for each line of a grid that the position passes."""

import numpy as np


def compare_pulses(position, period: int, start: int) -> np.ndarray:
    """Words (int64) at which a pulse belongs.

    `position`: corrected position after each word (int64), never two lines further in one word; `period` in counts;
    `start`: the angle whose first passage begins the grid. A line is passed upwards by the word that reaches it, and
    downwards by the word that falls below it.
    """
    position = np.asarray(position, np.int64)
    turn = 1 << 23
    around = (position - start + turn // 2) // turn  # changes half a turn away from the start
    distance = position - start - around * turn
    crossing = (distance[1:] >= 0) != (distance[:-1] >= 0)
    crossing &= np.abs(distance[1:]) < turn // 4
    if not crossing.any():
        return np.zeros(0, np.int64)
    first = int(np.argmax(crossing)) + 1
    line = start + int(around[first]) * turn
    cell = (position[first - 1 :] - line) // period
    return first + np.flatnonzero(np.diff(cell))
