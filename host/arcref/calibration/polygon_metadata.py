"""What every run with a polygon states in its metadata: number of faces, sign of the autocollimator."""

from arcref.calibration.stated_values import stated_number, stated_plus_or_minus_one
from arcref.input_error import InputError
from arcref.run_file import RunFile

FEWEST_FACES, MOST_FACES = 3, 360


def stated_faces(run: RunFile) -> int:
    """Number of faces of the polygon. Raises `InputError` when it is not stated, or cannot be."""
    value = stated_number(run, "faces")
    if value is None:
        raise InputError.at(run.path, "metadata faces is missing: state the number of faces, as in '# faces: 24'")
    if value != round(value) or not FEWEST_FACES <= value <= MOST_FACES:
        problem = f"{value:g} faces, a whole number in {FEWEST_FACES} .. {MOST_FACES} was expected"
        raise run.metadata_error("faces", problem)
    return int(value)


def autocollimator_sign(run: RunFile, option: int | None = None) -> tuple[int, str]:
    """The sign of x, +1 or -1, and where it comes from; `option` goes before what the file states."""
    stated = stated_plus_or_minus_one(run, "autocollimator_sign")
    if option is not None:
        differs = f", against {stated:+d} in the run file" if stated not in (None, option) else ""
        return option, f"by the command's option{differs}"
    if stated is not None:
        return stated, "by the run file"
    return 1, "assumed: the run file states no autocollimator_sign"
