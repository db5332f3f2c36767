"""A straight line over the arc that was measured."""

import numpy as np


def line_columns(angle_deg, arc_deg: tuple[float, float]) -> np.ndarray:
    """The two columns of a straight line at the angles float64[m], 1 and -1 .. 1 over the arc: float64[m, 2]."""
    first, last = arc_deg
    along = (2 * np.asarray(angle_deg, float) - first - last) / (last - first)
    return np.column_stack([np.ones(along.size), along])
