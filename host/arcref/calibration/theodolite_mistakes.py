"""Mistakes of a theodolite run, named with the reason to think so and never repaired."""

import numpy as np

from arcref.run_file import RunFile

READING, AZIMUTH, ZENITH = "reading_deg", "azimuth_deg", "zenith_deg"

LARGEST_ANGLE_DEG = 720.0
LARGEST_ELEVATION_DEG = 45.0

# How far an azimuth may run ahead of the encoder's reading, for slips of whole degrees: a tilt of 15 deg does 2 deg.
_LARGEST_JUMP_DEG = 0.5


def refuse_absurd(run: RunFile, column: str) -> None:
    """Refuse angles of more than two turns."""
    wrong = np.flatnonzero(np.abs(run[column]) > LARGEST_ANGLE_DEG)
    if wrong.size:
        value = run[column][wrong[0]]
        problem = f"{value:g} deg, at most {LARGEST_ANGLE_DEG:g} deg were expected"
        if np.ptp(run[column]) > 3600.0:
            problem += ": are these counts or arcsec?"
        raise run.error(problem, reading=int(wrong[0]), column=column)


def refuse_swapped(run: RunFile, reading_deg: np.ndarray, azimuth_deg: np.ndarray) -> None:
    """Azimuths that stand still near 90 deg while the zenith angles turn with the encoder."""
    zenith, still = run[ZENITH], np.abs(run[AZIMUTH] - 90.0).max() < LARGEST_ELEVATION_DEG
    turns = abs(abs(np.ptp(zenith)) - np.ptp(reading_deg)) < 0.2 * np.ptp(reading_deg)
    if still and turns and np.ptp(azimuth_deg) < 0.5 * np.ptp(reading_deg):
        problem = f"{zenith[0]:g} deg: this column turns with the encoder and {AZIMUTH} does not, are the two swapped?"
        raise run.error(problem, reading=0, column=ZENITH)


def refuse_zenith(run: RunFile) -> None:
    """Refuse zenith angles that are far from level, or meant otherwise."""
    zenith = run[ZENITH]
    wrong = np.flatnonzero(np.abs(zenith - 90.0) > LARGEST_ELEVATION_DEG)
    if not wrong.size:
        return
    value = zenith[wrong[0]]
    problem = f"{value:g} deg, 45 .. 135 deg was expected: a level line of sight reads 90 deg"
    if np.all(np.abs(zenith) < LARGEST_ELEVATION_DEG):
        problem += "; is this the elevation? The zenith reading is 90 deg more"
    elif np.all(np.abs(zenith - 270.0) < LARGEST_ELEVATION_DEG):
        problem += "; was it read with the circle right? Then write 360 deg less the reading"
    raise run.error(problem, reading=int(wrong[0]), column=ZENITH)


def refuse_azimuth(run: RunFile, reading_deg: np.ndarray, azimuth_deg: np.ndarray, direction: int) -> None:
    """Azimuths that do not follow the encoder: the other way round, in gon, or a slip in one of them."""
    slope = float(np.polyfit(reading_deg - reading_deg.mean(), azimuth_deg, 1)[0]) * direction
    last = int(np.argmax(reading_deg))
    moved = (
        f"{run[AZIMUTH][last]:g} deg: the azimuth moves by {slope * direction * np.ptp(reading_deg):.6g} deg while the "
        f"encoder's reading grows by {np.ptp(reading_deg):.6g} deg"
    )
    if slope < -0.5:
        problem = f"{moved}, the other way than encoder_direction {direction:+d} says"
        raise run.error(problem, reading=last, column=AZIMUTH)
    if abs(slope - 10 / 9) < 0.02 and abs(np.mean(run[ZENITH]) - 100.0) < 8.0:
        raise run.error(f"{moved}: are these gon, 400 to the turn?", reading=last, column=AZIMUTH)
    if not 0.5 < slope < 2.0:
        raise run.error(f"{moved}, about as much was expected", reading=last, column=AZIMUTH)
    if len(reading_deg) < 6:
        return
    # A slip of one reading stands out from a smooth law through the others.
    s, c = np.sin(np.radians(reading_deg)), np.cos(np.radians(reading_deg))
    ahead = azimuth_deg - direction * reading_deg
    columns = np.stack([np.ones_like(s), s, c, s * c, s * s], axis=1)[:, : min(5, len(s) - 3)]
    off = _off_law(columns, ahead)
    worst = int(np.argmax(np.abs(off)))
    rest = np.delete(np.arange(len(s)), worst)
    if abs(off[worst]) > _LARGEST_JUMP_DEG and np.abs(_off_law(columns[rest], ahead[rest])).max() < _LARGEST_JUMP_DEG:
        problem = f"{run[AZIMUTH][worst]:g} deg is about {off[worst]:+.3g} deg off what all other readings say"
        raise run.error(problem, reading=worst, column=AZIMUTH)


def _off_law(columns: np.ndarray, values: np.ndarray) -> np.ndarray:
    """What least absolute deviations would leave, by weighting large residuals down."""
    weight = np.ones(len(values))
    for _ in range(20):
        coefficients = np.linalg.lstsq(columns * weight[:, np.newaxis], values * weight, rcond=1e-10)[0]
        off = values - columns @ coefficients
        weight = 1.0 / np.sqrt(np.maximum(np.abs(off), 1e-6))
    return off
