"""A polygon run: encoder readings, certificate, autocollimator readings, and what the metadata says of them."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import counts_to_deg, wrapped
from arcref.calibration.metadata_key import POLYGON
from arcref.calibration.metadata_keys import known_keys
from arcref.calibration.polygon_arrangement import arrange_series
from arcref.calibration.polygon_metadata import autocollimator_sign, stated_faces
from arcref.calibration.polygon_series import BACKWARD, FORWARD, PolygonSeries
from arcref.calibration.stated_values import stated_number, stated_plus_or_minus_one
from arcref.input_error import InputError
from arcref.run_file import RunFile, read_run_file

POSITION, COUNT = "position_deg", "count"
DEVIATION, X, Y = "face_deviation_arcsec", "autocollimator_x_arcsec", "autocollimator_y_arcsec"
ROUND, DIRECTION = "round", "direction"

LARGEST = {DEVIATION: 300.0, X: 3600.0, Y: 7200.0}
"""Readings beyond these, in arcsec, are taken for slips: no polygon and no autocollimator goes so far."""

LARGEST_ROLL_ARCMIN = 120.0
MOST_ROUNDS = 10_000
LARGEST_POSITION_DEG = 36_000.0


@dataclass(frozen=True, eq=False)
class PolygonRun:
    """Readings of one polygon on one encoder.

    float64[n], or with leading axes for simulated repetitions: `position_deg`; `face_deviation_arcsec` (face angle
    minus nominal, counted from face 1 of the run) or None without a certificate; `x_arcsec`; `y_arcsec` or None.
    `sign`: +1 when x adds to the error, -1 when it is subtracted; `y_sign`: +1 when y grows as the face looks up;
    `roll_arcmin`: the autocollimator's roll, x gets roll times y, or None when it is not stated;
    `sign_basis`: where the sign comes from; `series`: how the readings lie in rounds and directions;
    `closing_limit_arcsec`: as the run file states it, or None.
    """

    run: RunFile
    faces: int
    sign: int
    position_deg: np.ndarray
    face_deviation_arcsec: np.ndarray | None
    x_arcsec: np.ndarray
    y_arcsec: np.ndarray | None
    series: PolygonSeries
    roll_arcmin: float | np.ndarray | None = None
    y_sign: int = 1
    sign_basis: str = ""
    closing_limit_arcsec: float | None = None

    @property
    def face(self) -> np.ndarray:
        """Face of each reading, int[n], 0 for the one read first."""
        return self.series.face

    @property
    def angle_deg(self) -> np.ndarray:
        """Encoder's angle at each face, float64[faces], strictly increasing."""
        return self.series.angle_deg

    @property
    def theta_deg(self) -> np.ndarray:
        """How far each reading is from the first face, float64[n], 0 .. 360."""
        return self.series.theta_deg[self.face]

    @property
    def round(self) -> np.ndarray:
        """Round of each reading, int[n]."""
        return np.array(self.series.round)[self._series_of_reading]

    @property
    def direction(self) -> np.ndarray:
        """Direction of each reading, int[n], +1 or -1."""
        return np.array(self.series.direction)[self._series_of_reading]

    @property
    def _series_of_reading(self) -> np.ndarray:
        return np.searchsorted(self.series.first_reading, np.arange(len(self.face)), side="right") - 1


def read_polygon_run(path, sign: int | None = None) -> PolygonRun:
    """Read a polygon run. `sign` overrides the file's `autocollimator_sign`.

    Raises `InputError` for all that `read_run_file` and `arrange_series` refuse, for numbers that no such instrument
    shows, for a face whose certificate differs from row to row, and for metadata that cannot be.
    """
    run = read_run_file(path, (X,), (POSITION, COUNT, DEVIATION, Y, ROUND, DIRECTION), known_keys(POLYGON))
    column = _position_column(run)
    faces = stated_faces(run)
    stated_sign, basis = autocollimator_sign(run, sign)
    roll = stated_number(run, "autocollimator_roll_arcmin")
    if roll is not None and abs(roll) > LARGEST_ROLL_ARCMIN:
        problem = f"{roll:g} arcmin of roll, at most {LARGEST_ROLL_ARCMIN:g} were expected"
        raise run.metadata_error("autocollimator_roll_arcmin", problem)
    if len(run.rows) < faces:
        problem = f"{len(run.rows)} readings, at least one for each of the {faces} faces was expected"
        raise InputError.at(run.path, problem)
    position = _positions(run, column)
    rounds = _whole_numbers(
        run, ROUND, "whole numbers from 1 were expected", lambda values: (values >= 1) & (values <= MOST_ROUNDS)
    )
    directions = _whole_numbers(
        run,
        DIRECTION,
        f"{FORWARD:+d} (forward) or {BACKWARD:+d} (backward) was expected",
        lambda values: np.abs(values) == 1,
    )
    _refuse_absurd(run, faces)
    series = arrange_series(run, column, position, faces, rounds, directions)
    deviation = run.columns.get(DEVIATION)
    if deviation is not None:
        _refuse_differing_certificate(run, series)
    return PolygonRun(
        run,
        faces,
        stated_sign,
        position,
        deviation,
        run[X],
        run.columns.get(Y),
        series,
        roll,
        stated_plus_or_minus_one(run, "autocollimator_y_sign") or 1,
        basis,
        stated_number(run, "closing_limit_arcsec"),
    )


def _position_column(run: RunFile) -> str:
    given = [name for name in (POSITION, COUNT) if name in run.columns]
    if len(given) == 1:
        return given[0]
    what = "both stand here, one of them was expected" if given else "neither stands here, one of them was expected"
    raise InputError.at(run.path, f"columns {POSITION} and {COUNT}: {what}", row=run.header_row)


def _positions(run: RunFile, column: str) -> np.ndarray:
    values = run[column]
    if column == COUNT:
        fraction = np.flatnonzero(values != np.rint(values))
        if fraction.size:
            index = int(fraction[0])
            problem = f"{values[index]:.12g} is no whole number, counts were expected"
            raise run.error(problem, reading=index, column=column)
        values = counts_to_deg(values)
    absurd = np.flatnonzero(np.abs(values) > LARGEST_POSITION_DEG)
    # Positions that step by one face in another unit get their own line later; a single absurd one gets it here.
    if absurd.size and absurd.size < len(values) / 2:
        index = int(absurd[0])
        problem = f"{values[index]:g} deg, at most {LARGEST_POSITION_DEG:g} deg (100 turns) were expected"
        raise run.error(problem, reading=index, column=column)
    return values


def _whole_numbers(run: RunFile, column: str, expected: str, allowed) -> np.ndarray | None:
    if column not in run.columns:
        return None
    values = run[column]
    wrong = np.flatnonzero((values != np.rint(values)) | ~allowed(values))
    if wrong.size:
        raise run.error(f"{values[wrong[0]]:g}, {expected}", reading=int(wrong[0]), column=column)
    return values.astype(int)


def _refuse_absurd(run: RunFile, faces: int) -> None:
    """Numbers that no polygon and no autocollimator shows."""
    for column, limit in LARGEST.items():
        if column not in run.columns:
            continue
        wrong = np.flatnonzero(np.abs(run[column]) > limit)
        if not wrong.size:
            continue
        index = int(wrong[0])
        value = run[column][index]
        if column == DEVIATION and abs(value - 360.0 / faces * round(value * faces / 360.0)) < 0.1:
            problem = f"{value:g} looks like a face's angle in degrees, its deviation from nominal was expected"
        else:
            problem = f"{value:g} arcsec, at most {limit:g} arcsec were expected"
        raise run.error(problem, reading=index, column=column)
    if DEVIATION in run.columns:
        _refuse_face_angles(run, faces)


def _refuse_face_angles(run: RunFile, faces: int) -> None:
    """A certificate's face angles in degrees, put where their deviations belong."""
    values = run[DEVIATION]
    if np.ptp(values) > 180.0 and np.all(np.abs(wrapped(values, 360.0 / faces)) < 0.1):
        index = int(np.argmax(np.abs(values) > 1.0))
        problem = f"{values[index]:g} looks like a face's angle in degrees, its deviation from nominal was expected"
        raise run.error(problem, reading=index, column=DEVIATION)


def _refuse_differing_certificate(run: RunFile, series: PolygonSeries) -> None:
    """One face has one deviation, in every round."""
    values, first_row = run[DEVIATION], {}
    for index, face in enumerate(series.face):
        before = first_row.setdefault(int(face), index)
        if values[before] != values[index]:
            angle = float(f"{series.angle_deg[face] % 360:.5g}")
            problem = (
                f"{values[index]:g} arcsec for face {face + 1} ({angle:g} deg), row {run.rows[before]} has "
                f"{values[before]:g}: a face has one deviation in its certificate"
            )
            raise run.error(problem, reading=index, column=DEVIATION)
