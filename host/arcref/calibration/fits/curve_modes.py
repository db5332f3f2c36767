"""The shapes an error curve is made of, each with the power that the faces show of it beyond their noise."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arcref.calibration.harmonics import SEPARABLE_CONDITION, harmonics
from arcref.error_curve import ErrorCurve


@dataclass(frozen=True, eq=False)
class CurveModes:
    """`at(angle_deg)` gives the shapes, float64[m, modes], at angles float64[m]; `variance_arcsec2`: float64[modes]."""

    at: Callable[[np.ndarray], np.ndarray]
    variance_arcsec2: np.ndarray


def curve_modes(curve: ErrorCurve) -> CurveModes:
    """The modes of `curve`: the constant and its harmonics, or over an arc a straight line and half waves of the arc.

    The variance of a mode is its square less what the stated uncertainty alone would give, never below zero.
    """
    return _over_the_turn(curve) if curve.arc_deg is None else _over_the_arc(curve)


def _over_the_turn(curve: ErrorCurve) -> CurveModes:
    found = harmonics(curve)
    power = found.amplitude_arcsec**2
    if found.u_cosine_arcsec is not None:
        power = np.maximum(power - found.u_cosine_arcsec**2 - found.u_sine_arcsec**2, 0.0)
    # Of half the faces' order one phase was seen: the other is taken to be as large.
    each_phase = np.where(found.unseen_phase, power, power / 2)
    variance = np.concatenate([[found.mean_arcsec**2], each_phase, each_phase])

    def at(angle_deg):
        phase = np.radians(angle_deg)[:, np.newaxis] * found.order
        return np.hstack([np.ones((phase.shape[0], 1)), np.cos(phase), np.sin(phase)])

    return CurveModes(at, variance)


def _over_the_arc(curve: ErrorCurve) -> CurveModes:
    first, last = curve.arc_deg

    def at(angle_deg, waves):
        along = (np.asarray(angle_deg) - first) / (last - first)
        # The half wave of order 1 is left out: the straight line is next to the same.
        order = np.concatenate([[0], np.arange(2, 2 + waves)])
        shapes = np.cos(np.pi * along[:, np.newaxis] * order)
        return np.hstack([2 * along[:, np.newaxis] - 1, shapes])

    waves = 0
    while waves + 2 < curve.angle_deg.size and np.linalg.cond(at(curve.angle_deg, waves + 1)) <= SEPARABLE_CONDITION:
        waves += 1
    inverse = np.linalg.pinv(at(curve.angle_deg, waves))
    variance = (inverse @ curve.error_arcsec) ** 2
    if curve.u_arcsec is not None:
        variance = np.maximum(variance - inverse**2 @ curve.u_arcsec**2, 0.0)
    return CurveModes(lambda angle_deg: at(angle_deg, waves), variance)
