"""The slow part of a motion: a spline of time that follows ripple of the speed, and cannot follow the lines."""

import numpy as np
from scipy.interpolate import BSpline
from scipy.linalg import cho_solve_banded, cholesky_banded

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN
from arcref.subdivision.edge_times_run import EdgeTimes

_DEGREE = 3
_EDGES_A_KNOT = 8
"""Fewest edges from one knot to the next: with fewer the spline would follow the edges' own scatter."""


class SmoothMotion:
    """Cubic splines with a knot each grating line, in the time of a run's edges.

    No such spline repeats from line to line, so that by least squares the shaft's motion and the error within a line
    are told apart; all that changes slowly over the lines goes to the motion: speed, its ripple, and the encoder's
    error over the turn.
    """

    def __init__(self, edges: EdgeTimes):
        self._unit = edges.time_s / edges.time_s[-1]
        self._knots = _knots(self._unit, np.abs(edges.reading_counts - edges.reading_counts[0]))
        self._duration_s = float(edges.time_s[-1])
        self._basis = BSpline.design_matrix(self._unit, self._knots, _DEGREE)
        normal = (self._basis.T @ self._basis).todia()
        band = np.zeros((_DEGREE + 1, normal.shape[0]))
        for offset, diagonal in zip(normal.offsets, normal.data, strict=True):
            if offset <= 0:  # the lower half, whose diagonals begin at the first column in both forms
                band[-offset] = diagonal
        self._factor = cholesky_banded(band, lower=True)

    @property
    def knots(self) -> int:
        """Knots between the run's ends."""
        return self._knots.size - 2 * (_DEGREE + 1)

    def fit(self, columns) -> BSpline:
        """The spline through each column, float64[n, m], by least squares; over time as a share of the run."""
        return BSpline(self._knots, self._coefficients(columns), _DEGREE)

    def rest(self, columns) -> np.ndarray:
        """What the splines leave of the columns, float64[n, m]."""
        return columns - self._basis @ self._coefficients(columns)

    def _coefficients(self, columns) -> np.ndarray:
        # Normal equations lose no digit that matters: B-splines are well conditioned, and the factor serves them all.
        return cho_solve_banded((self._factor, True), self._basis.T @ columns)

    def speed_rps(self, spline: BSpline, samples: int) -> tuple[np.ndarray, np.ndarray]:
        """Angle (turns) and speed (turns a second) of a spline of counts, at even times, float64[samples]."""
        unit = (np.arange(samples) + 0.5) / samples
        return spline(unit) / COUNTS_PER_TURN, spline.derivative()(unit) / (self._duration_s * COUNTS_PER_TURN)


def _knots(unit: np.ndarray, passed_counts: np.ndarray) -> np.ndarray:
    """The ends four times, and between them an edge for each line, and at least eight edges apart."""
    inner, last = [], 0
    line = np.floor(passed_counts / COUNTS_PER_LINE)
    for index in np.flatnonzero(np.diff(line, prepend=0.0)):
        # Edges that come in bunches share one time: a knot must not fall into them twice.
        enough = index - last >= _EDGES_A_KNOT and unit[index] > unit[last]
        if enough and unit.size - index > _EDGES_A_KNOT and unit[index] < 1.0:
            inner.append(unit[index])
            last = index
    return np.concatenate([np.zeros(_DEGREE + 1), inner, np.ones(_DEGREE + 1)])
