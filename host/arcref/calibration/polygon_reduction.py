"""The reduction of a polygon run: the encoder's error at each face, and what the rounds say of the readings.

Everything broadcasts over leading axes of the run's readings, so that simulated repetitions are reduced at once.
"""

from dataclasses import dataclass

import numpy as np

from arcref.angle import wrapped
from arcref.calibration.polygon_run import PolygonRun
from arcref.calibration.tower_tilt import TowerTilt, fit_tilt


def deviation_arcsec(position_deg, nominal_deg) -> np.ndarray:
    """How far positions lie from nominal angles, whole turns left out."""
    return wrapped(np.asarray(position_deg) - nominal_deg) * 3600.0


def unreferenced_errors(position_deg, nominal_deg, face_deviation_arcsec, x_arcsec, sign) -> np.ndarray:
    """Position minus face angle plus `sign` times x, float64[..., n] in arcsec, all with the same unknown constant.

    `nominal_deg`: nominal angle of the face that each reading is of; `face_deviation_arcsec`: None without certificate.

    Less its first reading it is e_i = (a_i - a_1) - (b_i - b_1) + sign (c_i - c_1). Tian Liude et al. 2015, equation
    (1), print a minus before (c_i - c_1). In the frame of their own equations, where c is positive towards face 2, the
    encoder's error (reading minus true angle) needs the plus, `sign` = +1.
    """
    error = deviation_arcsec(position_deg, nominal_deg) + sign * np.asarray(x_arcsec)
    return error if face_deviation_arcsec is None else error - face_deviation_arcsec


@dataclass(frozen=True, eq=False)
class PolygonReduction:
    """What a polygon run gives. Arrays have the leading axes of the run's readings in front of the axes named here.

    `angle_deg`: float64[faces]; `error_arcsec`: float64[faces], mean of the series, 0 at the first face;
    `error_of_series_arcsec`: float64[series, faces], each 0 at the first face; `uncorrected_error_arcsec`: as
    `error_arcsec`, but of x as it was read; `x_correction_arcsec`: float64[n], what tilt and roll added to x, whether
    it was taken off (`tilt_corrected`) or not; `x_roll_arcsec`: the roll's part of it.

    `closing_error_arcsec`: float64[series], first face read again minus its first reading, nan where it was not.
    `repeatability_arcsec`: standard deviation of one reading from the rounds, within each direction, the constant of
    each series left out; nan when `degrees_of_freedom` is 0. `residual_arcsec`: float64[series, faces], what it is
    made of. `return_error_arcsec`: float64[faces], forward minus backward at each face, None for one direction; it
    holds what the zero drifted between the series. `tilt`: None without y readings.
    """

    run: PolygonRun
    angle_deg: np.ndarray
    error_arcsec: np.ndarray
    uncorrected_error_arcsec: np.ndarray
    error_of_series_arcsec: np.ndarray
    closing_error_arcsec: np.ndarray
    repeatability_arcsec: float | np.ndarray
    degrees_of_freedom: int
    residual_arcsec: np.ndarray
    return_error_arcsec: np.ndarray | None
    tilt: TowerTilt | None
    tilt_corrected: bool
    x_correction_arcsec: np.ndarray
    x_roll_arcsec: np.ndarray


def reduce_polygon(run: PolygonRun, tilt_correction: bool = True) -> PolygonReduction:
    """Reduce `run`; with `tilt_correction`, x is freed from tower tilt and roll when there are y readings."""
    series = run.series
    tilt, x_correction, x_roll = _x_correction(run)
    corrected = tilt_correction and tilt is not None
    nominal = run.angle_deg[run.face]
    raw = unreferenced_errors(run.position_deg, nominal, run.face_deviation_arcsec, run.x_arcsec, run.sign)
    used = raw - run.sign * x_correction if corrected else raw
    of_series = used[..., series.reading_of_face]
    referenced = of_series - of_series[..., :1]
    uncorrected = raw[..., series.reading_of_face]
    uncorrected = uncorrected - uncorrected[..., :1]
    weight = series.weight
    residual, freedom = series_residual(of_series, series.direction)
    return PolygonReduction(
        run,
        run.angle_deg,
        np.einsum("...sf,s", referenced, weight),
        np.einsum("...sf,s", uncorrected, weight),
        referenced,
        _closing_error(used, series),
        _root_mean(residual, freedom),
        freedom,
        residual,
        _return_error(of_series, series.direction),
        tilt,
        corrected,
        x_correction,
        x_roll,
    )


def _x_correction(run: PolygonRun) -> tuple[TowerTilt | None, np.ndarray, np.ndarray]:
    """The tilt, what it and the roll add to x at each reading, and the roll's part alone."""
    if run.y_arcsec is None:
        return None, np.zeros(np.shape(run.x_arcsec)), np.zeros(np.shape(run.x_arcsec))
    roll = np.radians(np.asarray(0.0 if run.roll_arcmin is None else run.roll_arcmin) / 60.0)[..., np.newaxis]
    x_level = run.x_arcsec * np.cos(roll) - run.y_arcsec * np.sin(roll)
    y_level = run.y_arcsec * np.cos(roll) + run.x_arcsec * np.sin(roll)
    # The mean over the rounds: noise and the faces' own tilts then both show in the scatter about the model.
    y_of_face = np.einsum("...sf,s", run.y_sign * y_level[..., run.series.reading_of_face], run.series.weight)
    tilt = fit_tilt(run.series.theta_deg, y_of_face)
    x_roll = run.x_arcsec - x_level
    return tilt, x_roll + run.sign * tilt.horizontal_arcsec(run.theta_deg), x_roll


def _closing_error(error: np.ndarray, series) -> np.ndarray:
    closed = series.closing_reading >= 0
    difference = error[..., series.closing_reading] - error[..., series.first_reading]
    return np.where(closed, difference, np.nan)


def series_residual(of_series: np.ndarray, direction: tuple[int, ...]) -> tuple[np.ndarray, int]:
    """What remains of each series without its own mean and the mean curve of its direction, and degrees of freedom."""
    direction = np.array(direction)
    centred = of_series - of_series.mean(axis=-1, keepdims=True)
    residual = np.zeros_like(centred)
    freedom = 0
    for way in set(direction.tolist()):
        own = direction == way
        residual[..., own, :] = centred[..., own, :] - centred[..., own, :].mean(axis=-2, keepdims=True)
        freedom += (int(own.sum()) - 1) * (of_series.shape[-1] - 1)
    return residual, freedom


def _root_mean(residual: np.ndarray, freedom: int):
    if freedom == 0:
        return np.full(residual.shape[:-2], np.nan)[()]
    return np.sqrt((residual**2).sum(axis=(-2, -1)) / freedom)


def _return_error(of_series: np.ndarray, direction: tuple[int, ...]) -> np.ndarray | None:
    """Forward minus backward; the series are not re-zeroed here, or a constant return error would vanish."""
    forward = np.array(direction) > 0
    if forward.all() or not forward.any():
        return None
    return of_series[..., forward, :].mean(axis=-2) - of_series[..., ~forward, :].mean(axis=-2)
