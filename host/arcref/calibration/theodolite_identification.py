"""Where axis and mirror stand, from the elevations of the mirror's normal: closed form first, then least squares."""

import numpy as np

from arcref.calibration.theodolite_model import MirrorGeometry, along_of

_MOST_STEPS = 50
_SMALLEST_STEP = 1e-13
_MOST_HALVINGS = 40


def closed_form(theta_rad, elevation_rad) -> MirrorGeometry:
    """The geometry from elevations at the angles `theta_rad`, float64[..., n] both, without iteration.

    sin E = P0 + P1 sin theta + P2 (1 - cos theta) is linear; omega = asin P0, across = P1 / cos omega, and `along_of`
    gives the axis nearest to upright. Least squares in sin E, so it differs a little from least squares in E. NaN where
    the readings fit no axis.
    """
    theta, sine = np.broadcast_arrays(theta_rad, np.sin(elevation_rad))
    columns = np.stack([np.ones_like(theta), np.sin(theta), 1.0 - np.cos(theta)], axis=-1)
    p0, p1, p2 = np.moveaxis(_solve_least_squares(columns, sine), -1, 0)
    with np.errstate(invalid="ignore"):
        omega = np.arcsin(p0)
    across = p1 / np.cos(omega)
    along, upright = along_of(p2, across, omega)[0]
    return MirrorGeometry(across, along, omega, upright)


def least_squares(theta_rad, elevation_rad, start: MirrorGeometry | None = None) -> MirrorGeometry:
    """The geometry with the least sum of squared elevation residuals, by Gauss and Newton from `start`.

    Shapes as in `closed_form`, whose answer is the start unless one is given. A step is halved while it would raise
    the sum or leave alpha < 90 deg. NaN where it does not converge.
    """
    start = closed_form(theta_rad, elevation_rad) if start is None else start
    parameters = np.broadcast_to(start.parameters, np.shape(elevation_rad)[:-1] + (3,)).copy()
    for _ in range(_MOST_STEPS):
        geometry = _geometry(parameters)
        residual = elevation_rad - geometry.elevation_rad(theta_rad)
        step = _solve_least_squares(geometry.derivatives(theta_rad).elevation_by_parameters, residual)
        step = _shortened(parameters, step, np.sum(residual**2, axis=-1), theta_rad, elevation_rad)
        parameters = parameters + step
        if not (np.abs(step) > _SMALLEST_STEP).any():
            return _geometry(parameters)
    unfinished = (np.abs(step) > 1e-9).any(axis=-1)
    parameters[unfinished] = np.nan
    return _geometry(parameters)


def parameter_covariance(geometry: MirrorGeometry, theta_rad) -> np.ndarray:
    """float64[..., 3, 3]: of across, along and omega (rad), for elevations of variance 1 at these angles."""
    jacobian = geometry.derivatives(theta_rad).elevation_by_parameters
    return np.linalg.inv(np.swapaxes(jacobian, -1, -2) @ jacobian)


def angles_by_parameters(geometry: MirrorGeometry) -> np.ndarray:
    """float64[..., 3, 3]: alpha, delta, omega (rad) by across, along, omega. Infinite at alpha = 0."""
    across, along, up = np.asarray(geometry.across), np.asarray(geometry.along), np.asarray(geometry.up)
    size = np.hypot(across, along)
    zero, one = np.zeros_like(size), np.ones_like(size)
    with np.errstate(divide="ignore", invalid="ignore"):
        rows = [
            [across / (size * up), along / (size * up), zero],
            [along / size**2, -across / size**2, zero],
            [zero, zero, one],
        ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _geometry(parameters: np.ndarray) -> MirrorGeometry:
    return MirrorGeometry(*np.moveaxis(parameters, -1, 0))


def _solve_least_squares(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """float64[..., k]: least squares of `columns` [..., n, k] to `values` [..., n], columns scaled to unit length."""
    size = np.sqrt(np.sum(columns**2, axis=-2, keepdims=True))
    scaled = columns / np.where(size > 0, size, 1.0)
    # QR rather than normal equations: over a short arc the columns are all but parallel.
    q, r = np.linalg.qr(scaled)
    right = np.swapaxes(q, -1, -2) @ values[..., np.newaxis]
    return np.linalg.solve(r, right)[..., 0] / np.where(size > 0, size, 1.0)[..., 0, :]


def _shortened(parameters, step, square, theta_rad, elevation_rad) -> np.ndarray:
    """The steps, each halved until the sum of squares, `square` before it, does not rise; NaN if it always does."""
    step = np.where(np.isfinite(step), step, np.nan)
    for _ in range(_MOST_HALVINGS):
        inside = np.sum((parameters + step)[..., :2] ** 2, axis=-1) < 0.999
        new = _geometry(np.where(inside[..., np.newaxis], parameters + step, parameters))
        rises = np.sum((elevation_rad - new.elevation_rad(theta_rad)) ** 2, axis=-1) > square * (1 + 1e-9) + 1e-28
        too_long = (rises | ~inside) & np.isfinite(step).all(axis=-1)
        if not too_long.any():
            return step
        step = np.where(too_long[..., np.newaxis], step / 2, step)
    return np.where(too_long[..., np.newaxis], np.nan, step)
