"""A fine scan: one face before the autocollimator, the shaft moved in small steps through a few grating lines."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE
from arcref.calibration.stated_values import stated_plus_or_minus_one
from arcref.subdivision.line_wave import FEWEST_ORDERS, largest_phase_gap_rad, orders_told_apart, phase_rad
from arcref.subdivision.whole_counts import check_line_count, whole_counts

COUNT, AUTOCOLLIMATOR = "count", "autocollimator_x_arcsec"

FEWEST_READINGS = 24

LARGEST_X_ARCSEC = 3600.0

LARGEST_SCALE_ERROR = 0.05
"""How far x may be from following the counts one for one."""

_ARCSEC_PER_ARCMIN = 60.0


@dataclass(frozen=True, eq=False)
class FineScan:
    """Readings in their order: `count` and `x_arcsec`, float64[n]; `passage`: int[n], from 0, one for each way through.

    `sign`: +1 when x falls as the count grows, so that count + x is the error, -1 when it grows; `sign_basis`.
    """

    count: np.ndarray
    x_arcsec: np.ndarray
    passage: np.ndarray
    sign: int
    sign_basis: str

    @property
    def lines(self) -> float:
        """Grating lines that the scan spans."""
        return float(np.ptp(self.count)) / COUNTS_PER_LINE

    @property
    def phase_rad(self) -> np.ndarray:
        """Phase of each reading within its line: a count stands for its middle."""
        return phase_rad(self.count + 0.5)


def fine_scan_readings(run) -> FineScan:
    """The readings of a `RunFile` with columns `count,autocollimator_x_arcsec`.

    Raises `InputError` for counts that are not whole; too few readings; less than one grating line; a step back inside
    a passage (hysteresis would enter); phases that no reading stands near; x that does not follow the counts one for
    one, or whose sign is not the stated one.
    """
    check_line_count(run)
    count, x = whole_counts(run, COUNT), run[AUTOCOLLIMATOR]
    if count.size < FEWEST_READINGS:
        raise run.error(f"{count.size} readings, at least {FEWEST_READINGS} were expected")
    beyond = np.flatnonzero(np.abs(x) > LARGEST_X_ARCSEC)
    if beyond.size:
        problem = f"{x[beyond[0]]:g} arcsec, at most {LARGEST_X_ARCSEC:g} were expected"
        raise run.error(problem, reading=int(beyond[0]), column=AUTOCOLLIMATOR)
    if np.ptp(count) < COUNTS_PER_LINE * (1 - 1 / (2 * FEWEST_ORDERS + 1)):
        problem = f"the scan spans {np.ptp(count):.0f} counts, fewer than one grating line of {COUNTS_PER_LINE}"
        raise run.error(problem, column=COUNT)
    passage = _passages(run, count)
    sign, basis = _sign(run, count, x, passage)
    scan = FineScan(count, x, passage, sign, basis)
    if orders_told_apart(scan.phase_rad) < FEWEST_ORDERS:
        _refuse_gap(run, scan)
    return scan


def _passages(run, count: np.ndarray) -> np.ndarray:
    """Passages begin anew with a step back of more than half of the scan; a smaller one is a change of direction."""
    step = np.diff(count)
    far = np.abs(step) > 0.5 * np.ptp(count)
    direction = 1 if step[~far].sum() >= 0 else -1
    wrong = np.flatnonzero(~far & (step * direction < 0))
    if wrong.size:
        index = int(wrong[0]) + 1
        problem = (
            f"{count[index]:.0f} follows {count[index - 1]:.0f}: the scan changes its direction here, one was expected "
            "throughout, for the encoder's hysteresis would enter"
        )
        raise run.error(problem, reading=index, column=COUNT)
    return np.cumsum(np.append(False, far))


def _sign(run, count: np.ndarray, x: np.ndarray, passage: np.ndarray) -> tuple[int, str]:
    """The sign of x from the readings themselves, held against what the file states."""
    angle = count * ARCSEC_PER_COUNT
    for number in np.unique(passage):
        own = passage == number
        angle, x = (np.where(own, values - values[own].mean(), values) for values in (angle, x))
    slope = float(angle @ x / (angle @ angle))
    if abs(abs(slope) * _ARCSEC_PER_ARCMIN - 1) < LARGEST_SCALE_ERROR:
        raise run.error("x seems to be in minutes of arc, arcsec were expected", column=AUTOCOLLIMATOR)
    if abs(abs(slope) - 1) > LARGEST_SCALE_ERROR:
        problem = f"x changes by {slope:.3g} arcsec for each of the counts' arcsec, 1 or -1 was expected"
        raise run.error(f"{problem}: is it one face throughout, and the same shaft?", column=AUTOCOLLIMATOR)
    found, stated = (-1 if slope > 0 else 1), stated_plus_or_minus_one(run, "autocollimator_sign")
    if stated is not None and stated != found:
        problem = f"{stated:+d}, but x {'grows' if slope > 0 else 'falls'} with the counts, which is {found:+d}"
        raise run.metadata_error("autocollimator_sign", problem)
    return found, "by the run file and the readings" if stated else "by the readings: x against the counts"


def _refuse_gap(run, scan: FineScan) -> None:
    order = np.argsort(scan.phase_rad)
    ordered = scan.phase_rad[order]
    before = int(order[np.argmax(np.diff(ordered, append=ordered[0] + 2 * np.pi))])
    gap_counts = largest_phase_gap_rad(scan.phase_rad) * COUNTS_PER_LINE / (2 * np.pi)
    largest = COUNTS_PER_LINE / (2 * FEWEST_ORDERS + 1)
    problem = (
        f"a gap: behind this reading no phase of the line was read for {gap_counts:.0f} counts, at most "
        f"{largest:.0f} were expected"
    )
    raise run.error(problem, reading=before, column=COUNT)
