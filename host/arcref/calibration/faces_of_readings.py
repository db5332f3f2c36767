"""Which face of the polygon each reading is of, from its place on the grid of faces."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import wrapped
from arcref.run_file import RunFile

OFF_FACE_LIMIT_DEG = 0.5
"""How far a position may lie from its face: autocollimators see less than this."""

_UNITS = {"arcsec": 3600.0, "arcmin": 60.0, "radians": np.pi / 180.0, "counts": 2**23 / 360.0}


@dataclass(frozen=True, eq=False)
class FacesOfReadings:
    """`face`: int[n], face 0 being the one that was read first; `angle_deg`: float64[faces], the encoder's angle at
    each face, first that of face 0.
    """

    face: np.ndarray
    angle_deg: np.ndarray


def find_faces(run: RunFile, column: str, position_deg: np.ndarray, faces: int) -> FacesOfReadings:
    """Find them. `column` is where the positions stand.

    Raises `InputError`, which names the row, when a position belongs to no face: it says which slip that looks like.
    """
    spacing_deg = 360.0 / faces
    _refuse_other_units(run, column, position_deg, spacing_deg)
    # The median forgives a slip of the pen in the first row.
    grid_deg = position_deg[0] + np.median(wrapped(position_deg - position_deg[0], spacing_deg))
    off_deg = wrapped(position_deg - grid_deg, spacing_deg)
    if np.abs(off_deg).max() > _limit_deg(spacing_deg):
        _refuse_off_face(run, column, position_deg, faces, off_deg)
    first_deg = np.round(wrapped(grid_deg), 3) + 0.0
    return FacesOfReadings(
        np.mod(np.rint((position_deg - grid_deg) / spacing_deg).astype(int), faces),
        (first_deg if first_deg >= 0 else first_deg + 360.0) + spacing_deg * np.arange(faces),
    )


def _limit_deg(spacing_deg: float) -> float:
    return min(OFF_FACE_LIMIT_DEG, spacing_deg / 8)


def _refuse_other_units(run: RunFile, column: str, position_deg: np.ndarray, spacing_deg: float) -> None:
    if len(position_deg) < 3:
        return
    step = np.median(np.abs(np.diff(position_deg)))
    for unit, factor in _UNITS.items():
        if abs(step / (spacing_deg * factor) - 1) < 0.01:
            problem = (
                f"the positions step by {step:g}, which is one face ({spacing_deg:g} deg) in {unit}; "
                f"degrees were expected"
            )
            raise run.error(problem, reading=1, column=column)


def _refuse_off_face(run: RunFile, column: str, position_deg: np.ndarray, faces: int, off_deg: np.ndarray) -> None:
    spacing_deg = 360.0 / faces
    limit_deg = _limit_deg(spacing_deg)
    wrong = np.flatnonzero(np.abs(off_deg) > limit_deg)
    index = int(wrong[0])
    others = [name for name in run.columns if name != column and name.endswith(("_deg", "_arcsec"))]
    for name in others:
        values = run[name]
        if np.ptp(values) > 180 and np.all(np.abs(wrapped(values - values[0], spacing_deg)) < OFF_FACE_LIMIT_DEG):
            problem = f"the positions fit no faces, but {name} does: the two columns seem to be swapped"
            raise run.error(problem, reading=index, column=column)
    step_deg = np.median(np.abs(wrapped(np.diff(position_deg), 360.0)))
    likely = round(360.0 / step_deg) if step_deg > 0.5 else 0
    if wrong.size > 2 and likely != faces and likely and abs(360.0 / likely / step_deg - 1) < 0.002:
        problem = f"the positions step by {step_deg:.6g} deg, as with {likely} faces, but the metadata says {faces}"
        raise run.error(problem, reading=index, column=column)
    problem = (
        f"{position_deg[index]:.6g} deg is {abs(off_deg[index]):.4g} deg from the nearest face "
        f"({position_deg[index] - off_deg[index]:.6g} deg), at most {limit_deg:.4g} deg were expected"
    )
    raise run.error(problem, reading=index, column=column)
