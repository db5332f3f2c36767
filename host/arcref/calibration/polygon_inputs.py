"""What the uncertainty budget and the Monte Carlo of a polygon run both start from: every input, stated or found."""

from dataclasses import dataclass

import numpy as np

from arcref.calibration.polygon_reduction import PolygonReduction, unreferenced_errors
from arcref.calibration.stated_values import stated_number, stated_standard_uncertainty
from arcref.calibration.tower_tilt import TowerTilt
from arcref.run_file import RunFile


@dataclass(frozen=True, eq=False)
class PolygonInputs:
    """Inputs of a polygon reduction. None stands for what nobody stated.

    Of the readings: `position_deg`: float64[series, faces]; `theta_deg`: float64[faces], turn from face 1 to each face;
    `direction`: +1 or -1 of each series; `weight`: of each series in the mean, float64[series]; `turn_order`:
    float64[series, faces], which part of its round each reading came after, 0 to 1; `certified`: whether the run holds
    face deviations; `tilt`: found from y, or None; `tilt_corrected`: whether tilt and roll were taken off x;
    `x_roll_arcsec`: float64[faces], what the stated roll added to x.

    Found in the run: `repeatability_arcsec`, standard deviation of one x reading, with its degrees of freedom (infinite
    when it was stated, see `repeatability_type`); `closing_error_arcsec`: float64[series], signed, NaN where the first
    face was not read again; `return_error_arcsec`: float64[faces], forward minus backward; `series_constant_arcsec`:
    float64[series], mean of each series before it is referred to its first face.

    Stated: the rest, named as the metadata keys.
    """

    run: RunFile
    position_deg: np.ndarray
    theta_deg: np.ndarray
    direction: tuple[int, ...]
    weight: np.ndarray
    turn_order: np.ndarray
    certified: bool
    tilt: TowerTilt | None
    tilt_corrected: bool
    x_roll_arcsec: np.ndarray
    repeatability_arcsec: float | None
    repeatability_degrees_of_freedom: float
    repeatability_type: str
    closing_error_arcsec: np.ndarray
    return_error_arcsec: np.ndarray | None
    series_constant_arcsec: np.ndarray
    u_face_certificate_arcsec: float | None
    u_autocollimator_arcsec: float | None
    u_autocollimator_roll_arcmin: float | None
    tilt_limit_arcsec: float | None
    eccentricity_mm: float | None
    u_face_flatness_arcsec_per_mm: float | None
    u_eccentric_mounting_arcsec: float | None
    temperature_change_k: float | None
    u_temperature_coefficient_arcsec_per_k: float | None
    u_temperature_arcsec: float | None

    @classmethod
    def of(cls, reduction: PolygonReduction) -> "PolygonInputs":
        """The inputs of a reduced run. Raises `InputError` for stated numbers that cannot be."""
        run, series = reduction.run, reduction.run.series
        order = series.reading_of_face
        repeatability, freedom, kind = float(reduction.repeatability_arcsec), float(reduction.degrees_of_freedom), "A"
        if not np.isfinite(repeatability):
            repeatability, freedom, kind = stated_number(run.run, "u_repeatability_arcsec"), np.inf, "B"
        error = unreferenced_errors(
            run.position_deg, run.angle_deg[run.face], run.face_deviation_arcsec, run.x_arcsec, run.sign
        )
        return cls(
            run=run.run,
            position_deg=run.position_deg[order],
            theta_deg=series.theta_deg,
            direction=series.direction,
            weight=series.weight,
            turn_order=np.abs(order - series.first_reading[:, np.newaxis]) / run.faces,
            certified=run.face_deviation_arcsec is not None,
            tilt=reduction.tilt,
            tilt_corrected=reduction.tilt_corrected,
            x_roll_arcsec=series.weight @ reduction.x_roll_arcsec[order],
            repeatability_arcsec=repeatability,
            repeatability_degrees_of_freedom=freedom,
            repeatability_type=kind,
            closing_error_arcsec=reduction.closing_error_arcsec,
            return_error_arcsec=reduction.return_error_arcsec,
            series_constant_arcsec=error[order].mean(axis=-1),
            **stated_inputs(run.run),
        )

    @property
    def faces(self) -> int:
        """Number of faces."""
        return self.theta_deg.size

    @property
    def averaging(self) -> float:
        """Standard deviation of the mean over the series for one reading's standard deviation of 1."""
        return float(np.sqrt(np.sum(self.weight**2)))


def stated_inputs(run: RunFile) -> dict:
    """The stated uncertainties of a polygon run, as `PolygonInputs` names them.

    Raises `InputError` for a number that is none, and where two keys state the same thing.
    """
    stated = {
        "u_face_certificate_arcsec": stated_standard_uncertainty(
            run, "u_face_certificate_arcsec", "expanded_face_certificate_arcsec"
        ),
        "u_autocollimator_arcsec": stated_standard_uncertainty(
            run, "u_autocollimator_arcsec", "expanded_autocollimator_arcsec"
        ),
    }
    for key in (
        "u_autocollimator_roll_arcmin",
        "tilt_limit_arcsec",
        "eccentricity_mm",
        "u_face_flatness_arcsec_per_mm",
        "u_eccentric_mounting_arcsec",
        "temperature_change_k",
        "u_temperature_coefficient_arcsec_per_k",
        "u_temperature_arcsec",
    ):
        stated[key] = stated_number(run, key)
    for whole, parts in (
        ("u_eccentric_mounting_arcsec", "u_face_flatness_arcsec_per_mm"),
        ("u_temperature_arcsec", "u_temperature_coefficient_arcsec_per_k"),
    ):
        if stated[whole] is not None and stated[parts] is not None:
            raise run.metadata_error(parts, f"{whole} stands here too, one of them was expected")
    return stated
