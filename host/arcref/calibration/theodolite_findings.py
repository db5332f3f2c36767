"""What a solved theodolite run says, as results and report need it."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from arcref.calibration.closure_solution import FALSE_ALARM
from arcref.calibration.theodolite_budget import azimuth_noise, zenith_noise
from arcref.calibration.theodolite_identification import closed_form
from arcref.calibration.theodolite_run import TheodoliteRun
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcSensitivity, ArcSolution
from arcref.error_curve import ErrorCurve

# Below this many times its own uncertainty alpha is no direction to measure delta from.
_DELTA_NEEDS = 3.0


@dataclass(frozen=True, eq=False)
class ArcFindings:
    """What the report and the results are made from; `covariance_arcsec2`: of the errors, None when not known."""

    run: TheodoliteRun
    solution: ArcSolution
    sensitivity: ArcSensitivity
    curve: ErrorCurve
    covariance_arcsec2: np.ndarray | None

    @property
    def u_angles_deg(self) -> np.ndarray:
        """float64[3]: standard uncertainty of alpha, delta and omega; delta's may be infinite."""
        return np.sqrt(np.diag(self.angle_covariance_deg2))

    @property
    def angle_covariance_deg2(self) -> np.ndarray:
        """float64[3, 3]: of alpha, delta and omega."""
        azimuth, zenith = azimuth_noise(self.run, self.solution), zenith_noise(self.run, self.solution)
        return self.sensitivity.angle_covariance(zenith.arcsec / 3600.0, (azimuth.arcsec or 0.0) / 3600.0)

    @property
    def delta_is_known(self) -> bool:
        """False near alpha = 0, where no direction of the axis is defined."""
        return bool(self.solution.geometry.alpha_deg > _DELTA_NEEDS * self.u_angles_deg[0])

    @property
    def uncorrected_arcsec(self) -> np.ndarray:
        """float64[places]: reading - azimuth about its mean, as if axis and mirror were aligned."""
        readings = self.solution.readings
        ahead = ARCSEC_PER_RAD * (readings.reading_rad - readings.azimuth_rad) @ readings.averaging.T
        return self.run.direction * ahead

    @property
    def parameter_u_arcsec(self) -> np.ndarray:
        """float64[places]: of the errors, the part of axis and mirror alone."""
        covariance = self.sensitivity.error_covariance(zenith_noise(self.run, self.solution).arcsec, 0.0)
        return np.sqrt(np.diag(covariance))

    @property
    def closed_form_difference_arcsec(self) -> float:
        """By how much the closed form would find other angles, at most and about the mean."""
        readings, solution = self.solution.readings, self.solution
        start = closed_form(solution.theta_rad, readings.elevation_rad)
        theta = start.theta_rad(readings.azimuth_rad - solution.datum_rad[readings.round])
        off = ARCSEC_PER_RAD * (theta - solution.theta_rad)
        return float(np.abs(off - off.mean()).max())

    @property
    def studentized_elevation(self) -> np.ndarray:
        """float64[n]: each elevation's residual over the standard deviation that the others alone give it."""
        solution = self.solution
        jacobian = solution.geometry.derivatives(solution.theta_rad).elevation_by_parameters
        q, _ = np.linalg.qr(jacobian)
        left = np.maximum(1.0 - np.sum(q**2, axis=1), 1e-6)
        scaled = ARCSEC_PER_RAD * solution.elevation_residual_rad / np.sqrt(left)
        freedom, variance = len(scaled) - 3, float(solution.elevation_sigma_arcsec) ** 2
        others = np.maximum((freedom * variance - scaled**2) / max(freedom - 1, 1), 0.0)
        small = np.abs(scaled) < 1e-6
        return np.where(small, 0.0, scaled / np.sqrt(np.where(small, 1.0, others + 1e-18)))

    @property
    def outliers(self) -> list[int]:
        """Readings whose elevation stands out, the worst first."""
        size, freedom = np.abs(self.studentized_elevation), len(self.run.place) - 3
        limit = student.isf(FALSE_ALARM / (2 * len(size)), freedom - 1) if freedom > 1 else np.inf
        return [int(index) for index in np.argsort(-size, kind="stable") if size[index] > limit]
