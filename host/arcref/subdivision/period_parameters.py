"""The parameters of each period by itself: their mean, how far they scatter, and whether they change over the turn."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from arcref.subdivision.equal_angle_sampling import EqualAngleSamples
from arcref.subdivision.identification.least_squares import channel_of_coefficients, design_matrix
from arcref.subdivision.signal_model import SignalModel, line_phases_rad

MOST_BLOCKS = 64
"""Rows of the map over the turn: neighbouring lines are averaged until there are no more."""

SIGNIFICANCE = 1e-3
"""Chance at which parameters that never change would be said to change."""

MAP_PHASES = 64


@dataclass(frozen=True, eq=False)
class PeriodParameters:
    """Linear coefficients of each period, float64[periods, 2 channels, 1 + 2 orders], as `design_matrix` has them.

    `noise_v`: standard deviation of one sample, (sine, cosine), from the scatter within the periods; None for one
    period with no samples to spare.
    """

    coefficients_v: np.ndarray
    noise_v: np.ndarray
    orders: tuple[int, ...]
    samples_per_period: int

    @property
    def expected_sd_v(self) -> np.ndarray:
        """float64[2, 1 + 2 orders]: what noise alone makes of them: sigma / sqrt(n), harmonics sigma sqrt(2 / n)."""
        factor = np.full(self.coefficients_v.shape[-1], np.sqrt(2.0 / self.samples_per_period))
        factor[0] = 1.0 / np.sqrt(self.samples_per_period)
        return self.noise_v[:, np.newaxis] * factor

    @property
    def change_probability(self) -> float | None:
        """Chance that constant parameters would scatter as much from period to period; None for one period."""
        periods = self.coefficients_v.shape[0]
        if periods < 2 or not (self.noise_v > 0).all():
            return None
        about = self.coefficients_v - self.coefficients_v.mean(axis=0)
        square = float(np.sum((about / self.expected_sd_v) ** 2))
        return float(chi2.sf(square, about[0].size * (periods - 1)))

    def model(self, like: SignalModel, rows=slice(None)) -> SignalModel:
        """The signals of the mean parameters of `rows` of the periods."""
        mean = self.coefficients_v[rows].mean(axis=0)
        sine, cosine = (channel_of_coefficients(each, self.orders) for each in mean)
        return SignalModel(sine, cosine, like.line_count, like.cosine_sign)


def period_parameters(samples: EqualAngleSamples, orders: tuple[int, ...]) -> PeriodParameters:
    """Least squares in each period by itself; the mean over the periods is that of all samples together."""
    columns = design_matrix(samples.theta_rad, orders)
    volts = np.stack([samples.sine_v, samples.cosine_v], axis=1)
    coefficients = volts @ np.linalg.pinv(columns).T
    # The mean residual is what the model lacks and no noise.
    residual = volts - coefficients @ columns.T
    periods, _, rate = volts.shape
    if periods > 1:
        residual = residual - residual.mean(axis=0)
    freedom = (rate - columns.shape[1]) * (periods - 1 if periods > 1 else 1)
    noise = np.sqrt(np.sum(residual**2, axis=(0, 2)) / max(1, freedom))
    return PeriodParameters(coefficients, noise, orders, rate)


@dataclass(frozen=True, eq=False)
class LineMap:
    """The error within a line, block by block of lines.

    `first_line`: int[blocks], where each block begins, `lines` how many are averaged in one; `theta_deg`:
    float64[phases]; `error_arcsec`: float64[blocks, phases]; `noise_arcsec`: what the noise alone scatters them, rms.
    """

    first_line: np.ndarray
    lines: int
    theta_deg: np.ndarray
    error_arcsec: np.ndarray
    noise_arcsec: float

    @property
    def change_arcsec(self) -> np.ndarray:
        """float64[phases]: standard deviation over the blocks at each phase, less what the noise makes."""
        if len(self.error_arcsec) < 2:
            return np.zeros(self.theta_deg.size)
        variance = self.error_arcsec.var(axis=0, ddof=1) - self.noise_arcsec**2
        return np.sqrt(np.maximum(0.0, variance))


def line_map(parameters: PeriodParameters, model: SignalModel, first_line: int = 0) -> LineMap:
    """The map of the run's periods; at most `MOST_BLOCKS` rows, periods that fill no block are left out."""
    periods = parameters.coefficients_v.shape[0]
    lines = -(-periods // MOST_BLOCKS)
    starts = np.arange(periods // lines) * lines
    theta = line_phases_rad(MAP_PHASES)
    error = [parameters.model(model, slice(start, start + lines)).error_arcsec(theta) for start in starts]
    noise = float(np.sqrt(np.mean(error_noise_arcsec(parameters, model, theta) ** 2)) / np.sqrt(lines))
    return LineMap(first_line + starts, lines, np.degrees(theta), np.array(error), noise)


def error_noise_arcsec(parameters: PeriodParameters, model: SignalModel, theta_rad) -> np.ndarray:
    """Standard uncertainty of the identified error at each phase, for one period, from the noise of its samples.

    The error turns by the signals' parts along the circle: de = (cosine d sine - sine d cosine) / radius^2; both
    channels are independent, and a change of all phases alike is no error.
    """
    theta = np.asarray(theta_rad, float)
    sine, cosine = model.signals_v(theta)
    square = sine**2 + cosine**2
    columns = design_matrix(theta, parameters.orders)
    fine = line_phases_rad(512)
    all_sine, all_cosine = model.signals_v(fine)
    everywhere = design_matrix(fine, parameters.orders)
    variance = np.zeros(theta.shape)
    for part, all_part, sd in (
        (cosine / square, all_cosine / (all_sine**2 + all_cosine**2), parameters.expected_sd_v[0]),
        (sine / square, all_sine / (all_sine**2 + all_cosine**2), parameters.expected_sd_v[1]),
    ):
        mean = np.mean(all_part[:, np.newaxis] * everywhere, axis=0)
        variance = variance + np.sum(((part[:, np.newaxis] * columns - mean) * sd) ** 2, axis=1)
    return model.arcsec_per_rad * np.sqrt(variance)
