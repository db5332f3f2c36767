"""The radial basis function network that carries an error curve from the faces of a polygon to every angle.

Yu Hai et al., Chinese Optics 8(3) 2015 447-455, equations (5) to (7): a Gaussian about each face,
`exp(-ln 2 (d / c)^2)`, one half at the distance c. Two things differ from the print. The Gaussian is *wrapped*, summed
over the turns before and after, so that the curve has neither jump nor kink at 360 degrees. There is no output bias.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError

CONDITION_LIMIT = 1e9
"""Condition number beyond which a fit is refused: the weights then grow so large that their differences are noise."""

USABLE_SPREADS = (2 / 3, 1.5)
"""Usable spreads as parts of the face spacing: 10 to 22.5 degrees for 24 faces."""

WIDEST_SPREAD_DEG = 180.0
"""Half a turn. A wider Gaussian needs more images than the wrapped one sums, and is next to flat anyway."""

_IMAGES = 3
"""Turns before and after that the wrapped Gaussian sums over."""

# Angles evaluated at a time, so that the matrix of distances stays small.
_BLOCK = 1 << 14


def gaussian(difference_deg, spread_deg: float, wrapped: bool = True) -> np.ndarray:
    """The kernel at angle differences in degrees: 1 at 0, 0.5 at `spread_deg`; wrapped or plain."""
    difference = np.asarray(difference_deg, float)
    if not wrapped:
        return np.exp2(-((difference / spread_deg) ** 2))
    nearest = difference - 360.0 * np.round(difference / 360.0)
    total = np.exp2(-((nearest / spread_deg) ** 2))
    for image in range(1, _IMAGES + 1):
        # An image that stays below 2^-100 changes no bit of the sum; leaving it out saves most of the time.
        if (360.0 * image - 180.0) / spread_deg > 10.0:
            break
        for turn in (360.0 * image, -360.0 * image):
            total += np.exp2(-(((nearest + turn) / spread_deg) ** 2))
    return total


@dataclass(frozen=True, eq=False)
class RadialBasisNetwork:
    """A fitted network.

    `centre_deg`, `weight_arcsec`, `error_arcsec`: float64[n]; `spread_deg` is c; `ridge` is the lambda added to the
    diagonal, 0 for exact interpolation; `condition_number` is that of the matrix solved.
    """

    centre_deg: np.ndarray
    error_arcsec: np.ndarray
    weight_arcsec: np.ndarray
    spread_deg: float
    ridge: float
    wrapped: bool
    condition_number: float
    _inverse: np.ndarray = field(repr=False)

    @classmethod
    def fit(
        cls, curve: ErrorCurve, spread_deg: float | None = None, ridge: float = 0.0, wrapped: bool = True
    ) -> "RadialBasisNetwork":
        """Fit a network with one centre at each face of `curve`.

        `spread_deg` defaults to the face spacing. Raises `InputError` for a spread that is not positive, a ridge below
        zero, and a spread so wide that the matrix is badly conditioned.
        """
        spacing = curve.spacing_deg
        spread = spacing if spread_deg is None else float(spread_deg)
        if not 0.0 < spread < np.inf:
            raise InputError(f"the spread is {spread:g} deg, a positive number was expected")
        if not 0.0 <= ridge < np.inf:
            raise InputError(f"the ridge is {ridge:g}, zero or a positive number was expected")
        centre = np.asarray(curve.angle_deg, float)
        matrix = gaussian(centre[:, np.newaxis] - centre, spread, wrapped) + ridge * np.eye(centre.size)
        condition = float(np.linalg.cond(matrix)) if spread <= WIDEST_SPREAD_DEG else np.inf
        if not condition <= CONDITION_LIMIT:
            low, high = (factor * spacing for factor in USABLE_SPREADS)
            # Double precision cannot tell larger condition numbers apart.
            shown = f"{condition:.1e}" if condition < 1e16 else "above 1e+16"
            raise InputError(
                f"a spread c of {spread:g} deg is badly conditioned (condition number {shown}, the limit is "
                f"{CONDITION_LIMIT:.0e}); with faces {spacing:g} deg apart, {low:.3g} to {high:.3g} deg is usable"
            )
        inverse = np.linalg.inv(matrix)
        error = np.asarray(curve.error_arcsec, float)
        weight = np.linalg.solve(matrix, error)
        return cls(centre, error, weight, spread, float(ridge), wrapped, condition, inverse)

    def evaluate(self, angle_deg) -> np.ndarray:
        """The error in arcsec at `angle_deg`, degrees of the turn, in an array of the same shape."""
        angle = np.asarray(angle_deg, float)
        flat = angle.ravel()
        result = np.empty(flat.size)
        for start in range(0, flat.size, _BLOCK):
            block = slice(start, start + _BLOCK)
            difference = flat[block, np.newaxis] - self.centre_deg
            result[block] = gaussian(difference, self.spread_deg, self.wrapped) @ self.weight_arcsec
        return result.reshape(angle.shape)

    def weights(self, angle_deg) -> np.ndarray:
        """The weight of each face's error in the value at the angles float64[m]: float64[m, n]."""
        difference = np.asarray(angle_deg, float)[:, np.newaxis] - self.centre_deg
        return gaussian(difference, self.spread_deg, self.wrapped) @ self._inverse

    @cached_property
    def residual_arcsec(self) -> np.ndarray:
        """Error given minus error fitted at each face, float64[n]: rounding alone when the ridge is 0."""
        return self.error_arcsec - self.evaluate(self.centre_deg)

    @cached_property
    def leave_one_out_arcsec(self) -> np.ndarray:
        """Error of each face minus what a network fitted to all other faces says there, float64[n].

        In closed form, weight / diagonal of the inverse. It guards against an unsuitable spread; it does not rank
        fits that are close, and it is no uncertainty.
        """
        return self.weight_arcsec / np.diag(self._inverse)

    @property
    def leave_one_out_rms_arcsec(self) -> float:
        """Root mean square of `leave_one_out_arcsec`."""
        return float(np.sqrt(np.mean(self.leave_one_out_arcsec**2)))
