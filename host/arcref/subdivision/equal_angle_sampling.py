"""From samples in time, at a speed that is not even, to samples at equal angles of the grating line.

Gao Xu et al. 2013 sample adaptively, equation (7): 64 samples a period at a rate that follows the speed, so that the
sample's number is its phase. The rate can only follow what was: the period before. Samples at an even rate in time may
instead be resampled afterwards, which knows the speed on both sides.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline, CubicSpline
from scipy.linalg import solveh_banded

from arcref.angle import LINES_PER_TURN

SAMPLES_PER_PERIOD = 64

FEWEST_PERIODS = 2
"""Whole periods from which samples in time can be resampled."""

_PERIODS_FOR_KNOTS = 6
_SPLINE_DEGREE = 3


def sampling_rate_hz(
    speed_rps: float, line_count: int = LINES_PER_TURN, samples_per_period: int = SAMPLES_PER_PERIOD
) -> float:
    """Samples a second for equal angles at `speed_rps` turns a second.

    The print of equation (7) is right with the speed in signal periods a second; in turns a second it needs the lines.

    >>> sampling_rate_hz(1.0, 16384)
    1048576.0
    """
    return float(samples_per_period * line_count * speed_rps)


def adaptive_sample_times(mark_s, samples_per_period: int = SAMPLES_PER_PERIOD) -> np.ndarray:
    """When adaptive sampling takes its samples, float64[m - 2, samples_per_period], for period marks float64[m].

    In each period but the first the rate is that of the period before.
    """
    mark = np.asarray(mark_s, float)
    before = np.diff(mark)[:-1]
    return mark[1:-1, np.newaxis] + before[:, np.newaxis] * (np.arange(samples_per_period) / samples_per_period)


def adaptive_scale_error(mark_s) -> np.ndarray:
    """Relative period-scale error of adaptive sampling, float64[m - 2]: how much longer a period was than it took."""
    duration = np.diff(np.asarray(mark_s, float))
    return duration[:-1] / duration[1:] - 1.0


@dataclass(frozen=True, eq=False)
class EqualAngleSamples:
    """Samples at equal angles: `sine_v`, `cosine_v` float64[periods, samples a period], sample k at phase 2 pi k / n.

    `mark_s`: float64[periods + 1], when each period began (sample numbers where there was no time), or None when the
    samples were taken at equal angles already.
    """

    sine_v: np.ndarray
    cosine_v: np.ndarray
    mark_s: np.ndarray | None = None

    @property
    def periods(self) -> int:
        """Number of whole periods."""
        return self.sine_v.shape[0]

    @property
    def theta_rad(self) -> np.ndarray:
        """Phases of the samples of a period, float64[n]."""
        return 2 * np.pi * np.arange(self.sine_v.shape[1]) / self.sine_v.shape[1]


def true_phase_over_time(time_s, reading_rad, highest_order: int = 12) -> np.ndarray:
    """The true phase at each time from the interpolated one, float64[n].

    reading = phase(time) + a wave of orders 1 .. `highest_order` in the reading, both by one linear least squares: the
    phase is a cubic spline with a knot each period, and no such spline repeats from period to period, so the two can be
    told apart. A speed that changes in step with the lines cannot: it is taken for an error of the signals. With less
    than six periods one polynomial serves for the phase.

    `time_s`: float64[n], increasing; `reading_rad`: float64[n], unwrapped. Of the wave no mean is taken off, so that
    reading and phase agree in the mean.
    """
    time, reading = np.asarray(time_s, float), np.asarray(reading_rad, float)
    unit = (time - time[0]) / (time[-1] - time[0])
    periods = (reading[-1] - reading[0]) / (2 * np.pi)
    order = np.arange(1, highest_order + 1)
    waves = np.concatenate([np.sin(np.outer(reading, order)), np.cos(np.outer(reading, order))], axis=1)
    degree, knots = _knots(unit, reading, periods)
    columns = np.concatenate([reading[:, np.newaxis], waves], axis=1)
    basis = BSpline.design_matrix(unit, knots, degree).tocsr()
    smooth = _least_squares_spline(basis, columns, degree)
    rest = columns - basis @ smooth
    share = np.linalg.solve(rest[:, 1:].T @ rest[:, 1:], rest[:, 1:].T @ rest[:, 0])
    return basis @ (smooth[:, 0] - smooth[:, 1:] @ share)


def resample(
    time_s, sine_v, cosine_v, reading_rad, samples_per_period: int = SAMPLES_PER_PERIOD, orders=(1, 3, 5)
) -> EqualAngleSamples:
    """Equal-angle samples of all whole periods, from samples at the times `time_s`.

    `reading_rad`: the unwrapped interpolated phase of each sample, growing; `orders`: of the signals' harmonics, which
    say how wavy their error may be. Phase 0 is where the reading is zero, but for the mean of the error; the periods
    are cut where the samples begin. Raises ValueError for less than `FEWEST_PERIODS` whole periods, and for a phase
    that does not grow.
    """
    highest = 2 * (max(orders) + 1)
    phase = true_phase_over_time(time_s, reading_rad, highest)
    turn = phase / (2 * np.pi)
    first = int(np.ceil(turn[0] * samples_per_period - 1e-9))
    periods = int(np.floor(turn[-1] + (1 - first) / samples_per_period + 1e-9))
    if periods < FEWEST_PERIODS:
        raise ValueError(f"{max(0, periods)} whole periods, at least {FEWEST_PERIODS} were expected")
    grid = (first + np.arange(periods * samples_per_period)) / samples_per_period
    if (np.diff(turn) <= 0).any():
        raise ValueError("the shaft all but stands still somewhere, a growing phase was expected")
    volts = CubicSpline(turn, np.stack([sine_v, cosine_v], axis=-1))(grid)
    volts = np.roll(volts.reshape(periods, samples_per_period, 2), first % samples_per_period, axis=1)
    mark = CubicSpline(turn, np.asarray(time_s, float))(first / samples_per_period + np.arange(periods + 1))
    return EqualAngleSamples(volts[..., 0], volts[..., 1], mark)


def _least_squares_spline(basis, columns: np.ndarray, degree: int) -> np.ndarray:
    """Coefficients of the splines through each column, by the banded normal equations."""
    gram = basis.T @ basis
    banded = np.zeros((degree + 1, gram.shape[0]))
    for above in range(degree + 1):
        banded[degree - above, above:] = gram.diagonal(above)
    return solveh_banded(banded, basis.T @ columns)


def _knots(unit: np.ndarray, reading: np.ndarray, periods: float) -> tuple[int, np.ndarray]:
    """Degree and knots: one a period, for few periods none, and a lower degree the fewer there are."""
    if periods < _PERIODS_FOR_KNOTS:
        degree = 1 if periods < 3 else 2
        return degree, np.repeat([0.0, 1.0], degree + 1)
    marks = reading[0] + 2 * np.pi * np.arange(1, int(periods))
    inner = np.interp(marks, np.maximum.accumulate(reading), unit)
    ends = [0.0] * (_SPLINE_DEGREE + 1), [1.0] * (_SPLINE_DEGREE + 1)
    return _SPLINE_DEGREE, np.concatenate([ends[0], inner[1:-1], ends[1]])
