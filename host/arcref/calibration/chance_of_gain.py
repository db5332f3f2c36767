"""How likely chance alone makes another reading of a polygon run so much better than the run as given.

Chance: were the run right, the change that the alternative makes would have nothing to do with the errors. From face to
face it is taken as normally distributed in each order of the turn, with whatever variance suits the alternative best:
that the power of an order falls to a part r or less then has a chance of r/e at most (for an order with one phase only,
sqrt(2 r / (pi e))), and Fisher's rule puts the orders together. From round to round it is a vector of any length and of
random direction in d dimensions: that squares fall to a part r has the chance I(r; (d - 1)/2, 1/2) / 2, I being the
regularised incomplete beta function. d counts no more than the readings that change, or the orders by their entropy.
"""

import numpy as np
from scipy.special import betainc, gammaincc, xlogy

from arcref.calibration.polygon_reduction import series_residual

TINY_ARCSEC2 = 1e-8
"""Squares below this are rounding of a file's last digits."""

_FACES_PER_SMOOTH_ORDER, _MOST_SMOOTH_ORDERS = 8, 8


def chance_of_gain(
    given: np.ndarray, alternative: np.ndarray, direction: tuple[int, ...], whole: bool, parity: int = 0
) -> tuple[float, float]:
    """Probability that chance makes the alternative so much better, and the sum of squares it leaves.

    `given`, `alternative`: errors, float64[series, faces]; `direction` of each series; `whole`: the alternative changes
    the run from its first reading on; `parity`: +1 or -1 when all that it changes is the even or the odd part of the
    errors about face 1.
    """
    changed = alternative != given
    rounds, freedom = series_residual(np.array([given, alternative]), direction)
    faces = rough_part(given.mean(axis=0)), rough_part(alternative.mean(axis=0))
    left = float((rounds[1] ** 2).sum() + (faces[1] ** 2).sum())
    chances = [1.0]
    if freedom:
        before, after = rounds[0][changed], rounds[1][changed]
        dimensions = min(freedom, _dimensions(_power(rounds[1] - rounds[0])))
        chances.append(_half_beta(before, after, min(dimensions, changed.sum() - 1)))
    touched = changed.any(axis=0)
    if whole:
        chances.append(_chance_by_orders(*faces, parity))
    elif changed[:, touched].all():
        before, after = faces[0][touched], faces[1][touched]
        dimensions = _dimensions(_power(faces[1] - faces[0])[np.newaxis])
        chances.append(_half_beta(before, after, min(dimensions, touched.sum() - 1)))
    return min(chances), left


def _chance_by_orders(before: np.ndarray, after: np.ndarray, parity: int) -> float:
    """From face to face: the gains of all rough orders together, after Fisher.

    A change of one parity leaves the other part of the errors alone: only its own part is looked at.
    """
    if parity:
        mirror = -np.arange(before.size) % before.size
        before, after = ((errors + parity * errors[mirror]) / 2 for errors in (before, after))
    own = slice(_orders(before.size), None)
    changed = _power(after - before)[own] > TINY_ARCSEC2
    ratio = (_power(after)[own] + TINY_ARCSEC2) / (_power(before)[own] + TINY_ARCSEC2)
    one_phase = np.full(ratio.size, bool(parity))
    one_phase[-1] |= before.size % 2 == 0  # every other face: this order has a sign, and no phase
    chance = np.where(one_phase, np.sqrt(2 * ratio / (np.pi * np.e)), ratio / np.e)
    chance = np.where(changed, np.minimum(chance, 1.0), 1.0)
    return float(gammaincc(ratio.size, -np.log(chance).sum()))


def _half_beta(before: np.ndarray, after: np.ndarray, dimensions: float) -> float:
    """Chance that a random change in so many dimensions makes `after` of `before`; 1 when it is no gain."""
    gain = ((before**2).sum() + TINY_ARCSEC2) / ((after**2).sum() + TINY_ARCSEC2)
    if gain <= 1 or dimensions <= 1:
        return 1.0
    return float(0.5 * betainc((dimensions - 1) / 2, 0.5, 1 / gain))


def _orders(faces: int) -> int:
    """The order from which on errors count as rough."""
    return min(faces // _FACES_PER_SMOOTH_ORDER, _MOST_SMOOTH_ORDERS) + 1


def rough_part(errors: np.ndarray) -> np.ndarray:
    """What a smooth curve leaves of the errors, float64[..., faces]."""
    spectrum = np.fft.rfft(errors)
    spectrum[..., : _orders(errors.shape[-1])] = 0
    return np.fft.irfft(spectrum, errors.shape[-1])


def _power(errors: np.ndarray) -> np.ndarray:
    """Sum of squares over the faces that each order makes, float64[..., orders]."""
    faces = errors.shape[-1]
    power = 2 * np.abs(np.fft.rfft(errors)) ** 2 / faces
    power[..., 0] /= 2
    if faces % 2 == 0:
        power[..., -1] /= 2
    return power


def _dimensions(power: np.ndarray) -> float:
    """In how many dimensions a change of such powers, float64[rows, orders], really goes: 2 exp(entropy) each row.

    Random face deviations reach two thirds of all dimensions by this measure, which errs on the side of no alarm.
    """
    total = power.sum(axis=-1, keepdims=True)
    changed = total[:, 0] > 0
    share = power[changed] / total[changed]
    return float(2 * np.exp(-xlogy(share, share).sum(axis=-1)).sum())
