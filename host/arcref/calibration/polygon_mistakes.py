"""Operator's mistakes that leave a run in good order and its numbers wrong, found from the numbers.

Each mistake has its alternative: the same run as it would read had the mistake not been made (x with the other sign,
the certificate turned by a face, ...). A suspicion is raised when an alternative explains the run so much better than
the run as given that chance cannot have done it. Two places show it:

- from face to face: errors of an encoder are smooth, face deviations and settings are not. What a smooth curve leaves
  of the errors, over what it leaves of the alternative's, is the gain;
- from round to round: the same face must give the same error, however the encoder was set.

Chance: were the run right, the change that the alternative makes would have nothing to do with the errors. From face to
face it is taken as normally distributed in each order of the turn, with whatever variance suits the alternative best:
that the power of an order falls to a part r or less then has a chance of r/e at most (for an order with one phase only,
sqrt(2 r / (pi e))), and Fisher's rule puts the orders together. From round to round it is a vector of any length and of
random direction in d dimensions: that squares fall to a part r has the chance I(r; (d - 1)/2, 1/2) / 2, I being the
regularised incomplete beta function. d counts no more than the readings that change, or the orders by their entropy.
No alternative is ever put in place of the run: the user corrects it, or accepts it as it stands.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import betainc, gammaincc, xlogy
from scipy.stats import t

from arcref.calibration.polygon_reduction import series_residual, unreferenced_errors
from arcref.calibration.polygon_run import DEVIATION, PolygonRun, X
from arcref.input_error import InputError

CHANCE = 1e-5
"""Probability of a false alarm that is put up with, for each kind of mistake."""

OUTLIER_CHANCE = 1e-4

_FACES_PER_SMOOTH_ORDER, _MOST_SMOOTH_ORDERS = 8, 8

_RIVAL = 1.5  # sums of squares this close do not tell two alternatives apart

_TINY_ARCSEC2 = 1e-8  # squares below this are rounding of the file's last digits


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
    even or the odd part of the errors about face 1.
    """

    mistake: str
    column: str
    sentence: str
    advice: str
    errors: np.ndarray
    kinds: int = 1
    from_reading: int | None = None
    parity: int = 0


def suspected_mistake(run: PolygonRun) -> Suspicion | None:
    """The mistake that explains the run best, if chance cannot; None for a run that looks right."""
    given = _errors(run, run.face_deviation_arcsec, run.x_arcsec)
    found = []
    for alternative in _alternatives(run, given):
        chance, left = _chance(given, alternative, run.series.direction)
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
    if freedom < 3 or total < _TINY_ARCSEC2:
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
        off = step if step <= n // 2 else step - n
        yield _Alternative(
            "jump", DEVIATION,
            f"the certificate seems to be {abs(off)} face{'s' * (abs(off) > 1)} {'behind' if off > 0 else 'ahead'}",
            "face 1 of the run and of the certificate must be one", given + of_face - np.roll(of_face, -step), n - 1,
        )  # fmt: skip
    yield from _jumps_on_the_way(run, given, of_face)


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


def _chance(given: np.ndarray, alternative: _Alternative, direction: tuple[int, ...]) -> tuple[float, float]:
    """Probability that chance makes the alternative so much better, and the sum of squares it leaves."""
    changed = alternative.errors != given
    rounds, freedom = series_residual(np.array([given, alternative.errors]), direction)
    faces = _rough(given.mean(axis=0)), _rough(alternative.errors.mean(axis=0))
    left = float((rounds[1] ** 2).sum() + (faces[1] ** 2).sum())
    chances = [1.0]
    if freedom:
        before, after = rounds[0][changed], rounds[1][changed]
        dimensions = min(freedom, _dimensions(_power(rounds[1] - rounds[0])))
        chances.append(_half_beta(before, after, min(dimensions, changed.sum() - 1)))
    touched = changed.any(axis=0)
    if alternative.from_reading is None:
        chances.append(_chance_by_orders(*faces, alternative.parity))
    elif given.shape[0] == 1:
        before, after = faces[0][touched], faces[1][touched]
        dimensions = _dimensions(_power(faces[1] - faces[0])[np.newaxis])
        chances.append(_half_beta(before, after, min(dimensions, touched.sum() - 1)))
    return min(chances), left


def _chance_by_orders(before: np.ndarray, after: np.ndarray, parity: int) -> float:
    """From face to face: the gains of all rough orders together, after Fisher.

    A change of one parity leaves the other part of the errors alone: only its own part is looked at.
    """
    if parity:
        mirror = -np.arange(before.size) % before.size
        before, after = ((errors + parity * errors[mirror]) / 2 for errors in (before, after))
    own = slice(_orders(before.size), None)
    changed = _power(after - before)[own] > _TINY_ARCSEC2
    ratio = (_power(after)[own] + _TINY_ARCSEC2) / (_power(before)[own] + _TINY_ARCSEC2)
    one_phase = np.full(ratio.size, bool(parity))
    one_phase[-1] |= before.size % 2 == 0  # every other face: this order has a sign, and no phase
    chance = np.where(one_phase, np.sqrt(2 * ratio / (np.pi * np.e)), ratio / np.e)
    chance = np.where(changed, np.minimum(chance, 1.0), 1.0)
    return float(gammaincc(ratio.size, -np.log(chance).sum()))


def _half_beta(before: np.ndarray, after: np.ndarray, dimensions: float) -> float:
    """Chance that a random change in so many dimensions makes `after` of `before`; 1 when it is no gain."""
    gain = ((before**2).sum() + _TINY_ARCSEC2) / ((after**2).sum() + _TINY_ARCSEC2)
    if gain <= 1 or dimensions <= 1:
        return 1.0
    return float(0.5 * betainc((dimensions - 1) / 2, 0.5, 1 / gain))


def _orders(faces: int) -> int:
    """The order from which on errors count as rough."""
    return min(faces // _FACES_PER_SMOOTH_ORDER, _MOST_SMOOTH_ORDERS) + 1


def _rough(errors: np.ndarray) -> np.ndarray:
    """What a smooth curve leaves of the errors, float64[..., faces]."""
    spectrum = np.fft.rfft(errors)
    spectrum[..., : _orders(errors.shape[-1])] = 0
    return np.fft.irfft(spectrum, errors.shape[-1])


def _power(errors: np.ndarray) -> np.ndarray:
    """Sum of squares over the faces that each order makes, float64[..., orders]."""
    faces = errors.shape[-1]
    power = 2 * np.abs(np.fft.rfft(errors)) ** 2 / faces
    power[..., 0] /= 2
    if faces % 2 == 0:
        power[..., -1] /= 2
    return power


def _dimensions(power: np.ndarray) -> float:
    """In how many dimensions a change of such powers, float64[rows, orders], really goes: 2 exp(entropy) each row.

    Random face deviations reach two thirds of all dimensions by this measure, which errs on the side of no alarm.
    """
    total = power.sum(axis=-1, keepdims=True)
    changed = total[:, 0] > 0
    share = power[changed] / total[changed]
    return float(2 * np.exp(-xlogy(share, share).sum(axis=-1)).sum())


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
    rough = [np.sqrt(np.mean(_rough(errors) ** 2)) for errors in (given, alternative.errors)]
    angle = float(f"{run.angle_deg[face] % 360:.5g}")
    sentence = alternative.sentence + (f" (or else {rival.sentence})" if rival else "")
    problem = (
        f"{sentence}: if so, the error of face {face + 1} ({angle:g} deg) is {after[series, face]:+.2f} "
        f"arcsec about the mean in place of {before[series, face]:+.2f}, and the scatter {rough[1]:.2f} in place of "
        f"{rough[0]:.2f} arcsec; {alternative.advice}"
    )
    return Suspicion(alternative.mistake, reading, alternative.column, problem, chance)
