"""Identification by linear least squares: exact, and in one step.

A sin(k theta + c) = (A cos c) sin k theta + (A sin c) cos k theta, so the model of equations (8) and (9) is linear in
the offset and in two coefficients an order. The nonlinear search of the paper, its equations (10) and (11), solves the
same problem in other unknowns and cannot do better. On equally spaced phases this is a discrete Fourier transform.
"""

import time

import numpy as np

from arcref.input_error import InputError
from arcref.subdivision.identification.identification import USUAL_ORDERS, IdentifiedParameters, PeriodSamples
from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel

# Columns more alike than this are one column to the samples at hand.
_LARGEST_CONDITION = 1e6


def design_matrix(theta_rad, orders: tuple[int, ...]) -> np.ndarray:
    """float64[..., n, 1 + 2 orders]: columns 1, then sin k theta and cos k theta for each order k."""
    theta = np.asarray(theta_rad, float)
    columns = [np.ones_like(theta)]
    for order in orders:
        columns += [np.sin(order * theta), np.cos(order * theta)]
    return np.stack(columns, axis=-1)


def channel_of_coefficients(coefficients, orders: tuple[int, ...]) -> ChannelModel:
    """The channel whose least squares coefficients these are, float64[1 + 2 orders]: A = hypot, c = atan2(cos, sin)."""
    offset, *rest = (float(value) for value in coefficients)
    pairs = zip(orders, rest[::2], rest[1::2], strict=True)
    return ChannelModel(offset, {k: Harmonic(float(np.hypot(s, c)), float(np.arctan2(c, s))) for k, s, c in pairs})


def check_samples(samples: PeriodSamples, orders: tuple[int, ...]) -> None:
    """Raises `InputError` when the samples do not determine the parameters of these orders."""
    parameters = 1 + 2 * len(orders)
    count = np.size(samples.theta_rad)
    if count < parameters:
        raise InputError(f"{count} samples cannot give the {parameters} parameters of a channel")
    gram = design_matrix(samples.theta_rad, orders)
    gram = gram.T @ gram / count
    if np.linalg.cond(gram) > _LARGEST_CONDITION:
        shown = ", ".join(map(str, orders))
        raise InputError(f"{count} samples do not tell the orders {shown} apart: more samples a period are needed")


def least_squares(samples: PeriodSamples, orders: tuple[int, ...] = USUAL_ORDERS) -> IdentifiedParameters:
    """Offset, amplitudes and phases with the least sum of squared residuals."""
    check_samples(samples, orders)
    started = time.perf_counter()
    columns = design_matrix(samples.theta_rad, orders)
    volts = np.stack([samples.sine_v, samples.cosine_v], axis=-1)
    coefficients = np.linalg.lstsq(columns, volts, rcond=None)[0]
    channels = [channel_of_coefficients(each, orders) for each in coefficients.T]
    seconds = time.perf_counter() - started
    model = SignalModel(*channels, samples.line_count, samples.cosine_sign)
    return identified(samples, model, "least-squares", columns.shape[1], seconds)


def identified(
    samples: PeriodSamples,
    model: SignalModel,
    method: str,
    parameters: int,
    seconds: float,
    details: dict | None = None,
) -> IdentifiedParameters:
    """The outcome with its residuals; `parameters`: how many were found for each channel."""
    count = np.size(samples.theta_rad)
    residual = np.stack([samples.sine_v, samples.cosine_v]) - np.stack(model.signals_v(samples.theta_rad))
    square = np.sum(residual**2, axis=-1)
    rms = tuple(float(value) for value in np.sqrt(square / count))
    noise = tuple(float(value) for value in np.sqrt(square / max(1, count - parameters)))
    return IdentifiedParameters(model, method, rms, noise, count, seconds, details or {})
