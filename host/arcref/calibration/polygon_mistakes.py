"""Operator's mistakes that leave a run in good order and its numbers wrong, found from the numbers.

Each mistake has its alternative: the same run as it would read had the mistake not been made (x with the other sign,
the certificate turned by a face, ...). A suspicion is raised when an alternative explains the run so much better than
the run as given that chance cannot have done it. Two places show it:

- from face to face: errors of an encoder are smooth, face deviations and settings are not. What a smooth curve leaves
  of the errors, over what it leaves of the alternative's, is the gain;
- from round to round: the same face must give the same error, however the encoder was set.

How little chance can do is worked out in `chance_of_gain`. No alternative is ever put in place of the run: the user
corrects it, or accepts it as it stands.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import t

from arcref.calibration.chance_of_gain import TINY_ARCSEC2, chance_of_gain, rough_part
from arcref.calibration.polygon_reduction import series_residual, unreferenced_errors
from arcref.calibration.polygon_run import DEVIATION, PolygonRun, X, Y
from arcref.input_error import InputError

CHANCE = 1e-5
"""Probability of a false alarm that is put up with, for each kind of mistake."""

OUTLIER_CHANCE = 1e-4
"""The same for a reading that stands out from the other rounds."""

_RIVAL = 1.5  # sums of squares this close do not tell two alternatives apart


@dataclass(frozen=True)
class Suspicion:
    """A mistake that seems to have been made: which, where it shows best, why, and how sure it is."""

    mistake: str
    reading: int
    column: str
    problem: str
    chance: float

    def error(self, run: PolygonRun) -> InputError:
        """The line for the user."""
        problem = f"{self.problem}; correct the run file, or accept it as it is with --accept-suspect"
        return run.run.error(problem, reading=self.reading, column=self.column)


@dataclass(frozen=True)
class _Alternative:
    """A run without a mistake: `errors` float64[series, faces], and how many alternatives of its kind there are.

    `from_reading`: where the mistake began, None for the whole run; `parity`: +1 or -1 when all that it changes is the
    even or the odd part of the errors about face 1; `without`: what it must explain as well.
    """

    mistake: str
    column: str
    sentence: str
    advice: str
    errors: np.ndarray
    kinds: int = 1
    from_reading: int | None = None
    parity: int = 0
    without: np.ndarray | None = None


def suspected_mistake(run: PolygonRun) -> Suspicion | None:
    """The mistake that explains the run best, if chance cannot; None for a run that looks right."""
    given = _errors(run, run.face_deviation_arcsec, run.x_arcsec)
    found = []
    for alternative in _alternatives(run, given):
        chance, left = chance_of_gain(
            given, alternative.errors, run.series.direction, alternative.from_reading is None, alternative.parity
        )
        if alternative.without is not None:
            by_itself, _ = chance_of_gain(alternative.without, alternative.errors, run.series.direction, True)
            chance = max(chance, by_itself)
        if chance * alternative.kinds < CHANCE:
            found.append((left, alternative, chance * alternative.kinds))
    if not found:
        return None
    found.sort(key=lambda each: each[0])
    least, best, chance = found[0]
    # Another mistake that explains the run as well is named too: with every setting alike, the sign of x and that of
    # the certificate cannot be told apart.
    rival = next((each for left, each, _ in found if each.sentence != best.sentence and left < _RIVAL * least), None)
    return _suspicion(run, given, best, rival, chance)


def outliers(run: PolygonRun) -> list[tuple[int, float, float]]:
    """Readings that stand out from the other rounds: reading, arcsec from what is left, and the chance of it.

    The test is that of the externally studentised residual, for the largest of all readings.
    """
    residual, freedom = series_residual(_errors(run, run.face_deviation_arcsec, run.x_arcsec), run.series.direction)
    direction = np.array(run.series.direction)
    same_way = np.array([(direction == own).sum() for own in direction])[:, np.newaxis]
    # Part of a reading's own variance that stays in its residual.
    kept = np.where(same_way > 1, (1 - 1 / same_way) * (1 - 1 / run.faces), np.nan)
    total = (residual**2).sum()
    if freedom < 3 or total < TINY_ARCSEC2:
        return []
    own = residual**2 / kept
    studentised = np.sqrt(own * (freedom - 1) / np.maximum(total - own, 1e-300))
    chance = 2 * t.sf(studentised, freedom - 1) * residual.size
    found = np.argwhere(chance < OUTLIER_CHANCE)
    place = run.series.reading_of_face
    return [(int(place[s, f]), float(residual[s, f] / kept[s, 0]), float(chance[s, f])) for s, f in found]


def _errors(run: PolygonRun, deviation, x) -> np.ndarray:
    nominal = run.angle_deg[run.face]
    error = unreferenced_errors(run.position_deg, nominal, deviation, x, run.sign)
    return error[run.series.reading_of_face]


def _alternatives(run: PolygonRun, given: np.ndarray) -> Iterator[_Alternative]:
    b, x, n = run.face_deviation_arcsec, run.x_arcsec, run.faces
    yield _Alternative(
        "sign", X, "the sign of x seems to be flipped",
        f"the autocollimator_sign is {run.sign:+d} {run.sign_basis}", _errors(run, b, -x),
    )  # fmt: skip
    yield _Alternative(
        "arcmin", X, "x seems to be in minutes of arc", "seconds of arc were expected", _errors(run, b, 60 * x)
    )
    if run.y_arcsec is not None:
        # A quiet y alone is no better x: it must explain the settings and face deviations that x has to explain.
        yield _Alternative(
            "columns", X, "x and y seem to be swapped", f"{Y} would then be x", _errors(run, b, run.y_arcsec),
            without=_errors(run, b, np.zeros_like(run.x_arcsec)),
        )  # fmt: skip
    if b is None:
        return
    of_face = b[run.series.reading_of_face[0]]
    yield _Alternative(
        "arcmin", DEVIATION, "the face deviations seem to be in minutes of arc", "seconds of arc were expected",
        given - 59 * of_face,
    )  # fmt: skip
    yield _Alternative(
        "certificate sign", DEVIATION, "the face deviations seem to have the opposite sign",
        "face angle minus nominal was expected", given + 2 * of_face,
    )  # fmt: skip
    mirrored = of_face[-np.arange(n) % n]
    for turned, parity in ((mirrored, -1), (-mirrored, 1)):
        yield _Alternative(
            "clockwise", DEVIATION, "the faces seem to be counted clockwise for counter-clockwise",
            "face numbers must rise as the encoder's reading does", given + of_face - turned, 2, parity=parity,
        )  # fmt: skip
    for step in range(1, n):
        yield _Alternative(
            "jump", DEVIATION, f"face 1 of the run seems to be the one whose deviation stands at face {step + 1}",
            "the certificate must begin at the face that was read first", given + of_face - np.roll(of_face, -step),
            n - 1,
        )  # fmt: skip
    if len(given) > 1:
        yield from _certificate_slips(run, given, of_face)
    yield from _jumps_on_the_way(run, given, of_face)


def _certificate_slips(run: PolygonRun, given: np.ndarray, of_face: np.ndarray) -> Iterator[_Alternative]:
    """From one face on, in every round, the deviations are those of the neighbouring face: a line lost or doubled."""
    n = run.faces
    for step in (1, -1):
        change = of_face - np.roll(of_face, -step)
        for start in range(1, n):
            yield _Alternative(
                "jump", DEVIATION, "from here on the certificate seems to have slipped by one face",
                "a line of it was lost or doubled as it was copied", given + np.where(np.arange(n) >= start, change, 0),
                2 * (n - 1), int(run.series.reading_of_face[0, start]),
            )  # fmt: skip


def _jumps_on_the_way(run: PolygonRun, given: np.ndarray, of_face: np.ndarray) -> Iterator[_Alternative]:
    """From one reading of one series on, the polygon was a face further, or a face behind, than the run says."""
    series, n = given.shape
    for row in range(series):
        order = np.argsort(run.series.reading_of_face[row])  # faces as this series read them
        way = run.series.direction[row]
        for step in (1, -1):
            change = of_face - np.roll(of_face, -step * way)
            for start in range(1, n):
                errors = given.copy()
                errors[row, order[start:]] += change[order[start:]]
                yield _Alternative(
                    "jump", DEVIATION,
                    f"the polygon seems to have jumped one face {'on' if step > 0 else 'back'} here",
                    "from this row on the face deviations fit the neighbouring face", errors, 2 * series * (n - 1),
                    int(run.series.reading_of_face[row, order[start]]),
                )  # fmt: skip


def _suspicion(
    run: PolygonRun, given: np.ndarray, alternative: _Alternative, rival: _Alternative | None, chance: float
) -> Suspicion:
    """Put it into words, at the reading that shows it best."""
    before, after = (errors - errors.mean(axis=-1, keepdims=True) for errors in (given, alternative.errors))
    series, face = np.unravel_index(int(np.argmax(np.abs(before) - np.abs(after))), before.shape)
    reading = alternative.from_reading
    if reading is None:
        reading = int(run.series.reading_of_face[series, face])
    else:
        series, face = np.argwhere(run.series.reading_of_face == reading)[0]
    rough = [np.sqrt(np.mean(rough_part(errors) ** 2)) for errors in (given, alternative.errors)]
    angle = float(f"{run.angle_deg[face] % 360:.5g}")
    sentence = alternative.sentence + (f" (or else {rival.sentence})" if rival else "")
    problem = (
        f"{sentence}: if so, the error of face {face + 1} ({angle:g} deg) is {after[series, face]:+.2f} "
        f"arcsec about the mean in place of {before[series, face]:+.2f}, and the scatter {rough[1]:.2f} in place of "
        f"{rough[0]:.2f} arcsec; {alternative.advice}"
    )
    return Suspicion(alternative.mistake, reading, alternative.column, problem, chance)
