"""How an error in the reduced readings of the faces reaches a corrected angle anywhere on the turn."""

import numpy as np

from arcref.angle import COUNTS_PER_LINE, LINES_PER_TURN, counts_to_deg

_LINES_APART = 4
"""Every fourth grating line is looked at: 0.35 degrees apart, far closer than faces are."""


class FitTransfer:
    """Linear map from errors at the faces to the corrected angle, about the mean of the correction.

    Every error is reduced against the first face's, then weighted by the fit; the mean over the angles looked at is no
    error, because the encoder's zero is a matter of choice. `weights`: float64[angles, faces], as
    `FittedCurve.weights` gives them.
    """

    def __init__(self, weights):
        self._weights = np.asarray(weights, float)
        about_first = self._weights.copy()
        about_first[:, 0] -= self._weights.sum(axis=1)
        self._matrix = about_first - about_first.mean(axis=0)

    @classmethod
    def to_faces(cls, faces: int) -> "FitTransfer":
        """To the errors at the faces themselves, before any fit."""
        return cls(np.eye(faces))

    @classmethod
    def over_turn(cls, fitted) -> "FitTransfer":
        """To the curve that `fitted` makes, at the grating lines it covers."""
        return cls(fitted.weights(line_middles_deg(fitted)))

    @property
    def of_independent(self) -> float:
        """Rms in the result for an error of 1 at each face, independent from face to face."""
        return float(np.sqrt((self._matrix**2).sum(axis=1).mean()))

    def of_covariance(self, covariance) -> float:
        """Rms in the result for errors at the faces of this covariance, float64[faces, faces]."""
        variance = np.einsum("ai,ij,aj->a", self._matrix, covariance, self._matrix, optimize=True)
        return float(np.sqrt(max(variance.mean(), 0.0)))

    def of_shape(self, at_faces) -> float:
        """Rms in the result for errors `at_faces`, real or complex, float64[faces], that come together."""
        return float(np.sqrt(np.mean(np.abs(self._matrix @ np.asarray(at_faces)) ** 2)))

    def of_offset(self, at_faces) -> float:
        """The same for errors whose mean is an error, too, and that are not referred to the first face."""
        return float(np.sqrt(np.mean(np.abs(self._weights @ np.asarray(at_faces)) ** 2)))


def line_middles_deg(fitted, lines_apart: int = _LINES_APART) -> np.ndarray:
    """Middles of the grating lines, in degrees, of those that `fitted` covers: what a ROM entry stands for."""
    middle = np.arange(0, LINES_PER_TURN, lines_apart) * COUNTS_PER_LINE + COUNTS_PER_LINE / 2
    angle_deg = counts_to_deg(middle)
    return angle_deg[fitted.covers(angle_deg)]
