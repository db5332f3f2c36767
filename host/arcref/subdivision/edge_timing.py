"""The error within a line from edge times at constant speed.

The reading at an edge is known exactly, its true angle is speed times time. What repeats from line to line in their
difference is the error within a line. Speed ripple slower than the lines is taken off by `SmoothMotion`; what is left
of it, and the noise of the edges, averages out over the lines. Ripple in step with the lines does neither: see
`arcref.subdivision.ripple_limit`.
"""

from dataclasses import dataclass

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE
from arcref.subdivision.edge_times_run import EdgeTimes
from arcref.subdivision.line_wave import LineWave, orders_told_apart, wave_columns
from arcref.subdivision.smooth_motion import SmoothMotion

MOST_BLOCKS = 64
"""Stretches of the run that are compared for the uncertainty."""

_FEWEST_BLOCKS = 8

_SPEED_SAMPLES_A_LINE = 4


@dataclass(frozen=True, eq=False)
class EdgeTiming:
    """What edge times give.

    `wave`: the error within a line, its covariance from the scatter of `blocks` stretches of the run, each of which
    may be disturbed in itself; `residual_arcsec`: float64[n], what motion and wave leave of each edge;
    `angle_turns`, `speed_rps`: the motion at even times, the encoder's error over the turn in it.
    """

    edges: EdgeTimes
    wave: LineWave
    residual_arcsec: np.ndarray
    blocks: int
    angle_turns: np.ndarray
    speed_rps: np.ndarray
    solver: "WaveSolver"

    @property
    def noise_arcsec(self) -> float:
        """Standard deviation of one edge about motion and wave."""
        return float(np.std(self.residual_arcsec))

    @property
    def ripple(self) -> float:
        """Ripple of the speed, rms relative to its mean; a steady rise of the speed is left out."""
        return float(np.std(self.relative_speed))

    @property
    def relative_speed(self) -> np.ndarray:
        """Speed over its mean less 1, its steady change taken off, the outermost lines left out."""
        speed = self.speed_rps / self.speed_rps.mean() - 1.0
        # A spline is loose at its ends.
        speed = speed[2 * _SPEED_SAMPLES_A_LINE : -2 * _SPEED_SAMPLES_A_LINE]
        place = np.linspace(-1.0, 1.0, speed.size)
        return speed - np.polyval(np.polyfit(place, speed, 1), place)

    def ripple_order(self) -> float:
        """The order of the turn at which the ripple is strongest."""
        spectrum = np.abs(np.fft.rfft(self.relative_speed))
        turns = abs(self.angle_turns[-1] - self.angle_turns[0]) * self.relative_speed.size / self.speed_rps.size
        return float((1 + np.argmax(spectrum[1:])) / turns)


class WaveSolver:
    """Least squares for the wave within a line beside a smooth motion, for any number of readings at once."""

    def __init__(self, edges: EdgeTimes, orders: int | None = None):
        """`orders`: highest order of the wave, by default as many as the phases of the edges tell apart."""
        phases = edges.phase_rad
        self.edges, self.motion = edges, SmoothMotion(edges)
        self.columns = wave_columns(phases, orders or orders_told_apart(phases))
        self.rest = self.motion.rest(self.columns)
        self._normal = np.linalg.inv(self.rest.T @ self.rest)

    def coefficients(self, values) -> np.ndarray:
        """Coefficients of the wave in each column of `values`, float64[n, m] to float64[2 orders, m]."""
        return self._normal @ (self.rest.T @ self.motion.rest(values))

    def scatter_covariance(self, residual) -> tuple[np.ndarray, int]:
        """Covariance of the coefficients from stretches of the run, float64[2 orders, 2 orders], and their number.

        Edges close to each other share disturbances, so that their residuals are not independent; those of stretches
        of many lines nearly are.
        """
        line = np.abs(self.edges.reading_counts - self.edges.reading_counts[0]) / COUNTS_PER_LINE
        blocks = int(np.clip(line[-1] / 4, _FEWEST_BLOCKS, MOST_BLOCKS))
        start = np.unique(np.searchsorted(line, np.arange(blocks) * (line[-1] / blocks)))
        score = np.add.reduceat(self.rest * residual[:, np.newaxis], start, axis=0) @ self._normal
        return score.T @ score * (start.size / (start.size - 1)), start.size


def edge_timing(edges: EdgeTimes, orders: int | None = None) -> EdgeTiming:
    """The error within a line from the edges of a run; `orders` as in `WaveSolver`."""
    solver = WaveSolver(edges, orders)
    # The steady motion is taken off first, so that no digits are lost.
    share = edges.time_s / edges.time_s[-1]
    passed = edges.reading_counts - edges.reading_counts[0]
    steady = passed[-1] * share
    uneven = ((passed - steady) * ARCSEC_PER_COUNT)[:, np.newaxis]
    rest = solver.motion.rest(uneven)
    coefficients = solver.coefficients(uneven)[:, 0]
    residual = rest[:, 0] - solver.rest @ coefficients
    covariance, blocks = solver.scatter_covariance(residual)
    smooth = solver.motion.fit((passed - solver.columns @ coefficients / ARCSEC_PER_COUNT)[:, np.newaxis])
    samples = max(64, int(edges.lines * _SPEED_SAMPLES_A_LINE))
    angle, speed = (values[:, 0] for values in solver.motion.speed_rps(smooth, samples))
    return EdgeTiming(edges, LineWave(coefficients, covariance), residual, blocks, angle, speed, solver)
