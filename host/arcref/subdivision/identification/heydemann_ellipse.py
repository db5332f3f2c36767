"""Identification by the ellipse of the Lissajous figure: what the field usually does.

Heydemann, Applied Optics 20(19) 1981 3382: offsets, ratio of amplitudes and quadrature error make the figure of sine
against cosine an ellipse; a conic fitted to it gives all five numbers, and needs no knowledge of the phase. It cannot
see harmonics: what they do to the angle stays.
"""

import math
import time

import numpy as np

from arcref.input_error import InputError
from arcref.subdivision.identification.identification import IdentifiedParameters, PeriodSamples
from arcref.subdivision.identification.least_squares import identified
from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel

_PARAMETERS_A_CHANNEL = 3
"""Offset and amplitude, and of one of the two the phase to the other."""


def heydemann_ellipse(samples: PeriodSamples) -> IdentifiedParameters:
    """Offsets, amplitudes and the angle between the channels by a linear fit of a conic.

    The figure alone shows neither where on it a line begins nor which way round it is run through; these two are
    taken from the samples' phases. Raises `InputError` when the figure is no ellipse.
    """
    started = time.perf_counter()
    sine_offset, cosine_offset, sine, cosine, apart = fit_ellipse(samples.sine_v, samples.cosine_v)
    seconds = time.perf_counter() - started
    turning = np.exp(-1j * np.asarray(samples.theta_rad))
    first, second = (
        np.sum((samples.sine_v - sine_offset) * turning),
        np.sum((samples.cosine_v - cosine_offset) * turning),
    )
    start = float(np.angle(first)) + math.pi / 2
    sense = 1 if (second * np.conj(first)).imag >= 0 else -1
    model = SignalModel(
        ChannelModel(sine_offset, {1: Harmonic(sine, start).canonical}),
        ChannelModel(cosine_offset, {1: Harmonic(cosine, start + sense * apart).canonical}),
        samples.line_count,
        samples.cosine_sign,
    )
    return identified(samples, model, "heydemann", _PARAMETERS_A_CHANNEL, seconds)


def fit_ellipse(x_v, y_v) -> tuple[float, float, float, float, float]:
    """The ellipse x = p + A sin t, y = q + B sin(t + d) through points: (p, q, A, B, d), in V and rad, 0 <= d <= pi.

    Least squares in the conic a x^2 + b x y + c y^2 + e x + f y = 1, about the middle of the points and scaled.
    Raises `InputError` when they lie on no ellipse.
    """
    middle = np.array([np.mean(x_v), np.mean(y_v)])
    size = max(float(np.std(x_v)), float(np.std(y_v)), np.finfo(float).tiny)
    x, y = (np.asarray(x_v) - middle[0]) / size, (np.asarray(y_v) - middle[1]) / size
    columns = np.stack([x * x, x * y, y * y, x, y], axis=-1)
    (a, b, c, e, f), _, rank, _ = np.linalg.lstsq(columns, np.ones_like(x), rcond=1e-9)
    # Points on a straight line leave the conic open, and lstsq would choose an ellipse.
    if rank < columns.shape[1] or not 4 * a * c - b * b > 1e-9:
        raise InputError("sine against cosine is no ellipse: is one channel dead, or wired to the other?")
    conic = np.array([[a, b / 2], [b / 2, c]])
    centre = np.linalg.solve(conic, [-e / 2, -f / 2])
    spread = np.linalg.inv(conic) * (1 + centre @ conic @ centre)
    if not (np.diag(spread) > 0).all():
        raise InputError("sine against cosine is no ellipse: is one channel dead, or wired to the other?")
    radii = np.sqrt(np.diag(spread))
    apart = math.acos(max(-1.0, min(1.0, spread[0, 1] / (radii[0] * radii[1]))))
    offsets = middle + size * centre
    return float(offsets[0]), float(offsets[1]), float(size * radii[0]), float(size * radii[1]), apart
