"""Tower tilt: the polygon's axis does not stand along the encoder's, so both readings of the autocollimator change.

Source: Tian Liude et al., Acta Optica Sinica 35(5) 2015 0512003. Frame, fixed to the start position: X is the outward
normal of face 1, towards the autocollimator; Z is the polygon's axis, upwards; Y completes the right-handed frame. The
encoder's axis leans by psi from Z towards the azimuth omega, which counts from X towards Y, so towards face 2. When
the encoder has gone forward by theta, the face whose normal stood at theta looks into the autocollimator.

The exact model is a rotation about the encoder's axis (Rodrigues). The paper's printed equation (5) lacks the term
`- sin psi cos omega sin^2 theta`; with it the paper's components (3) to (5) agree with the rotation.

Every function broadcasts; in `fit_tilt` and in whatever comes of it the last axis is that of the readings.
"""

from dataclasses import dataclass

import numpy as np

ARCSEC_PER_RADIAN = 180.0 * 3600.0 / np.pi

FEWEST_ANGLES = 3

# The model is linear to about psi^2 / 2, so each step gains four digits or more: three reach the last one.
_GAUSS_NEWTON_STEPS = 4


def facing_normal(theta_deg, psi_arcsec, omega_deg) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit normal of the face that looks at the autocollimator at theta: its parts toward it, sideways (Y) and up."""
    theta, omega = np.radians(theta_deg), np.radians(omega_deg)
    psi = np.asarray(psi_arcsec) / ARCSEC_PER_RADIAN
    x, y = np.cos(theta), np.sin(theta)
    axis_x, axis_y, axis_z = np.sin(psi) * np.cos(omega), np.sin(psi) * np.sin(omega), np.cos(psi)
    # Rodrigues for the normal (x, y, 0), turned by -theta about the axis.
    along = (axis_x * x + axis_y * y) * (1.0 - x)
    toward = x * x + axis_z * y * y + axis_x * along
    sideways = y * x - axis_z * x * y + axis_y * along
    up = -(axis_x * y - axis_y * x) * y + axis_z * along
    return toward, sideways, up


def horizontal_reading_arcsec(theta_deg, psi_arcsec, omega_deg):
    """What the tilt adds to the autocollimator's x at theta, positive towards Y; 0 at theta = 0.

    A perfect encoder reduced with the right sign of x then shows this as its error.
    """
    toward, sideways, _ = facing_normal(theta_deg, psi_arcsec, omega_deg)
    return np.arctan2(sideways, toward) * ARCSEC_PER_RADIAN


def vertical_reading_arcsec(theta_deg, psi_arcsec, omega_deg):
    """What the tilt adds to the autocollimator's y at theta, positive upwards; 0 at theta = 0, largest at omega."""
    toward, _, up = facing_normal(theta_deg, psi_arcsec, omega_deg)
    return np.arctan2(up, toward) * ARCSEC_PER_RADIAN


@dataclass(frozen=True, eq=False)
class TowerTilt:
    """A tilt found from y readings; each number is an array when the readings had leading axes.

    `psi_arcsec`, `omega_deg` (-180 .. 180): the tilt and its azimuth; `offset_arcsec`: y of face 1 by the fit;
    `residual_arcsec`, float64[..., n]: y minus the model, which holds noise and the faces' own tilts;
    `sigma_arcsec`: standard deviation of the residual; `u_psi_arcsec`, `u_omega_deg`: standard uncertainties that
    follow from it, nan without degrees of freedom (three angles); an azimuth is never less certain than an unknown one.
    """

    psi_arcsec: float | np.ndarray
    omega_deg: float | np.ndarray
    u_psi_arcsec: float | np.ndarray
    u_omega_deg: float | np.ndarray
    offset_arcsec: float | np.ndarray
    residual_arcsec: np.ndarray
    sigma_arcsec: float | np.ndarray
    degrees_of_freedom: int

    def horizontal_arcsec(self, theta_deg) -> np.ndarray:
        """What this tilt adds to x at each of `theta_deg`, float64[..., n]."""
        return horizontal_reading_arcsec(theta_deg, *self._columns())

    def vertical_arcsec(self, theta_deg) -> np.ndarray:
        """What this tilt adds to y at each of `theta_deg`, float64[..., n], the offset left out."""
        return vertical_reading_arcsec(theta_deg, *self._columns())

    def _columns(self) -> tuple[np.ndarray, np.ndarray]:
        return np.asarray(self.psi_arcsec)[..., np.newaxis], np.asarray(self.omega_deg)[..., np.newaxis]


UNKNOWN_AZIMUTH_U_DEG = 180.0 / np.sqrt(3.0)
"""Standard uncertainty of an azimuth about which nothing is known: rectangular over the turn."""


def fit_tilt(theta_deg, y_arcsec) -> TowerTilt:
    """Tilt and azimuth by least squares of the exact model with a free offset.

    `theta_deg`: float64[n]; `y_arcsec`: float64[..., n]. The linear law a cos + b sin + c (equation 13) is the start,
    Gauss-Newton steps on the exact model the answer. Raises `ValueError` when fewer than three angles differ.
    """
    theta_deg, y_arcsec = np.asarray(theta_deg, float), np.asarray(y_arcsec, float)
    theta = np.radians(theta_deg)
    design = np.stack([np.cos(theta) - 1.0, np.sin(theta), np.ones_like(theta)], axis=-1)
    if np.linalg.matrix_rank(design, tol=1e-9) < FEWEST_ANGLES:
        raise ValueError("a tilt needs y at three different angles or more")
    solve = np.linalg.pinv(design)
    unknowns = np.zeros((*y_arcsec.shape[:-1], 3))
    residual = y_arcsec
    for _ in range(_GAUSS_NEWTON_STEPS):
        unknowns = unknowns + residual @ solve.T
        psi = np.hypot(unknowns[..., 0], unknowns[..., 1])
        omega_deg = np.degrees(np.arctan2(unknowns[..., 1], unknowns[..., 0]))
        model = vertical_reading_arcsec(theta_deg, psi[..., np.newaxis], omega_deg[..., np.newaxis])
        residual = y_arcsec - model - unknowns[..., 2:]
    freedom = len(theta) - 3
    sum_of_squares = (residual**2).sum(axis=-1)
    sigma = np.sqrt(sum_of_squares / freedom) if freedom else np.full_like(sum_of_squares, np.nan)
    # Along the tilt and across it: the covariance of (a, b), turned by omega.
    covariance = (solve @ solve.T)[:2, :2]
    cosine, sine = np.cos(np.radians(omega_deg)), np.sin(np.radians(omega_deg))
    along, across = np.stack([cosine, sine], axis=-1), np.stack([-sine, cosine], axis=-1)
    u_psi = sigma * np.sqrt(np.einsum("...i,ij,...j", along, covariance, along))
    u_across = sigma * np.sqrt(np.einsum("...i,ij,...j", across, covariance, across))
    with np.errstate(divide="ignore", invalid="ignore"):
        u_omega = np.fmin(np.degrees(u_across / psi), np.where(np.isnan(sigma), np.nan, UNKNOWN_AZIMUTH_U_DEG))
    numbers = (psi, omega_deg, u_psi, u_omega, unknowns[..., 2])
    if y_arcsec.ndim == 1:
        numbers = tuple(map(float, numbers))
        sigma = float(sigma)
    return TowerTilt(*numbers, residual, sigma, freedom)
