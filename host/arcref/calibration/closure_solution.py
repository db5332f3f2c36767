"""Closure calibration: encoder errors and face deviations solved together by least squares."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from arcref.calibration.closure_design import SettingsDesign

FALSE_ALARM = 0.001
"""Chance that a run without a mistake has any reading named as an outlier."""


@dataclass(frozen=True, eq=False)
class ClosureSolution:
    """What the readings of a closure run say; leading axes (runs of a simulation) broadcast.

    `encoder_error_arcsec`: float64[..., p], reading - true angle at the design's positions, mean zero;
    `face_deviation_arcsec`: float64[..., f], mean zero; `mounting_arcsec`: float64[..., series];
    `residual_arcsec`: float64[..., n]; `sigma_arcsec`: float64[...], standard deviation of one reading, from the
    residuals, NaN without degrees of freedom.
    """

    design: SettingsDesign
    encoder_error_arcsec: np.ndarray
    face_deviation_arcsec: np.ndarray
    mounting_arcsec: np.ndarray
    residual_arcsec: np.ndarray
    sigma_arcsec: np.ndarray

    def covariance_arcsec2(self, sigma_arcsec=None) -> np.ndarray:
        """float64[..., p + f, p + f]: of encoder errors and face deviations, from the scatter of the readings.

        `sigma_arcsec`: standard deviation of one reading, where the residuals cannot tell it.
        """
        sigma = np.asarray(self.sigma_arcsec if sigma_arcsec is None else sigma_arcsec)
        return sigma[..., np.newaxis, np.newaxis] ** 2 * self.design.covariance

    def standard_uncertainty_arcsec(self, sigma_arcsec=None) -> tuple[np.ndarray, np.ndarray]:
        """Of the encoder errors, float64[..., p], and of the face deviations, float64[..., f]: the scatter's part."""
        sigma = np.asarray(self.sigma_arcsec if sigma_arcsec is None else sigma_arcsec)[..., np.newaxis]
        u = sigma * np.sqrt(np.diag(self.design.covariance))
        return u[..., : len(self.design.position_deg)], u[..., len(self.design.position_deg) :]

    @property
    def studentized_residual(self) -> np.ndarray:
        """float64[..., n]: each residual over the standard deviation that the others alone give it.

        0 where a reading is the only one to determine some unknown, so that nothing checks it.
        """
        design = self.design
        freedom = design.degrees_of_freedom
        if freedom < 2:
            return np.zeros_like(self.residual_arcsec)
        # What of a reading is left in its own residual: the diagonal of 1 - matrix @ estimator.
        left = 1.0 - np.einsum("nu,un->n", design.matrix, design.estimator)
        checked = left > 1e-6
        scaled = np.where(checked, self.residual_arcsec / np.sqrt(np.where(checked, left, 1.0)), 0.0)
        variance = np.asarray(self.sigma_arcsec)[..., np.newaxis] ** 2
        others = np.maximum((freedom * variance - scaled**2) / (freedom - 1), 0.0)
        floor = 1e-18 * np.maximum(variance, 1e-12)  # readings without any noise have no outliers
        return np.where(np.abs(scaled) < 1e-7, 0.0, scaled / np.sqrt(others + floor))

    @property
    def outlier_limit(self) -> float:
        """A studentized residual above this is an outlier, whatever the number of readings (Bonferroni)."""
        freedom = self.design.degrees_of_freedom
        return float(student.isf(FALSE_ALARM / (2 * self.design.readings), freedom - 1)) if freedom > 1 else np.inf


def solve_closure(design: SettingsDesign, reading_arcsec) -> ClosureSolution:
    """Solve the readings `encoder reading - nominal position + sign * autocollimator`, float64[..., n].

    What the settings cannot separate is given to the face deviations (`SettingsDesign.estimator`).
    """
    reading = np.asarray(reading_arcsec, float)
    unknown = reading @ design.estimator.T
    residual = reading - unknown @ design.matrix.T
    freedom = design.degrees_of_freedom
    square = np.sum(residual**2, axis=-1)
    sigma = np.sqrt(square / freedom) if freedom > 0 else np.full(square.shape, np.nan)
    p = len(design.position_deg)
    encoder, faces, mounting = np.split(unknown, [p, p + len(design.faces)], axis=-1)
    return ClosureSolution(design, encoder, faces, mounting, residual, sigma)
