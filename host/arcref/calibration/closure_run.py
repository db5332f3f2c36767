"""A closure run: the polygon set at several positions on the encoder, no certificate needed."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import wrapped
from arcref.calibration.closure_design import SettingsDesign, nominal_position_deg
from arcref.calibration.closure_mistakes import refuse_misplaced
from arcref.calibration.metadata_key import CLOSURE
from arcref.calibration.metadata_keys import known_keys
from arcref.calibration.polygon_metadata import FEWEST_FACES, autocollimator_sign, stated_faces
from arcref.calibration.stated_values import stated_number
from arcref.error_curve import CLOSURE_TOLERANCE_ARCSEC
from arcref.input_error import InputError
from arcref.run_file import RunFile, read_run_file

SETTING, FACE, ROUND = "setting", "face", "round"
POSITION, X = "position_deg", "autocollimator_x_arcsec"

LARGEST_X_ARCSEC = 3600.0
LARGEST_POSITION_DEG = 36_000.0
LARGEST_SETTING = 10_000

SMALLEST_STEP_DEG = 0.1
"""Settings closer than this are one position to the polygon, and to the fit of the curve."""


@dataclass(frozen=True, eq=False)
class ClosureRun:
    """Readings of one polygon at several settings on one encoder.

    int[n]: `setting` from 1, `face` from 0, `round` from 1; float64[n]: `position_deg`, encoder readings, and
    `x_arcsec`; `row`: int[n], which reading of the file each is, closing readings left out; `sign`: +1 when x adds to
    the encoder's error; `start_deg`: encoder reading at face 1 of setting 1, to the nearest of all readings;
    `closing_error_arcsec`: by (round, setting), first face read again a turn later minus its first reading.
    """

    run: RunFile
    faces: int
    setting_step_deg: float
    sign: int
    sign_basis: str
    setting: np.ndarray
    face: np.ndarray
    round: np.ndarray
    position_deg: np.ndarray
    x_arcsec: np.ndarray
    row: np.ndarray
    start_deg: float
    closing_error_arcsec: dict[tuple[int, int], float]
    closing_limit_arcsec: float
    design: SettingsDesign

    def reading_arcsec(self, sign: float | None = None) -> np.ndarray:
        """float64[n]: encoder reading - nominal position + sign * x, what `solve_closure` takes."""
        off = self.position_deg - self.start_deg
        off = off - nominal_position_deg(self.faces, self.setting_step_deg, self.setting, self.face)
        return 3600.0 * wrapped(off) + (self.sign if sign is None else sign) * self.x_arcsec

    @property
    def angle_deg(self) -> np.ndarray:
        """float64[p]: encoder's angle of each position of the design, the mean over its readings, increasing."""
        off = self.position_deg - self.start_deg - self.design.position_deg[self.design.position]
        count = np.bincount(self.design.position)
        return self.start_deg + self.design.position_deg + np.bincount(self.design.position, wrapped(off)) / count

    @property
    def spread_arcsec(self) -> float:
        """How far readings that count as one position lie from their mean, at most."""
        off = wrapped(self.position_deg - self.angle_deg[self.design.position])
        return float(3600.0 * np.abs(off).max())

    @property
    def settings(self) -> int:
        """Number of settings."""
        return len(np.unique(self.setting))

    @property
    def rounds(self) -> int:
        """Number of rounds."""
        return len(np.unique(self.round))


def read_closure_run(path, sign: int | None = None) -> ClosureRun:
    """Read a closure run. `sign` overrides the file's `autocollimator_sign`.

    Raises `InputError` for all that `read_run_file` and `refuse_misplaced` refuse, numbers that no such instrument
    shows, a face read twice at one setting, a single setting, and metadata that cannot be.
    """
    run = read_run_file(path, (SETTING, FACE, POSITION, X), (ROUND,), known_keys(CLOSURE))
    faces, step_deg = stated_faces(run), stated_step_deg(run)
    used_sign, basis = autocollimator_sign(run, sign)
    if not run.rows:
        raise InputError.at(run.path, "no readings, at least two settings of the polygon were expected")
    setting, face, round_ = read_settings(run, faces)
    for column, limit, unit in ((X, LARGEST_X_ARCSEC, "arcsec"), (POSITION, LARGEST_POSITION_DEG, "deg")):
        absurd = np.flatnonzero(np.abs(run[column]) > limit)
        if absurd.size and absurd.size < len(face) / 2:
            problem = f"{run[column][absurd[0]]:g} {unit}, at most {limit:g} {unit} were expected"
            raise run.error(problem, reading=int(absurd[0]), column=column)
    start_deg = refuse_misplaced(run, faces, step_deg, setting, face)
    kept, closing = _closing_readings(run, setting, face, round_, used_sign)
    design = _design(run, faces, step_deg, setting[kept], face[kept], round_[kept])
    limit = stated_number(run, "closing_limit_arcsec")
    return ClosureRun(
        run,
        faces,
        step_deg,
        used_sign,
        basis,
        setting[kept],
        face[kept],
        round_[kept],
        run[POSITION][kept],
        run[X][kept],
        kept,
        start_deg,
        closing,
        CLOSURE_TOLERANCE_ARCSEC if limit is None else limit,
        design,
    )


def read_settings(run: RunFile, faces: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Setting (from 1), face (from 0) and round (from 1) of each reading, int[n] each."""
    setting = _whole_numbers(run, SETTING, 1, LARGEST_SETTING)
    face = _whole_numbers(run, FACE, 1, faces) - 1
    round_ = _whole_numbers(run, ROUND, 1, LARGEST_SETTING) if ROUND in run.columns else np.ones(len(face), int)
    return setting, face, round_


def stated_step_deg(run: RunFile) -> float:
    """Turn from one setting to the next. Raises `InputError` when the metadata do not state it."""
    value = stated_number(run, "setting_step_deg")
    if value is None:
        problem = (
            "metadata setting_step_deg is missing: state by how much the polygon is turned on the encoder from one "
            "setting to the next, as in '# setting_step_deg: 15'"
        )
        raise InputError.at(run.path, problem)
    if not SMALLEST_STEP_DEG <= abs(value) < 360.0:
        problem = f"{value:g} deg, {SMALLEST_STEP_DEG:g} deg to less than a turn were expected, either way"
        raise run.metadata_error("setting_step_deg", problem)
    return value


def _whole_numbers(run: RunFile, column: str, lowest: int, highest: int) -> np.ndarray:
    values = run[column]
    wrong = np.flatnonzero((values != np.rint(values)) | (values < lowest) | (values > highest))
    if wrong.size:
        value = values[wrong[0]]
        problem = f"{value:g}, a whole number in {lowest} .. {highest} was expected"
        if value == 0:
            problem += f": the first {column} is 1"
        elif column == FACE and value > highest and run[SETTING].max() <= highest < run[FACE].max():
            problem += ": are the columns setting and face swapped, or is metadata faces too small?"
        raise run.error(problem, reading=int(wrong[0]), column=column)
    return values.astype(int)


def _closing_readings(
    run: RunFile, setting: np.ndarray, face: np.ndarray, round_: np.ndarray, sign: int
) -> tuple[np.ndarray, dict[tuple[int, int], float]]:
    """The readings that are no closing readings, and the closing errors of each series.

    A face read again at its setting is the closing reading when the encoder stands a turn further on; otherwise it is
    a face read twice, and refused.
    """
    first: dict[tuple[int, int, int], int] = {}
    closing: dict[tuple[int, int], float] = {}
    kept = []
    for index, place in enumerate(zip(round_.tolist(), setting.tolist(), face.tolist(), strict=True)):
        before = first.setdefault(place, index)
        if before == index:
            kept.append(index)
            continue
        turned = run[POSITION][index] - run[POSITION][before]
        if abs(abs(turned) - 360.0) > 1.0 or place[:2] in closing:
            problem = (
                f"face {place[2] + 1} at setting {place[1]} is given twice (before in row {run.rows[before]}); "
                "a second round needs a column round, a closing reading a position one turn further on"
            )
            raise run.error(problem, reading=index, column=FACE)
        off = 3600.0 * float(wrapped(turned))
        closing[place[:2]] = off + sign * float(run[X][index] - run[X][before])
    return np.array(kept), closing


def _design(run: RunFile, faces: int, step_deg: float, setting, face, round_) -> SettingsDesign:
    if len(np.unique(setting)) < 2:
        problem = (
            f"setting {setting[0]} alone: the errors of encoder and polygon cannot be told apart, "
            "at least two settings were expected"
        )
        raise InputError.at(run.path, problem)
    try:
        design = SettingsDesign.of(faces, step_deg, setting, face, round_)
        if len(design.faces) < FEWEST_FACES:
            problem = f"{len(design.faces)} faces were read, at least {FEWEST_FACES} were expected"
            raise InputError.at(run.path, problem)
        _ = design.lost
    except ValueError as error:
        raise run.metadata_error("setting_step_deg", f"{step_deg:g} deg: {error}") from None
    return design
