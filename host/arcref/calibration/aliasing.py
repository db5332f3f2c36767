"""Errors within a grating line as the faces of a polygon see them.

An error of order 4096 (once in each grating line, from the interpolation of its signals), 8192 and so on is far too
fast for the faces. At faces at equal distances it looks just like a slow error of low order, goes into the ROM as that,
and is then wrong between the faces. A second run may be blind to it as well: 24 faces turned by 5 degrees are.
"""

from dataclasses import dataclass

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.harmonics import Harmonics, harmonics
from arcref.calibration.periodogram_test import single_order_p
from arcref.error_curve import ErrorCurve

MULTIPLES = (1, 2, 3, 4)
"""Orders looked at, in errors a grating line: offset and gain of the signals give 1 and 2, their distortion 3 and 4."""

COHERENT = 0.5
"""Least coherence at which the error within a line still counts as looking like one order."""

BLIND = 0.5
"""A second run that shows less than this part of an error is blind to it."""

SIGNAL_PERIOD_DEG = 360.0 / LINES_PER_TURN


@dataclass(frozen=True)
class Alias:
    """What an error of `order` a turn, `multiple` a grating line, looks like at the faces of a curve.

    `seen_order`: the order it looks like, 0 for a constant, None when it is scattered over many; `coherence`: 0 to 1,
    the part of its power at the faces that looks so. Of the curve's harmonic of that order, None where there is none:
    `amplitude_arcsec`, `u_amplitude_arcsec`, `share` of all orders' power, `p`: chance of such a share in noise.
    """

    multiple: int
    order: int
    seen_order: int | None
    coherence: float
    amplitude_arcsec: float | None = None
    u_amplitude_arcsec: float | None = None
    share: float | None = None
    p: float | None = None


def aliases(
    curve: ErrorCurve, reading_deg=None, multiples=MULTIPLES, found: Harmonics | None = None
) -> tuple[Alias, ...]:
    """What the errors within a line look like at the faces of `curve`, one `Alias` for each of `multiples`.

    `reading_deg`, float64[n, readings], nan where there is none: the angles at which each face was read, where these
    are better known than the curve's own; `found`: the curve's harmonics, when they are at hand.
    """
    found = harmonics(curve) if found is None else found
    return tuple(_alias(curve, found, multiple, _wave(curve, reading_deg, multiple)) for multiple in multiples)


def exposure(fit: FittedCurve, order: int, offset_deg: float) -> float:
    """How much of an error of `order` a second run shows, with every face `offset_deg` further on.

    The amplitude left after correction by `fit`, which took the error for a slow one, over that of the error itself,
    about the mean: 2 shows it doubled, 0 not at all.
    """
    return exposure_at(fit, order, fit.curve.angle_deg + offset_deg)


def exposure_at(fit: FittedCurve, order: int, angle_deg) -> float:
    """The same for a second run at the angles float64[m]."""
    angle = np.asarray(angle_deg, float)
    angle = angle[fit.covers(angle)]
    left = _turning(order, angle) - fit.weights(angle) @ _turning(order, fit.curve.angle_deg)
    # A run is reduced against its first face: a constant is never seen.
    return float(np.sqrt(np.mean(np.abs(left - left.mean()) ** 2))) if angle.size else 0.0


def telling_offsets(fit: FittedCurve, seen: tuple[Alias, ...]) -> tuple[tuple[float, tuple[float, ...]], ...]:
    """Offsets for a second run, best first: the offset in degrees and its `exposure` of each of `seen`.

    Parts of the face spacing, plain and with half or a quarter of a signal period more. The best shows most of the
    worst exposed of the errors that look like an order; those that look like a constant no offset shows.
    """
    hidden = [alias.seen_order not in (0, None) for alias in seen]
    spacing = fit.curve.spacing_deg
    candidates = [spacing * part + more for more in (0, SIGNAL_PERIOD_DEG / 2, SIGNAL_PERIOD_DEG / 4) for part in PARTS]
    rows = [(offset, tuple(exposure(fit, alias.order, offset) for alias in seen)) for offset in candidates]

    def worst(row):
        shown = [factor for factor, is_hidden in zip(row[1], hidden, strict=True) if is_hidden]
        return round(min(shown, default=0.0), 1)

    return tuple(sorted(rows, key=worst, reverse=True))


PARTS = (1 / 2, 1 / 3, 1 / 4, 1 / 6)
"""Offsets tried by `telling_offsets`, in face spacings."""


def _turning(order: int, angle_deg) -> np.ndarray:
    """exp(i order angle), the turns taken off in degrees where they are exact."""
    return np.exp(1j * np.radians(np.mod(order * np.asarray(angle_deg, float), 360.0)))


def _wave(curve: ErrorCurve, reading_deg, multiple: int) -> np.ndarray:
    """The error of this many a line at each face, complex128[n]; smaller where readings meet it at several phases."""
    order = multiple * LINES_PER_TURN
    if reading_deg is None:
        return _turning(order, curve.angle_deg)
    return np.nanmean(_turning(order, np.atleast_2d(reading_deg)), axis=1)


def _alias(curve: ErrorCurve, found: Harmonics, multiple: int, wave: np.ndarray) -> Alias:
    order = multiple * LINES_PER_TURN
    if curve.arc_deg is not None:
        return Alias(multiple, order, None, 0.0)
    half = curve.angle_deg.size // 2
    likeness = {seen: abs(np.mean(wave * _turning(-seen, curve.angle_deg))) ** 2 for seen in range(-half, half + 1)}
    best = max(likeness, key=likeness.get)
    coherence = float(likeness[best])
    if coherence < COHERENT:
        return Alias(multiple, order, None, coherence)
    index = found.index(abs(best))
    if index is None:
        return Alias(multiple, order, abs(best), coherence)
    u = found.u_amplitude_arcsec
    return Alias(
        multiple,
        order,
        abs(best),
        coherence,
        float(found.amplitude_arcsec[index]),
        None if u is None else float(u[index]),
        float(found.share[index]),
        single_order_p(found, abs(best)),
    )
