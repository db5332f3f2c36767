"""Operator's mistakes that leave a run in good order: caught and named, and no good run is taken for one."""

from dataclasses import replace

import numpy as np
import pytest

from arcref.calibration.polygon_mistakes import outliers, suspected_mistake
from arcref.calibration.polygon_run import PolygonRun
from arcref.calibration.polygon_series import PolygonSeries

FACES = (7, 8, 12, 17, 23, 24, 36)


def smooth_or_rough(random, faces, rms_arcsec, slope):
    """Deviations or errors at the faces whose orders fall off with this power; 0 is as rough as can be."""
    order = np.arange(1, faces // 2 + 1)
    size = random.normal(size=order.size) * order**-slope
    angle = np.outer(order, np.arange(faces)) * 2 * np.pi / faces
    wave = (size[:, np.newaxis] * np.cos(angle + random.uniform(0, 2 * np.pi, (order.size, 1)))).sum(axis=0)
    return rms_arcsec * wave / wave.std()


def harmonic_error(random, faces):
    """Orders 1, 2, 3, 4, 8 of 3 arcsec in all."""
    angle = np.arange(faces) * 2 * np.pi / faces
    sizes = 3 * random.dirichlet(np.ones(5))
    return sum(
        size * np.sin(order * angle + random.uniform(0, 7)) for order, size in zip((1, 2, 3, 4, 8), sizes, strict=True)
    )


def made_run(
    random, faces, rounds, error, deviation, noise_arcsec=0.2, setting_arcsec=2.0, setting="scattered", both=False,
    drift_arcsec=0.0, sign=1,
) -> PolygonRun:  # fmt: skip
    """A good run; `setting`: the shaft is stopped anywhere near, each face always alike, or where x is about nought."""
    directions = [-1 if both and number % 2 else 1 for number in range(rounds)]
    face = np.concatenate([np.arange(faces) * way % faces for way in directions])
    place = np.empty((rounds, faces), int)
    for number in range(rounds):
        place[number, face[number * faces : (number + 1) * faces]] = np.arange(number * faces, (number + 1) * faces)
    count = face.size
    total = error[face] + deviation[face] + noise_arcsec * random.normal(size=count)
    total += drift_arcsec * np.arange(count) / faces
    if setting == "nulled":
        stopped = total - setting_arcsec * random.normal(size=count)
    elif setting == "alike":
        stopped = (setting_arcsec * random.normal(size=faces))[face]
    else:
        stopped = setting_arcsec * random.normal(size=count)
    angle = np.arange(faces) * 360.0 / faces
    first = np.arange(rounds) * faces
    series = PolygonSeries(
        angle, face, place, first, np.full(rounds, -1), tuple(range(1, rounds + 1)), tuple(directions)
    )
    x = np.round(sign * (total - stopped), 2)
    position = angle[face] + np.round(stopped, 3) / 3600
    basis = "by the run file"
    return PolygonRun(None, faces, sign, position, np.round(deviation, 2)[face], x, None, series, sign_basis=basis)


def test_no_good_run_is_taken_for_a_mistake():
    """Faces, rounds, polygons and encoders rough and smooth, noise, drift, and how the shaft is set, all at random."""
    random = np.random.default_rng(20150512)
    for _ in range(250):
        faces = int(random.choice(FACES))
        deviation = smooth_or_rough(random, faces, 10 ** random.uniform(-1, 1), random.uniform(0, 2.5))
        error = smooth_or_rough(random, faces, 10 ** random.uniform(-1, 1.3), random.uniform(0, 2.5))
        run = made_run(
            random,
            faces,
            int(random.choice([1, 1, 2, 4])),
            error,
            deviation - deviation[0],
            noise_arcsec=10 ** random.uniform(-2, 0),
            setting_arcsec=10 ** random.uniform(-2, 1.5),
            setting=str(random.choice(["scattered", "alike", "nulled"])),
            both=bool(random.integers(2)),
            drift_arcsec=random.choice([0.0, 0.3]) * random.normal(),
            sign=int(random.choice([1, -1])),
        )
        suspicion = suspected_mistake(run)
        assert suspicion is None, suspicion


def changed(run: PolygonRun, **values) -> PolygonRun:
    return PolygonRun(**(vars(run) | values))


def flipped(run):
    return changed(run, x_arcsec=-run.x_arcsec)


def x_in_arcmin(run):
    return changed(run, x_arcsec=np.round(run.x_arcsec / 60, 4))


def deviation_in_arcmin(run):
    return changed(run, face_deviation_arcsec=run.face_deviation_arcsec / 60)


def opposite_certificate(run):
    return changed(run, face_deviation_arcsec=-run.face_deviation_arcsec)


def of_face(run):
    return run.face_deviation_arcsec[run.series.reading_of_face[0]]


def clockwise(run):
    return changed(run, face_deviation_arcsec=-of_face(run)[-run.face])


def one_face_off(run):
    return changed(run, face_deviation_arcsec=np.roll(of_face(run), 1)[run.face])


def slipped(run):
    """The ninth line of the certificate was lost, and those behind it moved up."""
    right = of_face(run)
    wrong = np.concatenate([right[:8], right[9:], right[-1:]])
    return changed(run, face_deviation_arcsec=wrong[run.face])


MISTAKES = {
    "sign": flipped,
    "arcmin": x_in_arcmin,
    "arcmin, certificate": deviation_in_arcmin,
    "certificate sign": opposite_certificate,
    "clockwise": clockwise,
    "jump": one_face_off,
    "jump, certificate": slipped,
}


@pytest.mark.parametrize("rounds", [1, 4])
@pytest.mark.parametrize("name", MISTAKES)
def test_mistakes_are_caught_and_named(name, rounds):
    """24 faces, a polygon of 2 arcsec, an encoder of harmonics 1, 2, 3, 4, 8 and 0.2 arcsec of noise.

    With this the change each mistake makes is five times the rough part of the errors. An encoder whose errors change
    from face to face as much as the polygon's hides a wrong certificate: nothing in one run can tell the two apart.
    """
    random = np.random.default_rng(7)
    named = []
    for _ in range(20):
        deviation = random.normal(0, 2.0, 24)
        run = made_run(random, 24, rounds, harmonic_error(random, 24), deviation - deviation[0])
        suspicion = suspected_mistake(MISTAKES[name](run))
        named.append("nothing" if suspicion is None else suspicion.mistake)
    right = named.count(name.partition(",")[0])
    # Clockwise for counter-clockwise changes one half of the numbers only, those alike on both sides of face 1; a line
    # lost leaves the first faces as they were.
    assert right >= {"clockwise": 16, "jump, certificate": 10}.get(name, 19), named
    assert right + named.count("nothing") >= 19, named


@pytest.mark.parametrize("faces", [8, 12, 36])
def test_other_numbers_of_faces_show_a_flipped_sign_in_two_rounds(faces):
    random = np.random.default_rng(9)
    for _ in range(10):
        deviation = random.normal(0, 1.0, faces)
        run = made_run(random, faces, 2, harmonic_error(random, faces), deviation - deviation[0], noise_arcsec=0.1)
        assert suspected_mistake(run) is None
        assert suspected_mistake(flipped(run)).mistake == "sign"


@pytest.mark.parametrize("way", [1, -1])
def test_a_jump_on_the_way_is_found_at_its_row(way):
    """From the 14th face of the third round on, the polygon stands a face further than the run says."""
    random = np.random.default_rng(11)
    found = []
    for _ in range(15):
        deviation = random.normal(0, 2.0, 24)
        run = made_run(random, 24, 4, harmonic_error(random, 24), deviation - deviation[0], both=way < 0)
        rows = np.arange(run.face.size)
        series = 2 if way > 0 else 3
        jumped = (rows >= 24 * series + 13) & (rows < 24 * (series + 1))
        of_faces = of_face(run)
        off = of_faces[(run.face + way) % 24] - of_faces[run.face]
        suspicion = suspected_mistake(changed(run, x_arcsec=run.x_arcsec + np.where(jumped, off, 0)))
        assert suspicion.mistake == "jump"
        assert "jumped one face on" in suspicion.problem
        found.append(suspicion.reading - (24 * series + 13))
    # A neighbour with nearly the same deviation may hide the very row.
    assert found.count(0) >= 9
    assert max(map(abs, found)) <= 2


def test_the_line_tells_what_it_found():
    random = np.random.default_rng(2)
    run = made_run(random, 24, 2, harmonic_error(random, 24), np.zeros(24), setting_arcsec=20.0)
    problem = suspected_mistake(flipped(run)).problem
    assert problem.startswith("the sign of x seems to be flipped")
    assert "the error of face" in problem
    assert problem.endswith("the autocollimator_sign is +1 by the run file")


def test_what_cannot_be_told_apart_is_named_together():
    """Every setting alike: the sign of x and that of the certificate do the same, but for the sign of the error."""
    random = np.random.default_rng(5)
    deviation = random.normal(0, 2.0, 24)
    run = made_run(
        random, 24, 1, harmonic_error(random, 24), deviation - deviation[0], setting_arcsec=0.0, noise_arcsec=0.05
    )
    problem = suspected_mistake(opposite_certificate(run)).problem
    assert "the sign of x seems to be flipped" in problem
    assert "the face deviations seem to have the opposite sign" in problem


def test_a_run_without_certificate_can_show_its_sign_by_its_rounds():
    random = np.random.default_rng(6)
    run = made_run(random, 24, 2, harmonic_error(random, 24), np.zeros(24))
    run = changed(run, face_deviation_arcsec=None)
    assert suspected_mistake(run) is None
    assert suspected_mistake(flipped(run)).mistake == "sign"


def test_a_run_without_any_noise_is_no_mistake():
    random = np.random.default_rng(1)
    deviation = np.round(random.normal(0, 2.0, 24), 2)
    for error in (np.zeros(24), harmonic_error(random, 24)):
        run = made_run(random, 24, 2, error, deviation - deviation[0], noise_arcsec=0.0)
        assert suspected_mistake(run) is None
        assert outliers(run) == []


def test_an_outlier_is_named_and_scatter_is_not():
    random = np.random.default_rng(12)
    alarms, found = 0, 0
    for _ in range(200):
        deviation = random.normal(0, 2.0, 24)
        run = made_run(random, 24, 4, harmonic_error(random, 24), deviation - deviation[0])
        alarms += len(outliers(run))
        x = run.x_arcsec.copy()
        x[40] += 2.0  # ten times the noise
        (reading, off_arcsec, _), *more = outliers(changed(run, x_arcsec=x)) or [(None, 0.0, 1.0)]
        found += reading == 40 and not more and abs(off_arcsec - 2.0) < 0.9
    assert alarms <= 1
    assert found >= 185


def run_with_y(random, swapped):
    """A good run with y: tower tilt and noise of any size; `swapped`: as if x stood in the other column."""
    faces = int(random.choice(FACES))
    deviation = smooth_or_rough(random, faces, 10 ** random.uniform(-2, 1), random.uniform(0, 2.5))
    error = smooth_or_rough(random, faces, 10 ** random.uniform(-1, 1.3), random.uniform(0, 2.5))
    settings = str(random.choice(["scattered", "alike", "nulled"]))
    noise = 10 ** random.uniform(-2, 0)
    run = made_run(
        random, faces, int(random.choice([1, 2, 4])), error, deviation - deviation[0], noise_arcsec=noise,
        setting_arcsec=10 ** random.uniform(-2, 1.5), setting=settings,
    )  # fmt: skip
    azimuth = np.radians(run.theta_deg) - random.uniform(0, 2 * np.pi)
    y = 10 ** random.uniform(-1, 2.5) * np.cos(azimuth) + 10 ** random.uniform(-3, 0) * random.normal(size=azimuth.size)
    return replace(run, x_arcsec=y, y_arcsec=run.x_arcsec) if swapped else replace(run, y_arcsec=y)


def test_no_good_run_with_y_is_taken_for_swapped_columns():
    random = np.random.default_rng(20261123)
    assert [suspected_mistake(run_with_y(random, False)) for _ in range(100)] == [None] * 100


def test_swapped_x_and_y_are_caught():
    """24 faces, a polygon of 2 arcsec, the tilt that any mounting leaves."""
    random = np.random.default_rng(7)
    for psi_arcsec in (0.0, 3.0, 300.0):
        deviation = smooth_or_rough(random, 24, 2.0, 0)
        run = made_run(random, 24, 2, harmonic_error(random, 24), deviation - deviation[0])
        y = psi_arcsec * np.cos(np.radians(run.theta_deg) - 1) + 0.1 * random.normal(size=run.x_arcsec.size)
        found = suspected_mistake(replace(run, x_arcsec=y, y_arcsec=run.x_arcsec))
        assert found.mistake == "columns"
        assert "x and y seem to be swapped" in found.problem
