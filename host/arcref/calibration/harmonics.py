"""The harmonics of an error curve over the turn, with their uncertainty."""

from dataclasses import dataclass

import numpy as np

from arcref.error_curve import ErrorCurve

SEPARABLE_CONDITION = 10.0
"""Largest condition number of the equations at which orders still count as told apart. Equal spacing gives 1.4."""


@dataclass(frozen=True, eq=False)
class Harmonics:
    """The error as `mean + sum of cosine cos(order angle) + sine sin(order angle)`, by least squares.

    `order`: int[m], from 1, only orders that the faces tell apart; `cosine_arcsec`, `sine_arcsec`: float64[m];
    `u_cosine_arcsec`, `u_sine_arcsec`: their standard uncertainties from the curve's, float64[m], or None when it
    states none; `unseen_phase`: bool[m], true for the order of half the faces, of which faces at equal distances see
    one phase and never the other.
    """

    mean_arcsec: float
    order: np.ndarray
    cosine_arcsec: np.ndarray
    sine_arcsec: np.ndarray
    u_cosine_arcsec: np.ndarray | None
    u_sine_arcsec: np.ndarray | None
    unseen_phase: np.ndarray

    @property
    def amplitude_arcsec(self) -> np.ndarray:
        """Amplitude of each order, float64[m]. Noise alone gives about 1.25 times `u_amplitude_arcsec`."""
        return np.hypot(self.cosine_arcsec, self.sine_arcsec)

    @property
    def phase_deg(self) -> np.ndarray:
        """Phase of each order, float64[m]: the order is `amplitude cos(order angle - phase)`."""
        return np.degrees(np.arctan2(self.sine_arcsec, self.cosine_arcsec))

    @property
    def u_amplitude_arcsec(self) -> np.ndarray | None:
        """Standard uncertainty (k=1) of each amplitude: the mean of both phases' in the squares, or None."""
        if self.u_cosine_arcsec is None:
            return None
        phases = np.where(self.unseen_phase, 1, 2)
        return np.sqrt((self.u_cosine_arcsec**2 + self.u_sine_arcsec**2) / phases)

    @property
    def power_arcsec2(self) -> np.ndarray:
        """Each order's part in the variance of the faces' errors, float64[m]."""
        return self.amplitude_arcsec**2 * np.where(self.unseen_phase, 1.0, 0.5)

    @property
    def share(self) -> np.ndarray:
        """Each order's part of the power of all orders, float64[m], 0 to 1."""
        total = self.power_arcsec2.sum()
        return self.power_arcsec2 / total if total > 0 else np.zeros(self.order.size)

    def index(self, order: int) -> int | None:
        """Where `order` stands in the arrays, None when the faces do not tell it apart."""
        found = np.flatnonzero(self.order == order)
        return int(found[0]) if found.size else None


def harmonics(curve: ErrorCurve) -> Harmonics:
    """All harmonics of `curve` that its faces tell apart, up to half their number.

    Faces at unequal distances tell fewer apart, and those of a limited arc none.
    """
    angle = np.radians(curve.angle_deg)
    orders = [] if curve.arc_deg is not None else list(range(1, _highest_order(angle) + 1))
    columns = _columns(angle, len(orders))
    half, seen_phase = None, 0.0
    if 2 * len(orders) + 2 == angle.size:
        seen_phase = angle[0] * (angle.size // 2)
        half = np.cos((angle.size // 2) * angle - seen_phase)
        if not _separable(np.column_stack([columns, half])):
            half = None
    design = columns if half is None else np.column_stack([columns, half])
    inverse = np.linalg.pinv(design)
    coefficient = inverse @ curve.error_arcsec
    u = None if curve.u_arcsec is None else np.sqrt(inverse**2 @ curve.u_arcsec**2)

    def split(values):
        cosine, sine = values[1 : 1 + len(orders)], values[1 + len(orders) : 1 + 2 * len(orders)]
        if half is None:
            return cosine, sine
        direction = np.array([np.cos(seen_phase), np.sin(seen_phase)])
        last = values[-1] * (direction if values is coefficient else np.abs(direction))
        return np.append(cosine, last[0]), np.append(sine, last[1])

    cosine, sine = split(coefficient)
    u_cosine, u_sine = (None, None) if u is None else split(u)
    order = np.array(orders + ([] if half is None else [angle.size // 2]), int)
    unseen = np.zeros(order.size, bool)
    unseen[len(orders) :] = True
    return Harmonics(float(coefficient[0]), order, cosine, sine, u_cosine, u_sine, unseen)


def _columns(angle_rad: np.ndarray, highest: int) -> np.ndarray:
    """One, the cosines and the sines of orders 1 to `highest`, one a column."""
    phase = angle_rad[:, np.newaxis] * np.arange(1, highest + 1)
    return np.hstack([np.ones((angle_rad.size, 1)), np.cos(phase), np.sin(phase)])


def _highest_order(angle_rad: np.ndarray) -> int:
    """The highest order up to which all can be told apart. More orders are never told apart better: so by halves."""
    low, high = 0, (angle_rad.size - 1) // 2
    if _separable(_columns(angle_rad, high)):
        return high
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if _separable(_columns(angle_rad, middle)) else (low, middle)
    return low


def _separable(columns: np.ndarray) -> bool:
    return bool(np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) <= SEPARABLE_CONDITION)
