"""Mistakes that operators make in a polygon run, made on purpose and written down.

Each is a function of the readings as they should be, the number of faces, and the random numbers that choose the place;
it gives the readings as the file has them, and a sentence.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.metrology.simulated_polygon import PolygonReadings

Mistake = Callable[[PolygonReadings, int, np.random.Generator], tuple[PolygonReadings, str]]


def flipped_sign(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """The autocollimator's x is written down with the other sign."""
    return replace(readings, autocollimator_x_arcsec=-readings.autocollimator_x_arcsec), "x has the other sign"


def arc_minutes(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """Arc minutes are written into the columns of arc seconds."""
    changed = replace(
        readings,
        autocollimator_x_arcsec=readings.autocollimator_x_arcsec / 60.0,
        autocollimator_y_arcsec=readings.autocollimator_y_arcsec / 60.0,
    )
    return changed, "x and y are in arc minutes"


def wrong_order(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """Two neighbouring faces are read in the wrong order."""
    row = _place(readings, faces, rng)
    order = np.arange(readings.face.size)
    order[[row, row + 1]] = row + 1, row
    return readings.where(order), f"readings {row + 1} and {row + 2} stand in the wrong order"


def mirrored_certificate(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """The face deviations are copied from the certificate in the wrong order: 1, then the last, and so down to 2."""
    by_face = _certificate(readings, faces)
    return replace(readings, face_deviation_arcsec=by_face[-readings.face]), "face deviations in reverse order"


def shifted_certificate(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """The run begins at face 2, and the certificate is copied as if it were face 1."""
    by_face = np.roll(_certificate(readings, faces), 1)
    sentence = "the face deviations are those of the face before"
    return replace(readings, face_deviation_arcsec=by_face[readings.face] - by_face[0]), sentence


def slipped_certificate(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """While the certificate is copied a line is lost: from some face on each has the deviation of the next one."""
    by_face = _certificate(readings, faces)
    first = int(rng.integers(2, faces // 2))
    slipped = np.append(by_face[:first], np.roll(by_face, -1)[first:])
    sentence = f"from face {first + 1} on the face deviations are those of the next face"
    return replace(readings, face_deviation_arcsec=slipped[readings.face]), sentence


def skipped_face(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """A face is passed by and its row is not there."""
    row = _place(readings, faces, rng)
    kept = np.arange(readings.face.size) != row
    return readings.where(kept), f"reading {row + 1} was skipped"


def jump_of_one_face(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """From one reading of the first series on the shaft stands one face further than the list of faces has it."""
    row = _place(readings, faces, rng)
    series_end = _series_end(readings)
    moved, further = np.arange(row, series_end), np.arange(row + 1, series_end + 1)
    further[-1] = 1  # behind the closing face comes the second one again
    count, x, y = (
        values.copy() for values in (readings.count, readings.autocollimator_x_arcsec, readings.autocollimator_y_arcsec)
    )
    count[moved], x[moved], y[moved] = readings.count[further], x[further], y[further]
    count[moved[-1]] += COUNTS_PER_TURN
    changed = replace(readings, count=count, autocollimator_x_arcsec=x, autocollimator_y_arcsec=y)
    sentence = f"from reading {row + 1} to {series_end} the shaft stands one face further than the list of faces"
    return changed, sentence


def clockwise(readings: PolygonReadings, faces: int, rng: np.random.Generator):
    """The shaft is turned the other way: the reading falls, while the faces are listed as if it rose."""
    by_face = _certificate(readings, faces)
    # What is read at a position belongs to that position: a series is taken from its other end.
    changed = []
    for series in _series(readings):
        rows = series[::-1]
        part = readings.where(rows)
        changed.append(
            replace(
                part,
                count=part.count - COUNTS_PER_TURN,
                direction=readings.direction[series],
                face_deviation_arcsec=by_face[-part.face],
            )
        )
    joined = {name: np.concatenate([getattr(part, name) for part in changed]) for name in vars(readings)}
    return PolygonReadings(**joined), "turned the other way, reading falling"


MISTAKES: dict[str, Mistake] = {
    "sign": flipped_sign,
    "arcmin": arc_minutes,
    "order": wrong_order,
    "certificate-order": mirrored_certificate,
    "certificate-shift": shifted_certificate,
    "certificate-slip": slipped_certificate,
    "skip": skipped_face,
    "jump": jump_of_one_face,
    "clockwise": clockwise,
}
"""The name of each mistake, as the command takes it."""


def _certificate(readings: PolygonReadings, faces: int) -> np.ndarray:
    """The deviation of each face as the run has it, float64[faces]."""
    by_face = np.zeros(faces)
    by_face[readings.face] = readings.face_deviation_arcsec
    return by_face


def _series(readings: PolygonReadings) -> list[np.ndarray]:
    """Row numbers of each series: one round in one direction."""
    series = 2 * readings.round + readings.direction
    return np.split(np.arange(series.size), np.flatnonzero(np.diff(series)) + 1)


def _series_end(readings: PolygonReadings) -> int:
    return int(_series(readings)[0][-1]) + 1


def _place(readings: PolygonReadings, faces: int, rng: np.random.Generator) -> int:
    """A row inside the first series, so that there are rows of the same series on both sides."""
    return int(rng.integers(2, _series_end(readings) - 3))
