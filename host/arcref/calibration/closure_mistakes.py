"""Mistakes of a closure run, named with the reason to think so and never repaired."""

import numpy as np

from arcref.angle import wrapped
from arcref.calibration.closure_design import nominal_position_deg
from arcref.calibration.faces_of_readings import OFF_FACE_LIMIT_DEG
from arcref.input_error import InputError
from arcref.run_file import RunFile

POSITION, X = "position_deg", "autocollimator_x_arcsec"

UNITS = {"arcsec": 3600.0, "arcmin": 60.0, "radians": np.pi / 180.0, "counts": 2**23 / 360.0}

LARGEST_DEVIATION_ARCSEC = 300.0
"""No polygon has a face this far from its nominal angle."""

BETTER = 3.0
"""Another reading of x must leave residuals smaller by this factor before it is held against the file."""

# At least this large are the residuals that are worth an accusation: less may be chance.
_WORTH_ARCSEC = 0.05


def refuse_misplaced(run: RunFile, faces: int, step_deg: float, setting: np.ndarray, face: np.ndarray) -> float:
    """The encoder's reading at face 1 of setting 1, from all readings.

    Raises `InputError` when positions are not where the numbers of setting and face put them.
    """
    position = run[POSITION]
    limit = min(OFF_FACE_LIMIT_DEG, abs(step_deg) / 2.5)
    off, start_deg = _off_grid(position, nominal_position_deg(faces, step_deg, setting, face))
    wrong = np.flatnonzero(np.abs(off) > limit)
    if not wrong.size:
        return start_deg
    index = int(wrong[0])
    expected = nominal_position_deg(faces, step_deg, setting[index], face[index]) + start_deg
    if wrong.size > len(position) / 4:
        reason = _common_reason(run, faces, step_deg, setting, face, limit)
        if reason:
            raise run.error(f"{position[index]:g} deg: {reason}", reading=index, column=POSITION)
    x = run[X][index]
    problem = (
        f"{position[index]:g} deg, near {round(np.mod(expected, 360.0), 2) % 360:g} deg was expected "
        f"(face {face[index] + 1} at setting {setting[index]})"
    )
    met = face[index] + off[index] * faces / 360.0
    if abs(wrapped(x - expected)) < limit < abs(off[index]) and abs(position[index]) < 60.0:
        problem += f"; {round(x, 2):g} in column {X} fits: are the two swapped?"
    elif abs(met - round(met)) * 360.0 / faces < limit:
        problem += f"; face {round(met) % faces + 1} is met there"
    raise run.error(problem, reading=index, column=POSITION)


def refuse_misread(run: RunFile, x_arcsec, residual_arcsec, x_residual_arcsec, sign: int) -> None:
    """Refuse x readings that fit the other readings only with the other sign, or in another unit.

    `residual_arcsec`, `x_residual_arcsec`: float64[n], what the solution leaves of the readings and of x alone.
    """
    left = _rms(residual_arcsec)
    square = float(np.sum(np.square(x_residual_arcsec)))
    if left < _WORTH_ARCSEC or square == 0.0:
        return
    # The multiple of x that fits the encoder's readings best. A small one only says that the shaft stood still.
    factor = 1.0 - sign * float(residual_arcsec @ x_residual_arcsec) / square
    other = _rms(residual_arcsec + (factor - 1.0) * sign * x_residual_arcsec)
    if other * BETTER > left or -0.5 < factor < 1.5:
        return
    meant = {1.0: "", 60.0: " taken for arcmin", 3600.0: " taken for degrees"}
    unit = next((text for value, text in meant.items() if abs(abs(factor) / value - 1) < 0.2), None)
    what = f" times {abs(factor):.3g}" if unit is None else unit
    if factor < 0:
        what += f"{' and' if what else ''} with the other sign: autocollimator_sign is {-sign:+d}, not {sign:+d}"
    index = int(np.argmax(np.abs(x_arcsec)))
    problem = f"the readings disagree by {left:.3g} arcsec rms, and by {other:.3g} arcsec with this column{what}"
    raise run.error(problem, reading=index, column=X)


def refuse_deviations(run: RunFile, face_numbers, deviation_arcsec, mounting_arcsec) -> None:
    """Refuse face deviations that no polygon has."""
    worst = int(np.argmax(np.abs(deviation_arcsec)))
    if abs(deviation_arcsec[worst]) <= LARGEST_DEVIATION_ARCSEC:
        return
    problem = (
        f"face {face_numbers[worst] + 1} would be {deviation_arcsec[worst]:.4g} arcsec off its nominal angle, more "
        f"than {LARGEST_DEVIATION_ARCSEC:g} arcsec is no polygon"
    )
    if _rms(mounting_arcsec - np.mean(mounting_arcsec)) < 0.1 * _rms(deviation_arcsec):
        problem += "; the mountings hardly differ: are the columns setting and face swapped?"
    raise InputError.at(run.path, problem)


def _common_reason(run: RunFile, faces: int, step_deg: float, setting, face, limit: float) -> str | None:
    """One mistake that would explain all positions, in words; None when none does."""
    position = run[POSITION]
    own = nominal_position_deg(faces, step_deg, setting, face)
    for unit, factor in UNITS.items():
        # In another unit a turn is no longer 360, so start and turns are left to the scaled readings.
        if np.ptp(position) > 0 and _fits(position / factor, own, limit):
            return f"all positions fit when they are read as {unit}, degrees were expected"
    if _fits(run[X], own, limit):
        return f"the numbers in column {X} fit the positions: are the two columns swapped?"
    if _fits(position, nominal_position_deg(faces, step_deg, setting, -face), limit):
        return "all positions fit faces that are numbered the other way round: face 2 comes where the last was expected"
    if _fits(position, nominal_position_deg(faces, -step_deg, setting, face), limit):
        return f"all positions fit a polygon turned the other way: setting_step_deg is {-step_deg:g}, not {step_deg:g}"
    if _fits(position, nominal_position_deg(faces, -step_deg, setting, -face), limit):
        return "all positions fit an encoder that counts the other way round"
    if _fits(position, nominal_position_deg(faces, step_deg, face + 1, setting - 1), limit):
        return "all positions fit with setting and face swapped"
    other = _step_of(position, faces, setting, face)
    if other is not None and _fits(position, nominal_position_deg(faces, other, setting, face), limit):
        return f"all positions fit settings {round(other, 2):g} deg apart, setting_step_deg states {step_deg:g}"
    return None


def _step_of(position, faces: int, setting, face) -> float | None:
    """The step from one setting to the next that the positions show, or None without neighbouring settings."""
    numbers = np.unique(setting)
    off = position - nominal_position_deg(faces, 0.0, setting, face)
    start = {number: _centre(off[setting == number]) for number in numbers}
    steps = [wrapped(start[n + 1] - start[n]) for n in numbers if n + 1 in start]
    return float(np.median(steps)) if steps else None


def _fits(position, nominal, limit: float) -> bool:
    off, _ = _off_grid(position, nominal)
    return bool(np.mean(np.abs(off) <= limit) > 0.9)


def _off_grid(position, nominal) -> tuple[np.ndarray, float]:
    """How far each position is from the nominal one, and the start common to them, -180 .. 180 deg."""
    off = np.asarray(position) - nominal
    start = _centre(off)
    return wrapped(off - start), start


def _centre(off_deg) -> float:
    """The median of directions: of those around the one that most others lie near to."""
    sample = off_deg[:: max(1, len(off_deg) // 200)]
    near = np.abs(wrapped(sample[:, np.newaxis] - sample)) < OFF_FACE_LIMIT_DEG
    guess = sample[int(np.argmax(near.sum(axis=1)))]
    around = wrapped(off_deg - guess)
    return float(wrapped(guess + np.median(around[np.abs(around) < 1.0])))


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
