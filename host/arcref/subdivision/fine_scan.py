"""The error within a line from a fine scan of one face: count plus autocollimator, and what repeats with the line."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT
from arcref.subdivision.fine_scan_run import FineScan
from arcref.subdivision.line_wave import LineWave, orders_told_apart, wave_columns

MOST_ORDERS_OF_A_SCAN = 8
"""A scan has hundreds of readings, not hundreds of thousands: each order more costs some of them."""

_READINGS_A_COEFFICIENT = 2

LINES_FOR_A_BEND = 2.0
"""A scan of so many lines tells a bent drift from the lines' first order; a shorter one takes a straight drift."""


@dataclass(frozen=True, eq=False)
class FineScanWave:
    """What a fine scan gives.

    `wave`: the error within a line; `error_arcsec`: float64[n], count plus x of each reading, drift taken off;
    `residual_arcsec`: what the wave leaves of it; `noise_arcsec`: standard deviation of one reading, of
    `degrees_of_freedom`; `scale_error`: how much too large x reads, from its slope against the counts, mean of the
    passages, the encoder's own slope over the turn in it.
    """

    scan: FineScan
    wave: LineWave
    error_arcsec: np.ndarray
    residual_arcsec: np.ndarray
    noise_arcsec: float
    degrees_of_freedom: int
    scale_error: float
    drift_degree: int


def fine_scan(scan: FineScan, orders: int | None = None) -> FineScanWave:
    """The error within a line; `orders`: highest order, by default what the phases tell apart, 8 at most.

    Each passage has a drift of its own, a straight line or with two lines and more a parabola, in which the scale of
    the autocollimator and the encoder's error over the turn go.
    """
    angle = (scan.count + 0.5) * ARCSEC_PER_COUNT
    error = angle - angle[0] + scan.sign * (scan.x_arcsec - scan.x_arcsec[0])
    passages = int(scan.passage[-1]) + 1
    degree = 2 if scan.lines >= LINES_FOR_A_BEND else 1
    place = 2 * (angle - angle.min()) / np.ptp(angle) - 1
    own = scan.passage[:, np.newaxis] == np.arange(passages)
    drift = np.concatenate([own * place[:, np.newaxis] ** power for power in range(degree + 1)], axis=1)
    affordable = (error.size - drift.shape[1]) // (2 * (_READINGS_A_COEFFICIENT + 1))
    highest = orders or min(orders_told_apart(scan.phase_rad), MOST_ORDERS_OF_A_SCAN, max(affordable, 1))
    columns = np.concatenate([wave_columns(scan.phase_rad, highest), drift], axis=1)
    inverse = np.linalg.pinv(columns.T @ columns)
    found = inverse @ (columns.T @ error)
    residual = error - columns @ found
    freedom = error.size - columns.shape[1]
    noise = float(np.sqrt(residual @ residual / freedom))
    waves = slice(0, 2 * highest)
    slope = found[2 * highest + passages : 2 * highest + 2 * passages].mean() * 2 / np.ptp(angle)
    return FineScanWave(
        scan,
        LineWave(found[waves], noise**2 * inverse[waves, waves]),
        error - drift @ found[2 * highest :],
        residual,
        noise,
        freedom,
        # sign x falls by 1 + scale for each arcsec of the angle, so count + sign x falls by the scale's error.
        float(-slope),
        degree,
    )
