"""What it costs that the phase at which a sample was taken is not the phase it is taken for: the limit of the method.

Sine and cosine at unknown phases give the Lissajous figure and not how it is run through, so every identification with
harmonics stands on the phases of its samples. Here true signals are sampled at phases that differ from the assumed
ones, identified as if they did not, and corrected with what was found: what is left, peak to peak, is the cost.
"""

import numpy as np

from arcref.subdivision.identification.identification import USUAL_ORDERS
from arcref.subdivision.identification.least_squares import channel_of_coefficients, design_matrix
from arcref.subdivision.signal_correction import left_after_model
from arcref.subdivision.signal_model import SignalModel, line_phases_rad

SAMPLES_PER_PERIOD = 64


def left_with_phase_error(signals: SignalModel, phase_error_rad, orders: tuple[int, ...] = USUAL_ORDERS) -> np.ndarray:
    """Error left over a line, float64[512] arcsec, when sample k of one period was taken `phase_error_rad[k]` too late.

    `phase_error_rad`: float64[n], for n samples taken for equally spaced ones.
    """
    assumed = line_phases_rad(np.size(phase_error_rad))
    model = model_of_samples(assumed, signals.signals_v(assumed + phase_error_rad), orders, signals)
    return left_after_model(signals, line_phases_rad(512), model)


def model_of_samples(theta_rad, volts, orders: tuple[int, ...], like: SignalModel) -> SignalModel:
    """The least squares model of `volts` (sine, cosine) at `theta_rad`; lines and sign of the cosine from `like`."""
    coefficients = np.linalg.lstsq(design_matrix(theta_rad, orders), np.stack(volts, axis=-1), rcond=None)[0]
    sine, cosine = (channel_of_coefficients(each, orders) for each in coefficients.T)
    return SignalModel(sine, cosine, like.line_count, like.cosine_sign)


def period_scale_error_rad(relative: float, samples: int = SAMPLES_PER_PERIOD) -> np.ndarray:
    """Phase errors when the period is taken for longer by `relative` than it is: they grow along the period."""
    return relative * line_phases_rad(samples)


def speed_change_error_rad(relative: float, samples: int = SAMPLES_PER_PERIOD) -> np.ndarray:
    """Phase errors when the speed, at first as assumed, changes evenly by `relative` until the period's end."""
    theta = line_phases_rad(samples)
    return relative * theta**2 / (4 * np.pi)


def jitter_error_rad(relative: float, generator: np.random.Generator, samples: int = SAMPLES_PER_PERIOD) -> np.ndarray:
    """Phase errors that are independent from sample to sample, normal, of standard deviation `relative` periods."""
    return 2 * np.pi * relative * generator.standard_normal(samples)


def limit_rows(signals: SignalModel, orders: tuple[int, ...] = USUAL_ORDERS) -> tuple[tuple[str, float], ...]:
    """(what is wrong with the phases, error left peak to peak in arcsec), for a report."""

    def left(error_rad) -> float:
        return float(np.ptp(left_with_phase_error(signals, error_rad, orders)))

    generator = np.random.default_rng(0)
    jitter = [left(jitter_error_rad(1e-3, generator)) for _ in range(50)]
    return (
        ("phases known exactly", left(np.zeros(SAMPLES_PER_PERIOD))),
        ("period taken 0.1 % too long", left(period_scale_error_rad(1e-3))),
        ("period taken 0.5 % too long", left(period_scale_error_rad(5e-3))),
        ("period taken 1 % too long", left(period_scale_error_rad(1e-2))),
        ("speed grows by 1 % along the period", left(speed_change_error_rad(1e-2))),
        ("random jitter of 0.1 % of a period", float(np.mean(jitter))),
    )
