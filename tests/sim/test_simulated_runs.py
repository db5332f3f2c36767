"""Simulated runs obey the papers' formulas: what was put in comes out by the plain arithmetic of the method."""

from dataclasses import replace

import numpy as np
import pytest

from arcref.angle import ARCSEC_PER_COUNT
from arcref_sim.metrology.face_view import ARCSEC_PER_RAD, face_view, rotated, tilted_axis
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder
from arcref_sim.metrology.operator_mistakes import MISTAKES
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.simulated_closure import ClosureConditions, simulate_closure
from arcref_sim.metrology.simulated_polygon import Autocollimator, PolygonConditions, simulate_polygon
from arcref_sim.metrology.simulated_theodolite import TheodoliteConditions, mirror_direction, simulate_theodolite

ENCODER = KnownEncoder((Harmonic(1, 3.0, 40.0), Harmonic(4, 1.0, 10.0), Harmonic(8, 0.5, 0.0)))
FACES = (7, 8, 12, 17, 23, 24, 36, 72)

# Readings are whole counts: nothing is known closer than the two roundings of a difference.
ROUNDING_ARCSEC = 1.01 * ARCSEC_PER_COUNT


def polygon(faces, seed=5, **options):
    return PolygonArtefact.random(np.random.default_rng(seed), faces, **({"deviation_arcsec": 2.0} | options))


def run(artefact, autocollimator=None, seed=6, encoder=ENCODER, **conditions):
    rng = np.random.default_rng(seed)
    return simulate_polygon(encoder, artefact, autocollimator or Autocollimator(), PolygonConditions(**conditions), rng)


def reduced_arcsec(readings, faces, sign=1):
    """e = (a - a1) - (b - b1) + sign (c - c1), of the readings themselves."""
    a = readings.position_deg * 3600
    b = readings.face * 1_296_000 / faces + readings.face_deviation_arcsec
    e = a - b + sign * readings.autocollimator_x_arcsec
    return (e - e[0] + 648_000) % 1_296_000 - 648_000


def errors_arcsec(readings, encoder=ENCODER):
    error = encoder.error_arcsec(readings.true_deg)
    return error - error[0]


@pytest.mark.parametrize("faces", FACES)
@pytest.mark.parametrize("sign", [1, -1])
def test_the_reduction_of_a_clean_polygon_run_is_the_error_of_the_encoder(faces, sign):
    readings = run(polygon(faces), Autocollimator(sign=sign), rounds=2, backward=True, start_deg=17.0)
    assert readings.face.size == 4 * (faces + 1)
    assert np.abs(reduced_arcsec(readings, faces, sign) - errors_arcsec(readings)).max() < ROUNDING_ARCSEC


def test_rounds_close_and_go_back_through_the_same_faces():
    readings = run(polygon(8), backward=True)
    assert readings.face.tolist() == [0, 1, 2, 3, 4, 5, 6, 7, 0] + [0, 7, 6, 5, 4, 3, 2, 1, 0]
    assert readings.direction.tolist() == [1] * 9 + [-1] * 9
    assert np.diff(readings.position_deg)[:8] == pytest.approx(45.0, abs=0.01)
    assert np.diff(readings.position_deg)[9:] == pytest.approx(-45.0, abs=0.01)


def test_the_error_of_the_certificate_goes_into_the_result():
    artefact = polygon(24, certificate_error_arcsec=0.4)
    readings = run(artefact)
    wrong = artefact.certificate_arcsec - artefact.deviation_arcsec
    assert wrong[0] == 0
    expected = errors_arcsec(readings) - wrong[readings.face]
    assert np.abs(reduced_arcsec(readings, 24) - expected).max() < ROUNDING_ARCSEC


@pytest.mark.parametrize(("tilt_arcsec", "azimuth_deg"), [(300.0, 90.0), (600.0, 22.0), (1369.0, 67.5)])
def test_tower_tilt_adds_what_the_paper_says(tilt_arcsec, azimuth_deg):
    """Tian Liude et al. 2015, equations (12) and (13), to the size of what they leave out."""
    readings = run(polygon(24, deviation_arcsec=0.0), tilt_arcsec=tilt_arcsec, tilt_azimuth_deg=azimuth_deg)
    turned, omega = np.radians(readings.face * 15.0), np.radians(azimuth_deg)
    f = np.sin(omega) * (1 - np.cos(turned)) * np.cos(omega - turned) + 0.5 * np.sin(turned) * np.cos(turned)
    excess = reduced_arcsec(readings, 24) - errors_arcsec(readings)
    assert excess == pytest.approx(tilt_arcsec**2 / ARCSEC_PER_RAD * f, abs=ROUNDING_ARCSEC)
    y = tilt_arcsec * (np.cos(omega - turned) - np.cos(omega))
    assert readings.autocollimator_y_arcsec == pytest.approx(y, abs=0.1)


def test_the_view_of_a_face_is_that_of_a_rotation(random):
    """An axis keeps itself and lengths keep; a level polygon shows the face angle less the angle turned."""
    axis = tilted_axis(1369.0, 40.0)
    angle = random.uniform(-7, 7, 50)
    assert rotated(axis, axis, angle) == pytest.approx(np.broadcast_to(axis, (50, 3)))
    vectors = random.standard_normal((50, 3))
    turned = rotated(vectors, axis, angle)
    assert np.linalg.norm(turned, axis=1) == pytest.approx(np.linalg.norm(vectors, axis=1))
    assert rotated(turned, axis, -angle) == pytest.approx(vectors)
    x, y = face_view(15.001, 2.0, 15.0, tilted_axis(0.0, 0.0))
    assert (x, y) == (pytest.approx(3.6), pytest.approx(2.0))


def test_roll_gives_x_a_part_of_y():
    options = {"tilt_arcsec": 300.0, "tilt_azimuth_deg": 30.0, "seed": 9}
    straight, rolled = run(polygon(24), **options), run(polygon(24), Autocollimator(roll_arcmin=5.0), **options)
    excess = rolled.autocollimator_x_arcsec - straight.autocollimator_x_arcsec
    assert excess == pytest.approx(np.radians(5 / 60) * straight.autocollimator_y_arcsec, abs=1e-4)
    assert np.ptp(excess) == pytest.approx(2 * 0.436, rel=0.02), "SCIENCE, TW: 5 arcmin at 300 arcsec"


def test_noise_has_the_size_asked_for():
    readings = run(polygon(72), Autocollimator(0.2, 0.5), rounds=40, setting_scatter_arcsec=0.0)
    quiet = run(polygon(72), rounds=40, setting_scatter_arcsec=0.0)
    assert np.std(readings.autocollimator_x_arcsec - quiet.autocollimator_x_arcsec) == pytest.approx(0.2, rel=0.05)
    assert np.std(readings.autocollimator_y_arcsec - quiet.autocollimator_y_arcsec) == pytest.approx(0.5, rel=0.05)


def test_drift_opens_every_round_by_the_same():
    readings = run(polygon(24), rounds=3, drift_arcsec=2.0)
    e = reduced_arcsec(readings, 24)
    for number in (1, 2, 3):
        (rows,) = np.nonzero(readings.round == number)
        assert e[rows[-1]] - e[rows[0]] == pytest.approx(2.0, abs=ROUNDING_ARCSEC)


def test_scale_error_counts_only_where_x_is_large():
    exact = run(polygon(24), setting_scatter_arcsec=50.0)
    off = run(polygon(24), Autocollimator(scale_error=0.01), setting_scatter_arcsec=50.0)
    assert off.autocollimator_x_arcsec == pytest.approx(1.01 * exact.autocollimator_x_arcsec)


def test_hysteresis_shows_between_the_directions_and_not_within_one():
    encoder = replace(ENCODER, hysteresis_arcsec=2.0)
    readings = run(polygon(24), encoder=encoder, backward=True)
    off = reduced_arcsec(readings, 24) - errors_arcsec(readings)
    assert off[:25] == pytest.approx(0.0, abs=ROUNDING_ARCSEC)
    assert off[25:] == pytest.approx(2.0, abs=ROUNDING_ARCSEC)


def test_eccentric_mounting_wanders_over_faces_that_are_not_flat():
    artefact = polygon(24, flatness_arcsec_per_mm=2.0)
    level = run(artefact, eccentricity_mm=0.0)
    off = run(artefact, eccentricity_mm=0.5, eccentricity_deg=30.0)
    excess = off.autocollimator_x_arcsec - level.autocollimator_x_arcsec
    walk_mm = 0.5 * np.sin(np.radians(30.0 - 15.0 * off.face))
    assert excess == pytest.approx(walk_mm * artefact.slope_arcsec_per_mm[off.face], abs=1e-4)
    flat = run(polygon(24), eccentricity_mm=0.5)
    assert np.array_equal(flat.autocollimator_x_arcsec, run(polygon(24)).autocollimator_x_arcsec)


def test_missing_readings_are_never_the_ends_of_a_series():
    for seed in range(20):
        readings = run(polygon(8), seed=seed, rounds=2, backward=True, missing=9)
        assert readings.face.size == 4 * 9 - 9
        for number, direction in ((1, 1), (1, -1), (2, 1), (2, -1)):
            rows = (readings.round == number) & (readings.direction == direction)
            assert readings.face[rows][0] == readings.face[rows][-1] == 0


def test_aliasing_shows_an_error_within_the_line_as_a_slow_one():
    """4096 mod 24 = 16: at 24 faces order 4096 looks like order 8 (SCIENCE, RE)."""
    within_line = KnownEncoder((Harmonic.within_line(1, 1.0, 35.0),))
    readings = run(polygon(24), encoder=within_line, setting_scatter_arcsec=0.0)
    spectrum = np.abs(np.fft.rfft(reduced_arcsec(readings, 24)[:24])) / 12
    assert spectrum[8] == pytest.approx(1.0, abs=0.1)
    assert np.delete(spectrum, [0, 8]).max() < 0.1


def test_a_closure_run_is_the_sum_of_faces_mountings_and_encoder():
    artefact, settings = polygon(12), (1, 2, 5, 12)
    conditions = ClosureConditions(settings, 30.0, start_deg=3.0)
    readings = simulate_closure(ENCODER, artefact, Autocollimator(), conditions, np.random.default_rng(2))
    nominal_deg = 3.0 + (readings.face - 1) * 30.0 + (readings.setting - 1) * 30.0
    assert np.abs(readings.position_deg - nominal_deg).max() * 3600 < 10
    seen = (readings.position_deg - nominal_deg) * 3600 + readings.autocollimator_x_arcsec
    left = seen - ENCODER.error_arcsec(readings.true_deg) - artefact.deviation_arcsec[readings.face - 1]
    for setting in settings:
        mounting = left[readings.setting == setting]
        assert np.ptp(mounting) < ROUNDING_ARCSEC
        assert abs(mounting.mean()) < 150


def test_further_rounds_are_mounted_and_set_anew():
    conditions = ClosureConditions((1, 2, 5), 30.0, rounds=2)
    readings = simulate_closure(ENCODER, polygon(12), Autocollimator(), conditions, np.random.default_rng(2))
    assert readings.round.tolist() == [1] * 36 + [2] * 36
    assert np.array_equal(readings.setting[:36], readings.setting[36:])
    assert "round" in readings.columns()
    first, second = (readings.autocollimator_x_arcsec[rows].mean() for rows in (slice(0, 12), slice(36, 48)))
    assert abs(first - second) > 3
    arc = simulate_theodolite(ENCODER, TheodoliteConditions(rounds=2), np.random.default_rng(2))
    assert arc.round.tolist() == [1] * 41 + [2] * 41
    apart = (arc.azimuth_deg[41:] - arc.azimuth_deg[:41] - (arc.true_deg[41:] - arc.true_deg[:41])) * 3600
    assert np.ptp(apart) < 0.01
    assert abs(apart.mean()) > 3


def test_a_closure_run_loses_the_readings_asked_for():
    conditions = ClosureConditions((1, 2, 3), 30.0, missing=7)
    readings = simulate_closure(ENCODER, polygon(12), Autocollimator(), conditions, np.random.default_rng(2))
    assert readings.face.size == 36 - 7


def test_the_published_mirror_gives_the_published_curve():
    """SCIENCE, TH: theta - A at 5 .. 40 deg, in the printed equations' sense of delta."""
    azimuth_deg, elevation_deg = mirror_direction(np.arange(0, 41, 5), 6.7348, 129.3174, -1.6617)
    expected = [0, 115.2, 226.0, 330.9, 428.6, 518.4, 599.8, 672.9, 738.08]
    assert (np.arange(0, 41, 5) - azimuth_deg) * 3600 == pytest.approx(expected, abs=0.06)
    assert elevation_deg[0] == pytest.approx(-1.6617)


def test_the_mirror_follows_the_printed_equations(random):
    """Equations (1) to (5) of Wang Tao et al. 2018, written out."""
    t = np.radians(random.uniform(-170, 170, 100))
    a, d, w = np.radians([5.0, 200.0, 3.0])
    x = np.cos(a) * np.sin(t) - np.sin(a) ** 2 * np.sin(d) * np.cos(d) * (1 - np.cos(t))
    y = np.cos(t) + np.sin(a) ** 2 * np.cos(d) ** 2 * (1 - np.cos(t))
    z = np.sin(a) * np.sin(d) * np.sin(t) + np.sin(a) * np.cos(a) * np.cos(d) * (1 - np.cos(t))
    y, z = y * np.cos(w) - z * np.sin(w), y * np.sin(w) + z * np.cos(w)
    azimuth_deg, elevation_deg = mirror_direction(np.degrees(t), 5.0, 200.0, 3.0)
    assert azimuth_deg == pytest.approx(np.degrees(np.arctan2(x, y)), abs=1e-9)
    assert elevation_deg == pytest.approx(np.degrees(np.arcsin(z)), abs=1e-9)


def test_an_upright_axis_shows_the_theodolite_the_shaft_itself():
    conditions = TheodoliteConditions(first_deg=-20.0, last_deg=20.0, azimuth_zero_deg=7.0, start_deg=30.0)
    readings = simulate_theodolite(ENCODER, conditions, np.random.default_rng(1))
    assert readings.count.size == 41
    error = (readings.reading_deg - 30.0 - (readings.azimuth_deg - 7.0)) * 3600
    at_start = ENCODER.error_arcsec(ENCODER.true_deg(30.0))
    assert error == pytest.approx(ENCODER.error_arcsec(readings.true_deg) - at_start, abs=ROUNDING_ARCSEC)
    assert readings.zenith_deg == pytest.approx(90.0)


@pytest.mark.parametrize("name", MISTAKES)
@pytest.mark.parametrize("faces", FACES)
def test_every_mistake_changes_the_run_and_leaves_its_shape(name, faces):
    good = run(polygon(faces), rounds=2, backward=True)
    bad, sentence = MISTAKES[name](good, faces, np.random.default_rng(4))
    assert sentence
    assert good.face.size - bad.face.size == (name == "skip")
    assert {values.shape for values in vars(bad).values()} == {bad.face.shape}
    same = [np.array_equal(values, getattr(good, column)) for column, values in vars(bad).items()]
    assert not all(same)


def test_a_jump_leaves_face_and_shaft_a_step_apart():
    good = run(polygon(24), rounds=2)
    bad, _ = MISTAKES["jump"](good, 24, np.random.default_rng(4))
    apart = np.rint((bad.position_deg - good.position_deg) / 15.0)
    first = int(np.argmax(apart))
    assert apart[:first].tolist() == [0] * first
    assert apart[first:25].tolist() == [1] * (25 - first)
    assert not apart[25:].any()
    assert np.abs(bad.autocollimator_x_arcsec).max() < 30, "the shaft still stands at some face"


def test_clockwise_reads_the_same_angles_in_the_other_order():
    good = run(polygon(24), rounds=1)
    bad, _ = MISTAKES["clockwise"](good, 24, np.random.default_rng(4))
    assert np.diff(bad.position_deg) == pytest.approx(-15.0, abs=0.01)
    assert bad.position_deg[0] == pytest.approx(0.0, abs=0.01)
    assert np.array_equal(bad.face_deviation_arcsec, good.face_deviation_arcsec), "the list is copied as it stands"
