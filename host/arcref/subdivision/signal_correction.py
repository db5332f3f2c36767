"""What is left of the error within a line when the identified model corrects it, in the ways of the paper and ours.

Errors left are reading less true angle in arcsec at the true phases given, without their mean.
"""

from collections.abc import Iterable

import numpy as np

from arcref.subdivision.signal_model import ChannelModel, SignalModel, wrapped_rad


def left_without(
    signals: SignalModel,
    theta_rad,
    orders: Iterable[int],
    *,
    offset: bool = False,
    model: SignalModel | None = None,
    passes: int | None = None,
) -> np.ndarray:
    """Error left when harmonics of `orders` (and the offsets) of `model` are subtracted from the `signals`.

    `model`: what was identified, by default the signals themselves. `passes`: None subtracts at the true phase, as only
    a simulation can; a number subtracts at the phase estimated from the signals, less the common phase, estimated anew
    after each pass, as an instrument would.
    """
    model = model or signals
    theta = np.asarray(theta_rad, float)
    sine, cosine = signals.signals_v(theta)
    estimate = theta if passes is None else signals.reading_rad(sine, cosine) - model.common_phase_rad
    for _ in range(passes or 1):
        clean = (
            sine - _removed(model.sine, estimate, orders, offset),
            cosine - _removed(model.cosine, estimate, orders, offset),
        )
        reading = signals.reading_rad(*clean)
        estimate = estimate if passes is None else reading - model.common_phase_rad
    return _without_mean(signals, reading - theta)


def left_after_lookup(signals: SignalModel, theta_rad, lookups: int, model: SignalModel | None = None) -> np.ndarray:
    """Error left when the model's error curve over the *true* phase is looked up, first at the measured phase.

    Each further lookup is made at the phase that the one before gave. The paper's equation (6) is one lookup; the curve
    looked up holds the common phase, which moves where it is looked up first.
    """
    model, theta = model or signals, np.asarray(theta_rad, float)
    reading = signals.reading_rad(*signals.signals_v(theta))
    estimate = reading
    for _ in range(lookups):
        estimate = reading - model.error_arcsec(estimate) / model.arcsec_per_rad - model.mean_error_rad
    return _without_mean(signals, estimate - theta)


def left_after_model(signals: SignalModel, theta_rad, model: SignalModel) -> np.ndarray:
    """Error left when the model's error *at the reading* is subtracted: what a ROM table over the reading does."""
    theta = np.asarray(theta_rad, float)
    reading = signals.reading_rad(*signals.signals_v(theta))
    return _without_mean(signals, reading - model.error_at_reading_arcsec(reading) / model.arcsec_per_rad - theta)


def _removed(channel: ChannelModel, theta_rad, orders, offset: bool) -> np.ndarray:
    return channel.evaluate(theta_rad) - channel.without(orders, offset).evaluate(theta_rad)


def _without_mean(signals: SignalModel, difference_rad) -> np.ndarray:
    middle = np.angle(np.exp(1j * np.asarray(difference_rad)).mean(axis=-1, keepdims=True))
    left = wrapped_rad(difference_rad - middle)
    return signals.arcsec_per_rad * (left - left.mean(axis=-1, keepdims=True))
