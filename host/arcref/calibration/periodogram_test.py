"""Whether one order of an error curve stands out from the others by more than chance."""

from fractions import Fraction
from math import comb

import numpy as np

from arcref.calibration.harmonics import Harmonics


def order_share(found: Harmonics, order: int) -> float | None:
    """The part of `order` in the power of all orders of which both phases were seen; None when it is none of them."""
    share = _shares(found)
    index = found.index(order)
    return None if index is None or found.unseen_phase[index] else float(share[index])


def single_order_p(found: Harmonics, order: int) -> float | None:
    """Chance that an order named beforehand has this share or more when the errors are independent normal noise."""
    share = order_share(found, order)
    return None if share is None else float((1.0 - share) ** (_shares(found).size - 1))


def fisher_g_p(found: Harmonics) -> float:
    """Chance that the *largest* order has its share or more when the errors are independent normal noise.

    R. A. Fisher, Proc. R. Soc. A 125 (1929) 54: the sum over j of (-1)^(j-1) C(m, j) (1 - j g)^(m-1).
    """
    share = _shares(found)
    if share.size < 2 or not share.any():
        return 1.0
    # Exact, because the terms of many orders nearly cancel.
    g, m = Fraction(float(share.max())), share.size
    terms = ((-1) ** (j - 1) * comb(m, j) * (1 - j * g) ** (m - 1) for j in range(1, min(m, int(1 / g)) + 1))
    return min(1.0, max(0.0, float(sum(terms))))


def _shares(found: Harmonics) -> np.ndarray:
    power = found.power_arcsec2[~found.unseen_phase]
    total = power.sum()
    return power / total if total > 0 else np.zeros(power.size)
