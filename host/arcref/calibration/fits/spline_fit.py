"""A cubic spline through every face as a fit."""

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.error_curve import ErrorCurve


class SplineFit(FittedCurve):
    """The interpolating cubic spline of SciPy: periodic over the turn; over an arc natural, ends without curvature."""

    name = "spline"

    def __init__(self, curve: ErrorCurve):
        """Fit."""
        from scipy.interpolate import CubicSpline  # imported here: it takes a third of a second

        on_turn = curve.arc_deg is None
        self.title = "periodic cubic spline" if on_turn else "natural cubic spline"
        super().__init__(curve, {})
        angle, unit = curve.angle_deg, np.eye(curve.angle_deg.size)
        if on_turn:
            angle, unit = np.append(angle, angle[0] + 360.0), np.vstack([unit, unit[:1]])
        # One spline through each face's unit error: their values at an angle are the weights there.
        self._unit_splines = CubicSpline(angle, unit, bc_type="periodic" if on_turn else "natural")

    def _weights(self, angle_deg):
        return self._unit_splines(angle_deg)

    def _refitted(self, curve):
        return SplineFit(curve)
