"""A theodolite run: encoder readings over an arc, azimuth and zenith readings of the mirror's normal."""

from dataclasses import dataclass

import numpy as np

from arcref.calibration.metadata_key import THEODOLITE
from arcref.calibration.metadata_keys import known_keys
from arcref.calibration.stated_values import stated_number, stated_plus_or_minus_one
from arcref.calibration.theodolite_mistakes import (
    AZIMUTH,
    READING,
    ZENITH,
    refuse_absurd,
    refuse_azimuth,
    refuse_swapped,
    refuse_zenith,
)
from arcref.calibration.theodolite_solution import ArcReadings
from arcref.input_error import InputError
from arcref.run_file import RunFile, read_run_file

ROUND = "round"

FEWEST_PLACES = 5
"""Three parameters are fitted to the elevations; two more show whether they fit at all."""

SAME_PLACE_DEG = 0.01
"""Readings of several rounds closer than this are one place of the arc."""

SMALLEST_ARC_DEG = 0.1


@dataclass(frozen=True, eq=False)
class TheodoliteRun:
    """Readings of mirror and theodolite over an arc of the encoder.

    float64[n]: `reading_deg`, brought into one arc; `azimuth_deg`, near `direction * (reading - datum)` but for a
    constant of each round; `zenith_deg`. int[n]: `place` of the arc and `round`, both from 0.
    `direction`: +1 when the encoder's reading grows clockwise seen from above; `datum_deg`: reading at which the angles
    of axis and mirror are stated, `datum_basis` where it comes from.
    """

    run: RunFile
    direction: int
    datum_deg: float
    datum_basis: str
    reading_deg: np.ndarray
    azimuth_deg: np.ndarray
    zenith_deg: np.ndarray
    place: np.ndarray
    round: np.ndarray
    u_azimuth_arcsec: float | None
    u_zenith_arcsec: float | None

    @property
    def readings(self) -> ArcReadings:
        """The readings as `solve_arc` takes them."""
        return ArcReadings(
            np.radians(self.direction * (self.reading_deg - self.datum_deg)),
            np.radians(self.azimuth_deg),
            np.radians(self.zenith_deg - 90.0),
            self.place,
            self.round,
        )

    @property
    def angle_deg(self) -> np.ndarray:
        """float64[places]: encoder's angle of each place, the mean of its readings, increasing."""
        return np.bincount(self.place, self.reading_deg) / np.bincount(self.place)

    @property
    def rounds(self) -> int:
        """Number of rounds."""
        return int(self.round.max()) + 1

    @property
    def arc_deg(self) -> float:
        """From the first place to the last."""
        return float(np.ptp(self.angle_deg))

    @property
    def goes_around(self) -> bool:
        """True when the places go around the turn: the gap over the seam is no larger than twice the usual."""
        gaps = np.diff(self.angle_deg)
        return 360.0 - self.arc_deg <= 2 * float(np.median(gaps))


def read_theodolite_run(path) -> TheodoliteRun:
    """Read a theodolite run.

    Raises `InputError` for all that `read_run_file` refuses, numbers that no theodolite shows or that are meant
    otherwise (elevation for zenith, gon for degrees, swapped columns), azimuths that run against the encoder, a place
    read twice in one round, too few readings, and metadata that cannot be.
    """
    run = read_run_file(path, (READING, AZIMUTH, ZENITH), (ROUND,), known_keys(THEODOLITE))
    direction = stated_plus_or_minus_one(run, "encoder_direction") or 1
    u_azimuth, u_zenith = stated_number(run, "u_azimuth_arcsec"), stated_number(run, "u_zenith_arcsec")
    if len(run.rows) < FEWEST_PLACES:
        raise InputError.at(run.path, f"{len(run.rows)} readings, at least {FEWEST_PLACES} were expected")
    refuse_absurd(run, READING)
    refuse_absurd(run, AZIMUTH)
    reading = _near_zero(_one_arc(run[READING]))
    if np.ptp(reading) < SMALLEST_ARC_DEG:
        problem = f"all readings lie within {np.ptp(reading):g} deg, an arc of {SMALLEST_ARC_DEG:g} deg or more"
        raise run.error(f"{problem} was expected", reading=0, column=READING)
    round_ = _rounds(run)
    azimuth = _azimuths(run, reading, round_, direction)
    refuse_swapped(run, reading, azimuth)
    refuse_zenith(run)
    refuse_azimuth(run, reading, azimuth, direction)
    place = _places(run, reading, round_)
    datum, basis = _datum(run, reading)
    azimuth = azimuth - direction * datum
    return TheodoliteRun(
        run, direction, datum, basis, reading, azimuth, run[ZENITH], place, round_, u_azimuth, u_zenith
    )


def _datum(run: RunFile, reading_deg: np.ndarray) -> tuple[float, str]:
    """The reading at which theta is 0, near the arc, and where it comes from."""
    stated = stated_number(run, "datum_deg")
    if stated is not None:
        near = stated + 360.0 * np.rint((reading_deg.mean() - stated) / 360.0)
        return float(near), "stated"
    for turn in (0.0, 360.0, -360.0):
        if reading_deg.min() - SAME_PLACE_DEG <= turn <= reading_deg.max():
            return turn, "the encoder's zero, which lies in the arc"
    return float(reading_deg[0]), "the first reading"


def _one_arc(reading_deg: np.ndarray) -> np.ndarray:
    """Readings over the encoder's zero brought together: the largest gap around the turn is outside the arc."""
    ordered = np.sort(np.mod(reading_deg, 360.0))
    gaps = np.diff(ordered, append=ordered[0] + 360.0)
    first = ordered[(int(np.argmax(gaps)) + 1) % len(ordered)]
    together = first + np.mod(reading_deg - first + 1e-9, 360.0) - 1e-9
    if np.ptp(reading_deg) <= np.ptp(together) + 1e-6:
        return reading_deg.copy()
    return together - 360.0 if together.max() >= 360.0 else together


def _near_zero(reading_deg: np.ndarray) -> np.ndarray:
    """The same arc, whole turns left out, in the turn next to the encoder's zero: an error curve begins there."""
    first = float(reading_deg.min())
    return reading_deg if -359.0 <= first <= 359.0 else reading_deg - 360.0 * np.rint(first / 360.0)


def _azimuths(run: RunFile, reading_deg: np.ndarray, round_: np.ndarray, direction: int) -> np.ndarray:
    """Azimuths without jumps over north, each round's circle turned so that it runs about zero with the reading."""
    azimuth = run[AZIMUTH].copy()
    for number in np.unique(round_):
        own = np.flatnonzero(round_ == number)
        own = own[np.argsort(reading_deg[own], kind="stable")]
        unwrapped = np.unwrap(azimuth[own], period=360.0)
        azimuth[own] = unwrapped - np.median(unwrapped - direction * reading_deg[own])
    return azimuth


def _rounds(run: RunFile) -> np.ndarray:
    if ROUND not in run.columns:
        return np.zeros(len(run.rows), int)
    values = run[ROUND]
    wrong = np.flatnonzero((values != np.rint(values)) | (values < 1))
    if wrong.size:
        raise run.error(
            f"{values[wrong[0]]:g}, whole numbers from 1 were expected", reading=int(wrong[0]), column=ROUND
        )
    return np.unique(values, return_inverse=True)[1].ravel()


def _places(run: RunFile, reading_deg: np.ndarray, round_: np.ndarray) -> np.ndarray:
    """Which place of the arc each reading belongs to."""
    order = np.argsort(reading_deg, kind="stable")
    place = np.empty(len(order), int)
    place[order] = np.concatenate([[0], np.cumsum(np.diff(reading_deg[order]) > SAME_PLACE_DEG)])
    first: dict[tuple[int, int], int] = {}
    for index in range(len(place)):
        before = first.setdefault((int(round_[index]), int(place[index])), index)
        if before != index:
            problem = f"{run[READING][index]:g} deg is given twice (before in row {run.rows[before]})"
            raise run.error(f"{problem}; a second round needs a column round", reading=index, column=READING)
    places = int(place.max()) + 1
    if places < FEWEST_PLACES:
        raise InputError.at(run.path, f"{places} places of the arc, at least {FEWEST_PLACES} were expected")
    return place
