"""What every fit of an error curve is: its value at every angle, and how sure that is.

Each fit is a linear smoother: once its parameters are set, the value at an angle is a weighted sum of the errors at the
faces. So the uncertainty of the faces travels to every angle exactly, leaving a face out can be done exactly, and a
Monte Carlo of a thousand runs is one matrix product, `error_arcsec @ fit.weights(angle_deg).T`.
"""

from abc import ABC, abstractmethod
from dataclasses import replace
from functools import cached_property

import numpy as np

from arcref.calibration.fits.curve_modes import curve_modes
from arcref.error_curve import ErrorCurve

# Angles evaluated at a time, so that the matrix of weights stays small.
_BLOCK = 1 << 12

# Rounding of an angle must not put the arc's last reading outside it: a hundredth of a count.
_ARC_EDGE_DEG = 4e-7


class FittedCurve(ABC):
    """A curve fitted to an `ErrorCurve`.

    `curve` is what was fitted; `name` the fit's name for options and files; `title` its name for people; `parameters`
    its numbers, ready for JSON, enough to make the same fit again. When only an arc was measured the fit is 0 outside
    of it, and its uncertainty there is not a number.
    """

    name: str
    title: str

    def __init__(self, curve: ErrorCurve, parameters: dict):
        self.curve = curve
        self.parameters = parameters

    @abstractmethod
    def _weights(self, angle_deg: np.ndarray) -> np.ndarray:
        """Weights float64[m, n] at the angles float64[m], which lie in the arc when only an arc was measured."""

    @abstractmethod
    def _refitted(self, curve: ErrorCurve) -> "FittedCurve":
        """The same fit, with the same parameters, to other faces."""

    def covers(self, angle_deg) -> np.ndarray:
        """True at the angles that were measured: everywhere, or inside the arc; an array of the same shape."""
        angle = np.asarray(angle_deg, float)
        if self.curve.arc_deg is None:
            return np.ones(angle.shape, bool)
        first, last = self.curve.arc_deg
        return np.mod(angle - first + _ARC_EDGE_DEG, 360.0) <= last - first + 2 * _ARC_EDGE_DEG

    def weights(self, angle_deg) -> np.ndarray:
        """The weight of each face's error in the value at `angle_deg`, float64[..., n]; all 0 outside the arc."""
        angle = np.asarray(angle_deg, float)
        flat = angle.ravel()
        weights = np.zeros((flat.size, self.curve.angle_deg.size))
        covered = self.covers(flat)
        weights[covered] = self._weights(self._along_arc(flat[covered]))
        return weights.reshape(*angle.shape, -1)

    def evaluate(self, angle_deg) -> np.ndarray:
        """The error in arcsec at `angle_deg`, degrees of the turn, in an array of the same shape."""
        return self._by_blocks(angle_deg, lambda block: self.weights(block) @ self.curve.error_arcsec)

    @cached_property
    def residual_arcsec(self) -> np.ndarray:
        """Error given minus error fitted at each face, float64[n]."""
        return self.curve.error_arcsec - self.evaluate(self.curve.angle_deg)

    @cached_property
    def leave_one_out_arcsec(self) -> np.ndarray:
        """Error of each face minus what the same fit to all other faces says there, float64[n].

        Parameters stay as they are. It guards against an unsuitable fit; it does not rank fits that are close, and it
        is no uncertainty.
        """
        curve = self.curve
        left_out = np.empty(curve.angle_deg.size)
        for face in range(left_out.size):
            others = np.arange(left_out.size) != face
            u = None if curve.u_arcsec is None else curve.u_arcsec[others]
            rest = replace(
                curve,
                angle_deg=curve.angle_deg[others],
                error_arcsec=curve.error_arcsec[others],
                u_arcsec=u,
                places=None,
            )
            left_out[face] = curve.error_arcsec[face] - self._refitted(rest).evaluate(curve.angle_deg[face])
        return left_out

    @property
    def leave_one_out_rms_arcsec(self) -> float:
        """Root mean square of `leave_one_out_arcsec`."""
        return float(np.sqrt(np.mean(self.leave_one_out_arcsec**2)))

    def u_arcsec(self, angle_deg, covariance_arcsec2=None) -> np.ndarray | None:
        """Standard uncertainty (k=1) of the value at `angle_deg` that comes from that of the faces, in the same shape.

        The faces' errors are taken as uncorrelated, with the curve's `u_arcsec`, unless `covariance_arcsec2`,
        float64[n, n], says otherwise. None when neither is known; not a number outside the arc. What the curve may do
        between the faces is no part of it: see `interpolation_u_arcsec`.
        """
        if covariance_arcsec2 is None:
            if self.curve.u_arcsec is None:
                return None
            covariance_arcsec2 = np.diag(self.curve.u_arcsec**2)
        covariance = np.asarray(covariance_arcsec2, float)

        def propagated(block):
            weights = self.weights(block)
            variance = np.einsum("mi,ij,mj->m", weights, covariance, weights, optimize=True)
            return np.where(self.covers(block), np.sqrt(np.maximum(variance, 0.0)), np.nan)

        return self._by_blocks(angle_deg, propagated)

    def interpolation_u_arcsec(self, angle_deg) -> np.ndarray:
        """Standard uncertainty (k=1) of the value at `angle_deg` from the fit itself, in the same shape.

        It is what the fit makes of the curve's own harmonics, each with the power that the faces show beyond their
        noise and with a phase that may be any: 0 at the faces of an interpolating fit, largest midway. Orders beyond
        half the number of faces are unseen and no part of it. Not a number outside the arc.
        """
        modes = self._modes

        def departure(block):
            missed = self.weights(block) @ modes.at(self.curve.angle_deg) - modes.at(self._along_arc(block))
            return np.where(self.covers(block), np.sqrt(missed**2 @ modes.variance_arcsec2), np.nan)

        return self._by_blocks(angle_deg, departure)

    @cached_property
    def _modes(self):
        return curve_modes(self.curve)

    def _along_arc(self, angle_deg: np.ndarray) -> np.ndarray:
        """The same angles in the turn that starts at the arc, or at the first face."""
        first = self.curve.angle_deg[0] if self.curve.arc_deg is None else self.curve.arc_deg[0]
        return first + np.mod(angle_deg - first + _ARC_EDGE_DEG, 360.0) - _ARC_EDGE_DEG

    def _by_blocks(self, angle_deg, function) -> np.ndarray:
        angle = np.asarray(angle_deg, float)
        flat = angle.ravel()
        result = np.empty(flat.size)
        for start in range(0, flat.size, _BLOCK):
            result[start : start + _BLOCK] = function(flat[start : start + _BLOCK])
        return result.reshape(angle.shape)
