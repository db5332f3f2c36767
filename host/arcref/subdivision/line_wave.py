"""The error within a grating line as a sum of waves over the phase of the reading, estimated from counts."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import COUNTS_PER_LINE
from arcref.correction_rom import SUBDIVISION_CELL_COUNTS, SUBDIVISION_ENTRIES

MOST_ORDERS = 16
"""Highest order within a line that is looked for: signals of a grating have little beyond order 6."""

FEWEST_ORDERS = 4
"""Orders 1 (offset), 2 (gain, quadrature) and 4 (third harmonics) are what every encoder has."""


def phase_rad(reading_counts) -> np.ndarray:
    """Phase within the line, 0 .. 2 pi, of readings in counts; zero where the count is a multiple of a line."""
    return np.mod(reading_counts, COUNTS_PER_LINE) * (2 * np.pi / COUNTS_PER_LINE)


def cell_middles_deg() -> np.ndarray:
    """The phases, in degrees of a line, at which the entries of the second table stand, float64[512]."""
    cells = np.arange(SUBDIVISION_ENTRIES) + 0.5
    return cells * (SUBDIVISION_CELL_COUNTS * 360.0 / COUNTS_PER_LINE)


def wave_columns(phases_rad, orders: int) -> np.ndarray:
    """Sines, then cosines of orders 1 .. `orders`, float64[n, 2 orders]."""
    angle = np.multiply.outer(np.asarray(phases_rad, float), np.arange(1, orders + 1))
    return np.concatenate([np.sin(angle), np.cos(angle)], axis=-1)


def largest_phase_gap_rad(phases_rad) -> float:
    """Widest stretch of the line without a reading."""
    ordered = np.sort(np.asarray(phases_rad, float))
    return float(np.diff(ordered, append=ordered[0] + 2 * np.pi).max())


def orders_told_apart(phases_rad) -> int:
    """Highest order that readings at these phases tell apart, `MOST_ORDERS` at most; 0 when they cannot tell any."""
    # Distances that should be equal differ in their last digits.
    apart = int(2 * np.pi / largest_phase_gap_rad(phases_rad) * (1 + 1e-9))
    return min(MOST_ORDERS, (apart - 1) // 2)


@dataclass(frozen=True, eq=False)
class LineWave:
    """The error (reading - true angle) over a line: sum of s_k sin(k phase) + c_k cos(k phase), without a mean.

    `coefficients_arcsec`: float64[2 orders], s_1 .. s_n, c_1 .. c_n; `covariance_arcsec2`: float64[2 orders, 2 orders].
    """

    coefficients_arcsec: np.ndarray
    covariance_arcsec2: np.ndarray

    @property
    def orders(self) -> int:
        """Highest order."""
        return self.coefficients_arcsec.size // 2

    @property
    def amplitude_arcsec(self) -> np.ndarray:
        """Amplitude of each order, float64[orders]."""
        return np.hypot(*self.coefficients_arcsec.reshape(2, -1))

    @property
    def phase_of_order_deg(self) -> np.ndarray:
        """Phase of each order as of a sine, float64[orders]: amplitude sin(k phase + this)."""
        sine, cosine = self.coefficients_arcsec.reshape(2, -1)
        return np.degrees(np.arctan2(cosine, sine))

    def error_arcsec(self, phases_rad) -> np.ndarray:
        """The error at these phases."""
        return wave_columns(phases_rad, self.orders) @ self.coefficients_arcsec

    def u_arcsec(self, phases_rad) -> np.ndarray:
        """Standard uncertainty of the error at these phases, as the scatter of the readings shows it."""
        columns = wave_columns(phases_rad, self.orders)
        return np.sqrt(np.maximum(np.einsum("...i,ij,...j", columns, self.covariance_arcsec2, columns), 0.0))
