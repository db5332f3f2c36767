"""The error of the encoder over the turn, as a calibration gives it."""

from dataclasses import dataclass, field, replace

import numpy as np

from arcref.calibration_file import read_calibration, read_readings
from arcref.error_statistics import ErrorStatistics
from arcref.input_error import InputError
from arcref.run_file import read_run_file

CLOSURE_TOLERANCE_ARCSEC = 0.5
"""How far a closure row may lie from the first row. A reading of the same face a turn later repeats to about this."""

FEWEST_FACES = 3

# Two angles this close are the same face: a hundredth of a count.
_SAME_ANGLE_DEG = 4e-7


@dataclass(frozen=True, eq=False)
class ErrorCurve:
    """Errors (reading - true angle) at the angles of a turn.

    `angle_deg`, `error_arcsec`: float64[n], angles strictly increasing within one turn, the closure row left out;
    `u_arcsec`: standard uncertainty (k=1) of each error, or None when none is stated; `provenance`: `encoder_serial`,
    `date`, `inputs`, of a calibration also `expanded_uncertainty_arcsec` (k=2, of a corrected angle), the same
    `expanded_without_interpolation_arcsec` for an error within the line that is corrected, too, and the `fit` they
    hold for; `closure_row`: (angle_deg, error_arcsec) of the first face read
    again a turn later, or None; `places`: for messages, where in its file each error stands, or None;
    `arc_deg`: (first, last) angle when only an arc of the turn was measured, None for the whole turn;
    `readings_deg`: float64[n, m], at which angles each was read, NaN where it was read less often, with the weights
    `reading_weight` float64[m] in the mean, or None when that is not known.
    """

    angle_deg: np.ndarray
    error_arcsec: np.ndarray
    u_arcsec: np.ndarray | None = None
    provenance: dict = field(default_factory=dict)
    closure_row: tuple[float, float] | None = None
    places: tuple[dict, ...] | None = field(default=None, repr=False)
    arc_deg: tuple[float, float] | None = None
    readings_deg: np.ndarray | None = field(default=None, repr=False)
    reading_weight: np.ndarray | None = field(default=None, repr=False)

    def __post_init__(self):
        for name in ("angle_deg", "error_arcsec", "u_arcsec"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, np.asarray(getattr(self, name), float))
        shapes = {array.shape for array in (self.angle_deg, self.error_arcsec, self.u_arcsec) if array is not None}
        if len(shapes) != 1 or self.angle_deg.ndim != 1:
            raise ValueError(f"the arrays of an error curve must be of one length, shapes {shapes} were given")

    @classmethod
    def from_polygon_csv(cls, path, closure_tolerance_arcsec: float = CLOSURE_TOLERANCE_ARCSEC) -> "ErrorCurve":
        """Read a reduced curve, columns `position_deg,error_arcsec`, as the published tables are.

        Raises `InputError` when the file cannot be used: see `read_run_file`; fewer than three faces; angles that
        repeat, do not increase or leave the turn that starts at the first; or a closure row (first angle + 360) that
        differs from the first row by more than `closure_tolerance_arcsec`.
        """
        run = read_run_file(path, ("position_deg", "error_arcsec"))
        places = tuple({"row": row, "column": "error_arcsec"} for row in run.rows)
        provenance = {
            "encoder_serial": run.metadata.get("encoder_serial"),
            "date": run.metadata.get("date"),
            "inputs": [run.file.record | {"metadata": run.metadata}],
        }
        curve = cls(run["position_deg"], run["error_arcsec"], None, provenance, None, places)
        angle_places = [place | {"column": "position_deg"} for place in places]
        return curve._checked(path, angle_places, closure_tolerance_arcsec)

    @classmethod
    def from_calibration_json(cls, path, closure_tolerance_arcsec: float = CLOSURE_TOLERANCE_ARCSEC) -> "ErrorCurve":
        """Read the curve of a calibration over the turn, `CAL.json` of kind polygon, closure or theodolite.

        A theodolite sees an arc: where the file does not name it, it is that of the angles, unless these go around.
        Raises `InputError` as `read_calibration` does, and for what `from_polygon_csv` refuses.
        """
        calibration = read_calibration(path, ("polygon", "closure", "theodolite"))
        count = len(calibration.angle_deg)
        places = tuple({"column": f"curve.error_arcsec[{i}]"} for i in range(count))
        provenance = {
            "encoder_serial": calibration.provenance.get("encoder_serial"),
            "date": calibration.provenance.get("date"),
            "expanded_uncertainty_arcsec": calibration.results.get("expanded_uncertainty_arcsec"),
            "expanded_without_interpolation_arcsec": calibration.results.get(
                "expanded_uncertainty_without_interpolation_arcsec"
            ),
            "fit": calibration.results.get("fit"),
            "inputs": [calibration.file.record | {"kind": calibration.kind, "provenance": calibration.provenance}],
        }
        curve = cls(
            calibration.angle_deg,
            calibration.error_arcsec,
            calibration.u_arcsec,
            provenance,
            None,
            places,
            calibration.arc_deg,
            *read_readings(path, calibration.results, count),
        )
        angle_places = [{"column": f"curve.angle_deg[{i}]"} for i in range(count)]
        checked = curve._checked(path, angle_places, closure_tolerance_arcsec)
        is_open = checked.closure_row is None and checked.gaps_deg[-1] > 2 * checked.spacing_deg
        if calibration.kind == "theodolite" and checked.arc_deg is None and is_open:
            return replace(checked, arc_deg=(float(checked.angle_deg[0]), float(checked.angle_deg[-1])))
        return checked

    def values(self, with_closure: bool = False) -> np.ndarray:
        """The errors in arcsec, the closure row's behind them when it is wanted and there is one."""
        if with_closure and self.closure_row is not None:
            return np.append(self.error_arcsec, self.closure_row[1])
        return self.error_arcsec

    def statistics(self, with_closure: bool = False, rows=slice(None)) -> ErrorStatistics:
        """Statistics of the errors; `rows` (a slice or a list of indices) chooses among `values(with_closure)`.

        The published figures of Yu Hai et al. 2015 count the closure row too, so that one face counts twice.
        """
        return ErrorStatistics.of(self.values(with_closure)[rows])

    @property
    def spacing_deg(self) -> float:
        """The usual distance from face to face: the median one, over the turn's seam as well."""
        return float(np.median(self.gaps_deg))

    @property
    def gaps_deg(self) -> np.ndarray:
        """Distance from each face to the next, float64[n]; the last is over the seam to the first."""
        return np.diff(self.angle_deg, append=self.angle_deg[0] + 360.0)

    def _checked(self, path, angle_places: list[dict], tolerance_arcsec: float) -> "ErrorCurve":
        """The curve without its closure row. Raises `InputError` when it is no curve over one turn."""
        angle, error = self.angle_deg, self.error_arcsec
        for index in range(len(angle)):
            _check_angle(path, angle, error, index, angle_places)
        closed = len(angle) > 1 and abs(angle[-1] - angle[0] - 360.0) < _SAME_ANGLE_DEG
        faces = len(angle) - closed
        if faces < FEWEST_FACES:
            besides = " besides the closure row" if closed else ""
            raise InputError.at(path, f"{faces} faces{besides}, at least {FEWEST_FACES} were expected")
        if not closed:
            return self
        if not abs(error[-1] - error[0]) <= tolerance_arcsec:
            problem = (
                f"the closure row at {angle[-1]:g} deg has {error[-1]:g} arcsec, the first row at {angle[0]:g} deg "
                f"{error[0]:g} arcsec: they must agree within {tolerance_arcsec:g} arcsec"
            )
            raise InputError.at(path, problem, **self.places[-1])
        return ErrorCurve(
            angle[:-1],
            error[:-1],
            None if self.u_arcsec is None else self.u_arcsec[:-1],
            self.provenance,
            (float(angle[-1]), float(error[-1])),
            self.places[:-1],
            self.arc_deg,
            None if self.readings_deg is None else self.readings_deg[:-1],
            self.reading_weight,
        )


def _check_angle(path, angle: np.ndarray, error: np.ndarray, index: int, places: list[dict]) -> None:
    """Refuse an angle that repeats an earlier one, falls back, or leaves the turn."""
    here = float(angle[index])
    if index == 0:
        if not -360.0 <= here <= 360.0:
            problem = f"{here:g} deg, the first angle was expected in -360 .. 360 deg"
            raise InputError.at(path, problem, **places[index])
        return
    same = np.flatnonzero(np.abs(angle[:index] - here) < _SAME_ANGLE_DEG)
    if same.size:
        first = int(same[0])
        before = f"row {places[first]['row']}" if "row" in places[first] else places[first]["column"]
        what = f"{here:g} deg is given twice (before in {before})"
        if error[first] == error[index]:
            problem = f"{what}, each time with {error[index]:g} arcsec; each face was expected once"
        else:
            problem = f"{what} with different errors, {error[first]:g} and {error[index]:g} arcsec"
        raise InputError.at(path, problem, **places[index])
    if here < angle[index - 1]:
        problem = f"{here:g} deg follows {angle[index - 1]:g} deg, increasing angles were expected"
        raise InputError.at(path, problem, **places[index])
    if here > angle[0] + 360.0 + _SAME_ANGLE_DEG:
        problem = f"{here:g} deg is outside the turn {angle[0]:g} .. {angle[0] + 360:g} deg"
        raise InputError.at(path, problem, **places[index])
