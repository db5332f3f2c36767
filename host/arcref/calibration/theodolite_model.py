"""The mirror on the shaft as an autocollimating theodolite sees it: Wang Tao et al., Acta Optica Sinica 38(5) 2018.

The theodolite reads the direction of the mirror's normal: azimuth A, clockwise seen from above, 0 at theta = 0, and
elevation E = zenith reading - 90 deg, positive where the theodolite looks down. The shaft turns clockwise by theta.

`alpha` is the angle of the shaft's axis to the mirror's upright, `delta` the azimuth of its projection from the normal,
`omega` the elevation of the normal at theta = 0. Delta is meant as the printed equations (1), (3)-(5) have it,
counter-clockwise seen from above; the paper's text says clockwise, and its 3 x 3 matrix is no rotation.

The geometry is kept as `across = sin alpha sin delta`, `along = sin alpha cos delta` and `omega`, which stay well
defined where alpha is 0 and delta is not. With s = sin theta, v = 1 - cos theta and up = cos alpha the normal is
X = up s - across along v, Y = 1 - v + along^2 v, Z = across s + along up v, then tilted by omega about X.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

LARGEST_ALPHA_DEG = 45.0
"""Four axes give the very same elevations; only one of them lies within this angle of the mirror's upright."""


@dataclass(frozen=True, eq=False)
class MirrorGeometry:
    """Axis and mirror; the fields are floats or arrays of one shape [...], angles go with shape [..., n].

    `upright` is the sign of cos alpha, -1 only for an axis that points down.
    """

    across: np.ndarray
    along: np.ndarray
    omega_rad: np.ndarray
    upright: np.ndarray = 1.0

    @classmethod
    def from_angles(cls, alpha_deg, delta_deg, omega_deg) -> "MirrorGeometry":
        """The geometry of these angles, delta in the sense of the printed equations."""
        alpha, delta, omega = (np.radians(angle) for angle in (alpha_deg, delta_deg, omega_deg))
        upright = np.where(np.cos(alpha) < 0, -1.0, 1.0)
        return cls(np.sin(alpha) * np.sin(delta), np.sin(alpha) * np.cos(delta), omega, upright)

    @property
    def alpha_deg(self):
        """Angle of the shaft's axis to the mirror's upright, 0 .. 180 deg."""
        alpha = np.degrees(np.arctan2(np.hypot(self.across, self.along), self.up))
        return alpha

    @property
    def delta_deg(self):
        """Azimuth of the axis, 0 .. 360 deg, in the sense of the printed equations; no meaning where alpha is 0."""
        return np.mod(np.degrees(np.arctan2(self.across, self.along)), 360.0)

    @property
    def omega_deg(self):
        """Elevation of the mirror's normal at theta = 0."""
        return np.degrees(self.omega_rad)

    @cached_property
    def up(self):
        """cos alpha."""
        square = 1.0 - np.asarray(self.across) ** 2 - np.asarray(self.along) ** 2
        return self.upright * np.sqrt(np.maximum(square, 0.0))

    @property
    def parameters(self) -> np.ndarray:
        """float64[..., 3]: across, along, omega (rad)."""
        return np.stack(np.broadcast_arrays(self.across, self.along, self.omega_rad), axis=-1).astype(float)

    def normal(self, theta_rad) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """x, y, z of the mirror's normal at `theta_rad` [..., n]: right, away from the mirror, up (equation 2)."""
        across, along, up, sine, cosine = self._columns()
        s, v = np.sin(theta_rad), 1.0 - np.cos(theta_rad)
        forward, upward = 1.0 - v + along**2 * v, across * s + along * up * v
        return up * s - across * along * v, cosine * forward - sine * upward, sine * forward + cosine * upward

    def azimuth_rad(self, theta_rad) -> np.ndarray:
        """Azimuth of the normal, -pi .. pi (equation 4; its arctangent needs both signs)."""
        x, y, _ = self.normal(theta_rad)
        return np.arctan2(x, y)

    def elevation_rad(self, theta_rad) -> np.ndarray:
        """Elevation of the normal (equation 5)."""
        x, y, z = self.normal(theta_rad)
        return np.arctan2(z, np.hypot(x, y))

    def theta_rad(self, azimuth_rad) -> np.ndarray:
        """The shaft's true angle at which the normal has these azimuths [..., n], the one nearest to them.

        sin A * y = cos A * x is linear in sin and cos of theta, so the inversion is exact. NaN where no angle of the
        shaft gives that azimuth.
        """
        across, along, up, sine, cosine = self._columns()
        sa, ca = np.sin(azimuth_rad), np.cos(azimuth_rad)
        # cos A * x - sin A * y = constant + of_sine * sin theta + of_cosine * cos theta = 0
        x_v, y_v, y_s = -across * along, cosine * (along**2 - 1.0) - sine * along * up, -sine * across
        of_sine = ca * up - sa * y_s
        of_cosine = -(ca * x_v - sa * y_v)
        constant = ca * x_v - sa * (cosine + y_v)
        size = np.hypot(of_sine, of_cosine)
        with np.errstate(invalid="ignore"):
            half = np.arccos(-constant / size)
        middle = np.arctan2(of_sine, of_cosine)
        first, second = (_near(middle + sign * half, azimuth_rad) for sign in (-1.0, 1.0))
        x, y, _ = self.normal(first)
        return np.where(x * sa + y * ca > 0, first, second)

    def derivatives(self, theta_rad) -> "MirrorDerivatives":
        """How azimuth and elevation change with theta and with the parameters, at `theta_rad` [..., n]."""
        across, along, up, sine, cosine = self._columns()
        s, c = np.sin(theta_rad), np.cos(theta_rad)
        v = 1.0 - c
        zero = np.zeros_like(s * across)
        # Columns: across, along, omega (before the tilt: none), theta.
        d_x = [-across / up * s - along * v, -along / up * s - across * v, zero, up * c - across * along * s]
        d_forward = [zero, 2 * along * v, zero, (along**2 - 1.0) * s]
        d_upward = [
            s - across * along / up * v,
            (up - along**2 / up) * v,
            zero,
            across * c + along * up * s,
        ]
        x, y, z = self.normal(theta_rad)
        d_y = [cosine * f - sine * u for f, u in zip(d_forward, d_upward, strict=True)]
        d_z = [sine * f + cosine * u for f, u in zip(d_forward, d_upward, strict=True)]
        d_y[2], d_z[2] = -z, y
        level = np.hypot(x, y)
        azimuth = [(y * dx - x * dy) / level**2 for dx, dy in zip(d_x, d_y, strict=True)]
        elevation = [dz / level for dz in d_z]
        return MirrorDerivatives(
            np.stack(np.broadcast_arrays(*azimuth[:3]), axis=-1),
            azimuth[3],
            np.stack(np.broadcast_arrays(*elevation[:3]), axis=-1),
            elevation[3],
        )

    def twins(self) -> tuple["MirrorGeometry", ...]:
        """All four geometries whose elevations are those of this one at every theta, itself among them.

        Three numbers are all that the elevations tell: sin E = P0 + P1 sin theta + P2 (1 - cos theta).
        """
        sine, cosine = np.sin(self.omega_rad), np.cos(self.omega_rad)
        p2 = -sine * (1.0 - self.along**2) + cosine * self.along * self.up
        return tuple(
            MirrorGeometry(self.across, along, self.omega_rad, upright)
            for along, upright in along_of(p2, self.across, self.omega_rad)
        )

    def _columns(self):
        """Across, along, up and sine and cosine of omega, each [..., 1]."""
        values = (self.across, self.along, self.up, np.sin(self.omega_rad), np.cos(self.omega_rad))
        return (np.asarray(value, float)[..., np.newaxis] for value in values)


@dataclass(frozen=True, eq=False)
class MirrorDerivatives:
    """Derivatives of azimuth and elevation: by across, along, omega, float64[..., n, 3], and by theta, [..., n]."""

    azimuth_by_parameters: np.ndarray
    azimuth_by_theta: np.ndarray
    elevation_by_parameters: np.ndarray
    elevation_by_theta: np.ndarray

    @property
    def theta_by_parameters(self) -> np.ndarray:
        """float64[..., n, 3]: of the true angle found from a given azimuth."""
        return -self.azimuth_by_parameters / self.azimuth_by_theta[..., np.newaxis]


def along_of(p2, across, omega_rad) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """The four (along, sign of cos alpha) that fulfil P2 = -sin om (1 - along^2) + cos om along up, [...] each.

    The first is the one nearest to alpha = 0 with the axis upwards. Squared, the equation is quadratic in along^2, so
    no iteration is needed. NaN where P2 is larger than any axis gives.
    """
    sine, cosine = np.sin(omega_rad), np.cos(omega_rad)
    k = p2 + sine
    middle = cosine**2 * (1.0 - across**2) + 2.0 * k * sine
    with np.errstate(invalid="ignore"):
        root = np.sqrt(middle**2 - 4.0 * k**2)
    solutions = []
    for square in (2.0 * k**2 / (middle + root), (middle + root) / 2.0):
        along = np.sqrt(square)
        product = (k - sine * square) / cosine  # along * up
        sign = np.where(product < 0, -1.0, 1.0)
        solutions += [(sign * along, np.ones_like(along)), (-sign * along, -np.ones_like(along))]
    return tuple(solutions)


def _near(angle_rad, to_rad) -> np.ndarray:
    """`angle_rad` by whole turns nearest to `to_rad`."""
    return angle_rad - 2.0 * np.pi * np.rint((angle_rad - to_rad) / (2.0 * np.pi))
