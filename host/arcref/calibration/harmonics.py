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
    columns = [np.ones(angle.size)]
    orders: list[int] = []
    if curve.arc_deg is None:
        for order in range(1, (angle.size - 1) // 2 + 1):
            pair = [np.cos(order * angle), np.sin(order * angle)]
            if not _separable(columns + pair):
                break
            columns += pair
            orders.append(order)
    half, seen_phase = None, 0.0
    if 2 * len(orders) + 2 == angle.size:
        seen_phase = angle[0] * (angle.size // 2)
        half = np.cos((angle.size // 2) * angle - seen_phase)
        if not _separable([*columns, half]):
            half = None
    design = np.column_stack(columns if half is None else [*columns, half])
    inverse = np.linalg.pinv(design)
    coefficient = inverse @ curve.error_arcsec
    u = None if curve.u_arcsec is None else np.sqrt(inverse**2 @ curve.u_arcsec**2)
    pairs = slice(1, 1 + 2 * len(orders))

    def split(values):
        cosine, sine = values[pairs][0::2], values[pairs][1::2]
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


def _separable(columns: list[np.ndarray]) -> bool:
    unit = np.column_stack([column / np.linalg.norm(column) for column in columns])
    return bool(np.linalg.cond(unit) <= SEPARABLE_CONDITION)
