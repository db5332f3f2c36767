"""A Fourier series by least squares as a fit."""

from functools import cached_property

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.fits.straight_line import line_columns
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError

FACES_PER_ORDER = 3
"""The default highest order is a third of the faces: 8 for 24. Above it the series follows the noise of the faces."""

CONDITION_LIMIT = 1e3
"""Condition number of the equations beyond which faces at unequal distances cannot carry the orders asked for."""


class FourierFit(FittedCurve):
    """Mean and orders 1 to `order` of the turn; over an arc a straight line and half waves 1 to `order` of the arc.

    Every face counts the same, whatever its stated uncertainty.
    """

    name = "fourier"

    def __init__(self, curve: ErrorCurve, order: int | None = None):
        """Fit. `order` defaults to the largest, up to a third of the faces, that the faces carry.

        Raises `InputError` for an order that is negative, needs as many numbers as there are faces, or more, or that
        the spacing of the faces cannot carry.
        """
        faces = curve.angle_deg.size
        wanted = faces // FACES_PER_ORDER if order is None else order
        most = (faces - 2) // 2 if curve.arc_deg is None else faces - 3
        if order is not None and not 0 <= order <= most:
            raise InputError(f"a Fourier series of order {order} was asked for, {faces} faces carry order 0 to {most}")
        self.order = min(wanted, most)
        while np.linalg.cond(self._columns(curve.angle_deg, curve)) > CONDITION_LIMIT:
            if order is not None:
                raise InputError(
                    f"a Fourier series of order {order} was asked for, which faces at these unequal distances cannot "
                    "carry; ask for a lower order"
                )
            self.order -= 1
        self.title = f"Fourier series of order {self.order}"
        if curve.arc_deg is not None:
            self.title = f"straight line and cosine series of order {self.order}"
        super().__init__(curve, {"order": self.order})
        self._inverse = np.linalg.pinv(self._columns(curve.angle_deg, curve))

    def _columns(self, angle_deg: np.ndarray, curve: ErrorCurve) -> np.ndarray:
        """The functions of the series at the angles float64[m], one a column."""
        if curve.arc_deg is None:
            phase = np.radians(angle_deg)[:, np.newaxis] * np.arange(1, self.order + 1)
            return np.hstack([np.ones((phase.shape[0], 1)), np.cos(phase), np.sin(phase)])
        line = line_columns(angle_deg, curve.arc_deg)
        half_turns = (line[:, 1:] + 1) / 2 * np.arange(2, self.order + 2)
        return np.hstack([line, np.cos(np.pi * half_turns)])

    def _weights(self, angle_deg):
        return self._columns(angle_deg, self.curve) @ self._inverse

    @cached_property
    def leave_one_out_arcsec(self):
        """See `FittedCurve`; in closed form, residual / (1 - own weight), which is exact for least squares."""
        own_weight = np.diag(self.weights(self.curve.angle_deg))
        return self.residual_arcsec / (1.0 - own_weight)

    def _refitted(self, curve):
        return FourierFit(curve, **self.parameters)
