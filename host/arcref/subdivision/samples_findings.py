"""What a run of samples gives: the signals identified, the error before and after, and how they scatter."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from arcref.subdivision.identification.identification import IdentifiedParameters, PeriodSamples
from arcref.subdivision.identification.identification_names import DEFAULT_METHOD, identify
from arcref.subdivision.period_parameters import (
    LineMap,
    PeriodParameters,
    error_noise_arcsec,
    line_map,
    period_parameters,
)
from arcref.subdivision.phase_knowledge import left_with_phase_error, speed_change_error_rad
from arcref.subdivision.samples_run import SamplesRun
from arcref.subdivision.signal_model import SignalModel, wrapped_rad
from arcref.subdivision.subdivision_run import SubdivisionOptions

CURVE_POINTS = 512
"""Points of the curve: the middles of the cells of the ROM's second table."""


@dataclass(frozen=True, eq=False)
class SamplesFindings:
    """A run with what was found: `identified` by the chosen way, `parameters` of each period by least squares."""

    run: SamplesRun
    options: SubdivisionOptions
    identified: IdentifiedParameters
    parameters: PeriodParameters

    @property
    def model(self) -> SignalModel:
        """The signals as identified."""
        return self.identified.model

    @cached_property
    def mean_samples(self) -> PeriodSamples:
        """The mean of all periods, sample by sample."""
        samples = self.run.samples
        volts = samples.sine_v.mean(axis=0), samples.cosine_v.mean(axis=0)
        return PeriodSamples(samples.theta_rad, *volts, self.run.line_count, self.run.cosine_sign)

    @cached_property
    def mean_reading_rad(self) -> np.ndarray:
        """The angle interpolated from the mean of the periods, rad, at each sample of a period."""
        return self.model.reading_rad(self.mean_samples.sine_v, self.mean_samples.cosine_v)

    @cached_property
    def error_before_arcsec(self) -> np.ndarray:
        """Reading less true angle of the mean period, without a mean, at each sample; no model is in it."""
        return self._about_mean(self.mean_reading_rad - self.mean_samples.theta_rad)

    @property
    def error_after_arcsec(self) -> np.ndarray:
        """The same after the identified model's correction."""
        return self.left_by(self.identified)

    def left_by(self, identified: IdentifiedParameters) -> np.ndarray:
        """The error of the mean period that the correction by these parameters leaves, arcsec."""
        model = identified.model
        correction = model.error_at_reading_arcsec(self.mean_reading_rad) / model.arcsec_per_rad
        return self._about_mean(self.mean_reading_rad - correction - self.mean_samples.theta_rad)

    @cached_property
    def rivals(self) -> tuple[IdentifiedParameters, ...]:
        """What every way finds, when a comparison is wanted."""
        from arcref.subdivision.identification.identification_names import METHODS

        return tuple(self.identified if name == self.options.method else self._identified_by(name) for name in METHODS)

    @cached_property
    def map(self) -> LineMap:
        """The error within the line, block by block over the run."""
        return line_map(self.parameters, self.model, self.run.first_line)

    @property
    def line_deg(self) -> np.ndarray:
        """Phases of the curve: of the reading, zero where the count is a multiple of a line."""
        return (np.arange(CURVE_POINTS) + 0.5) * (360.0 / CURVE_POINTS)

    @cached_property
    def curve_reading_rad(self) -> np.ndarray:
        """The interpolated phase at the points of the curve."""
        return np.radians(self.line_deg + (self.run.count_zero_phase_deg or 0.0))

    @cached_property
    def error_arcsec(self) -> np.ndarray:
        """The error at the points of the curve."""
        return self.model.error_at_reading_arcsec(self.curve_reading_rad)

    @cached_property
    def noise_arcsec(self) -> np.ndarray:
        """Standard uncertainty of the curve at its points, from the noise of the samples alone."""
        theta = self.model.true_phase_rad(self.curve_reading_rad) - self.model.mean_error_rad
        return error_noise_arcsec(self.parameters, self.model, theta) / np.sqrt(self.run.samples.periods)

    @property
    def reading_noise_arcsec(self) -> float:
        """What the samples' noise does to one interpolated angle: noise over amplitude."""
        pairs = zip(self.parameters.noise_v, (self.model.sine, self.model.cosine), strict=True)
        relative = [noise / channel.canonical.fundamental.amplitude_v for noise, channel in pairs]
        return float(np.sqrt(np.mean(np.square(relative))) * self.model.arcsec_per_rad)

    @cached_property
    def lack_of_fit_arcsec(self) -> float:
        """What the model does not describe of the mean period, rms, less what noise would leave there.

        Zero unless it is more than three standard deviations of the noise's own mean square.
        """
        rate = self.parameters.samples_per_period
        freedom = max(1, rate - self.parameters.coefficients_v.shape[-1])
        noise = self.reading_noise_arcsec**2 * (freedom / rate) / self.run.samples.periods
        found = float(np.mean(self.error_after_arcsec**2))
        return float(np.sqrt(found - noise)) if found > noise * (1 + 3 * np.sqrt(2 / freedom)) else 0.0

    @cached_property
    def speed_sensitivity_arcsec(self) -> float:
        """Rms error left in the curve for a speed that changes by 1 % along the line."""
        left = left_with_phase_error(self.model, speed_change_error_rad(0.01), self.options.orders)
        return float(np.sqrt(np.mean(left**2)))

    @property
    def slope_arcsec_per_deg(self) -> float:
        """Rms slope of the curve over the line's phase."""
        step = 360.0 / CURVE_POINTS
        return float(np.sqrt(np.mean(np.gradient(np.append(self.error_arcsec, self.error_arcsec[:1]), step) ** 2)))

    def _identified_by(self, name: str) -> IdentifiedParameters:
        return identify(self.mean_samples, name, self.options.orders, self.options.seed)

    def _about_mean(self, difference_rad: np.ndarray) -> np.ndarray:
        middle = np.angle(np.exp(1j * difference_rad).mean())
        left = wrapped_rad(difference_rad - middle)
        return self.model.arcsec_per_rad * (left - left.mean())


def samples_findings(run: SamplesRun, options: SubdivisionOptions) -> SamplesFindings:
    """Identify the signals of a run. Raises `InputError` when the samples do not determine the parameters."""
    periods = run.samples
    mean = PeriodSamples(
        periods.theta_rad, periods.sine_v.mean(axis=0), periods.cosine_v.mean(axis=0), run.line_count, run.cosine_sign
    )
    identified = identify(mean, options.method or DEFAULT_METHOD, options.orders, options.seed)
    return SamplesFindings(run, options, identified, period_parameters(periods, options.orders))
