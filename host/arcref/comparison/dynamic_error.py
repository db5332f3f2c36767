"""Splitting what an encoder under test shows at speed into an error of angle and a delay.

A reading that is t_d late shows the angle of t_d ago: at the speed v it reads v t_d too little (Yu Hai et al. 2015,
equation 2). The angle's own error E(angle) does not depend on speed. So

    difference = E(angle) + zero - v t_d + noise

is linear in the coefficients of E, a Fourier series, the zero and t_d, and one least squares gives all of them.
"""

from dataclasses import dataclass

import numpy as np

from arcref.comparison.paired_readings import PairedReadings
from arcref.input_error import InputError

ARCSEC_PER_TURN = 1_296_000.0

DEFAULT_HIGHEST_ORDER = 16

SMALLEST_SPEED_SPREAD_RPS = 1e-3
"""Speeds closer together than this cannot tell a delay from the zero."""

SPEED_GROUP = 0.03
"""Speeds within this part of each other are shown as one."""


@dataclass(frozen=True, eq=False)
class SpeedGroup:
    """What was seen at one speed: differences before and after the delay was taken off.

    `cosine_arcsec` and `sine_arcsec`: the error of angle by the strobes of this speed alone, None where they do not
    cover the turn; `apart_arcsec`: rms over the turn of that less the error by all strobes.
    """

    speed_rps: float
    strobes: int
    mean_arcsec: float
    rms_arcsec: float
    residual_rms_arcsec: float
    indices: np.ndarray
    cosine_arcsec: np.ndarray | None = None
    sine_arcsec: np.ndarray | None = None
    apart_arcsec: float | None = None


@dataclass(frozen=True, eq=False)
class DynamicError:
    """The result of a comparison.

    `delay_s` and `u_delay_s`, None when one speed alone was measured; `orders`: of the series, `cosine_arcsec` and
    `sine_arcsec` its coefficients; `covariance`: of [cosine..., sine..., zero, delay (arcsec per r/s)];
    `noise_arcsec`: standard deviation of one difference about the model.
    """

    pairs: PairedReadings
    orders: np.ndarray
    cosine_arcsec: np.ndarray
    sine_arcsec: np.ndarray
    zero_arcsec: float
    delay_s: float | None
    u_delay_s: float | None
    covariance: np.ndarray
    noise_arcsec: float
    groups: tuple[SpeedGroup, ...]

    def angle_error_arcsec(self, angle_deg) -> np.ndarray:
        """E at `angle_deg`, about its mean over the turn."""
        return self._basis(angle_deg) @ np.concatenate([self.cosine_arcsec, self.sine_arcsec])

    def angle_error_at_speed_arcsec(self, group: SpeedGroup, angle_deg) -> np.ndarray | None:
        """E at `angle_deg` by the strobes of one speed alone, None where they do not cover the turn."""
        if group.cosine_arcsec is None:
            return None
        return self._basis(angle_deg) @ np.concatenate([group.cosine_arcsec, group.sine_arcsec])

    @property
    def cautions(self) -> tuple[str, ...]:
        """Sentences about what may make the figures wrong."""
        period_s = self.pairs.strobe_spacing_s
        if self.delay_s is None or abs(self.delay_s) < 0.5 * period_s:
            return self.pairs.cautions
        return (
            *self.pairs.cautions,
            f"the delay is {self.delay_s / period_s:.2f} strobe periods: are the readings beside the right strobes? "
            "One that is missing at the start looks like a delay of one period",
        )

    def u_angle_error_arcsec(self, angle_deg) -> np.ndarray:
        """Standard uncertainty of E from the scatter of the readings, and from the reference where it is stated."""
        basis = self._basis(angle_deg)
        scatter = np.einsum("ij,jk,ik->i", basis, self.covariance[: basis.shape[1], : basis.shape[1]], basis)
        reference = self.pairs.reference_expanded_arcsec
        return np.sqrt(scatter + (0.0 if reference is None else (reference / 2) ** 2))

    def _basis(self, angle_deg) -> np.ndarray:
        phase = np.multiply.outer(np.radians(np.atleast_1d(angle_deg)), self.orders)
        return np.concatenate([np.cos(phase), np.sin(phase)], axis=-1)


def dynamic_error(pairs: PairedReadings, highest_order: int = DEFAULT_HIGHEST_ORDER) -> DynamicError:
    """Least squares of the model over all strobes. Raises `InputError` when they cannot carry so many orders."""
    orders = np.arange(1, highest_order + 1)
    unknowns = 2 * len(orders) + 2
    if len(pairs) < 2 * unknowns:
        raise InputError(
            f"{len(pairs)} strobes carry a series up to order {(len(pairs) // 2 - 2) // 2}, not {highest_order}: "
            "capture more, or choose --orders"
        )
    gap_deg = _largest_gap_deg(pairs.angle_deg)
    if gap_deg > 180.0 / highest_order:
        raise InputError(
            f"the strobes leave {gap_deg:.3g} deg of the turn unseen, a series up to order {highest_order} needs "
            f"gaps of {180.0 / highest_order:.3g} deg at most: let strobe and turn not be in step, or choose --orders"
        )
    phase = np.multiply.outer(np.radians(pairs.angle_deg), orders)
    columns = [np.cos(phase), np.sin(phase), np.ones((len(pairs), 1))]
    has_delay = bool(np.ptp(pairs.speed_rps) > max(SMALLEST_SPEED_SPREAD_RPS, 0.02 * np.abs(pairs.speed_rps).max()))
    if has_delay:
        columns.append(-pairs.speed_rps[:, np.newaxis])
    design = np.concatenate(columns, axis=1)
    solution, _, rank, _ = np.linalg.lstsq(design, pairs.difference_arcsec, rcond=None)
    if rank < design.shape[1]:
        raise InputError("the strobes lie at too few angles for the series: choose fewer --orders")
    residual = pairs.difference_arcsec - design @ solution
    noise = float(np.sqrt(residual @ residual / (len(pairs) - design.shape[1])))
    covariance = np.linalg.inv(design.T @ design) * noise**2
    per_rps = solution[-1] if has_delay else 0.0
    return DynamicError(
        pairs,
        orders,
        solution[: len(orders)],
        solution[len(orders) : 2 * len(orders)],
        float(solution[2 * len(orders)]),
        float(per_rps / ARCSEC_PER_TURN) if has_delay else None,
        float(np.sqrt(covariance[-1, -1]) / ARCSEC_PER_TURN) if has_delay else None,
        covariance,
        noise,
        tuple(_groups(pairs, residual, design[:, : 2 * len(orders)], solution[: 2 * len(orders)])),
    )


def _groups(pairs: PairedReadings, residual: np.ndarray, series: np.ndarray, common: np.ndarray):
    """Each speed's own figures. `series`: the columns of E in the design, `common`: its coefficients by all strobes."""
    order = np.argsort(pairs.speed_rps, kind="stable")
    speed = pairs.speed_rps[order]
    fastest = np.abs(speed).max()
    breaks = np.flatnonzero(np.diff(speed) > np.maximum(SPEED_GROUP * np.abs(speed[:-1]), 1e-4 * fastest)) + 1
    highest_order = len(common) // 2
    for indices in np.split(order, breaks):
        difference, left = pairs.difference_arcsec[indices], residual[indices]
        own: tuple = (None, None, None)
        covers = _largest_gap_deg(pairs.angle_deg[indices]) <= 180.0 / highest_order
        if covers and len(indices) >= 2 * (len(common) + 1):
            design = np.column_stack([series[indices], np.ones(len(indices))])
            apart = np.linalg.lstsq(design, left, rcond=None)[0][:-1]
            coefficients = common + apart
            own = coefficients[:highest_order], coefficients[highest_order:], float(np.sqrt(apart @ apart / 2))
        yield SpeedGroup(
            float(np.mean(pairs.speed_rps[indices])),
            len(indices),
            float(np.mean(difference)),
            float(np.std(difference)),
            float(np.sqrt(np.mean(left**2))),
            indices,
            *own,
        )


def _largest_gap_deg(angle_deg: np.ndarray) -> float:
    angle = np.sort(np.mod(angle_deg, 360.0))
    return float(np.max(np.diff(angle, append=angle[0] + 360.0)))
