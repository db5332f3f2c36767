"""The RBF network as a fit, the default: Yu Hai et al., Chinese Optics 8(3) 2015 447-455."""

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.fits.straight_line import line_columns
from arcref.error_curve import ErrorCurve
from arcref.radial_basis_network import RadialBasisNetwork


class RadialBasisFit(FittedCurve):
    """A wrapped `RadialBasisNetwork` with a centre at each face.

    Over an arc the network, then not wrapped, carries what a straight line by least squares leaves: by itself it would
    fall towards zero at the arc's ends.
    """

    name = "rbf"

    def __init__(self, curve: ErrorCurve, spread_deg: float | None = None, ridge: float = 0.0):
        """Fit. `spread_deg` defaults to the face spacing; raises `InputError` as `RadialBasisNetwork.fit` does."""
        on_turn = curve.arc_deg is None
        self.network = RadialBasisNetwork.fit(curve, spread_deg, ridge, wrapped=on_turn)
        self.title = "wrapped RBF network" if on_turn else "straight line and RBF network"
        network = self.network
        super().__init__(curve, {"spread_deg": network.spread_deg, "ridge": network.ridge})
        self.condition_number = network.condition_number
        self._line = None if on_turn else np.linalg.pinv(line_columns(curve.angle_deg, curve.arc_deg))

    def evaluate(self, angle_deg) -> np.ndarray:
        """The error in arcsec at `angle_deg`; over the turn it is the network's own evaluation, bit for bit."""
        return self.network.evaluate(angle_deg) if self._line is None else super().evaluate(angle_deg)

    def _weights(self, angle_deg):
        weights = self.network.weights(angle_deg)
        if self._line is None:
            return weights
        curve = self.curve
        missed = line_columns(angle_deg, curve.arc_deg) - weights @ line_columns(curve.angle_deg, curve.arc_deg)
        return weights + missed @ self._line

    @property
    def leave_one_out_arcsec(self):
        """See `FittedCurve`; over the turn in closed form, weight / diagonal of the inverse."""
        return self.network.leave_one_out_arcsec if self._line is None else super().leave_one_out_arcsec

    def _refitted(self, curve):
        return RadialBasisFit(curve, **self.parameters)
