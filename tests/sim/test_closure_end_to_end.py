"""Simulated closure runs against their truth: encoder and faces within what is stated, in as many runs as stated."""

import numpy as np
import pytest

from arcref.calibration.closure_design import SettingsDesign
from arcref.calibration.closure_solution import solve_closure
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.simulated_closure import ClosureConditions, simulate_closure
from arcref_sim.metrology.simulated_polygon import Autocollimator

RUNS = 1000
ENCODER = KnownEncoder((Harmonic(1, 1.2, 15.0), Harmonic(2, 0.8, 70.0), Harmonic(5, 0.6, 0.0), Harmonic(8, 0.4, 40.0)))


def solved(faces, settings, step_deg, runs, **conditions):
    """Encoder errors and face deviations of many runs with their k=2 uncertainties, and the truth: each (p, f)."""
    artefact = PolygonArtefact.random(np.random.default_rng(faces), faces, deviation_arcsec=2.0)
    how, seen = ClosureConditions(tuple(settings), step_deg, **conditions), []
    for seed in range(runs):
        run = simulate_closure(ENCODER, artefact, Autocollimator(0.1), how, np.random.default_rng([seed, 3]))
        nominal_deg = (run.face - 1) * (360.0 / faces) + (run.setting - 1) * step_deg
        seen.append(3600.0 * (run.position_deg - nominal_deg) + run.autocollimator_x_arcsec)
    design = SettingsDesign.of(faces, step_deg, run.setting, run.face - 1)
    solution = solve_closure(design, np.array(seen))
    true_error = ENCODER.error_arcsec(design.position_deg)
    truth = true_error - true_error.mean(), artefact.deviation_arcsec - artefact.deviation_arcsec.mean()
    u = solution.standard_uncertainty_arcsec()
    return (solution.encoder_error_arcsec, solution.face_deviation_arcsec), u, truth, solution


@pytest.fixture(scope="module")
def full_set():
    return solved(24, range(1, 25), 15.0, RUNS)


@pytest.mark.parametrize("what", [0, 1], ids=["encoder", "faces"])
def test_a_full_set_covers_the_truth_as_often_as_stated(what, full_set):
    found, u, truth, _ = full_set
    inside = np.abs(found[what] - truth[what]) <= 2 * u[what]
    assert inside.shape == (RUNS, 24)
    assert 0.945 < inside.mean() < 0.965
    at_each = inside.mean(axis=0)
    assert at_each.min() > 0.90
    assert at_each.max() < 0.98


def test_what_is_stated_of_a_full_set_is_what_theory_says(full_set):
    """Noise 0.1 arcsec, 24 readings of each unknown: 0.1 sqrt(23) / 24 about the mean; a count's rounding adds."""
    found, (u_encoder, u_faces), truth, solution = full_set
    one_reading = np.hypot(0.1, 0.1545 / np.sqrt(12))
    assert np.mean(solution.sigma_arcsec) == pytest.approx(one_reading, rel=0.01)
    for u in (u_encoder, u_faces):
        assert np.mean(u) == pytest.approx(one_reading * np.sqrt(23) / 24, rel=0.01)
    scatter = np.sqrt(np.mean((found[0] - truth[0]) ** 2))
    assert scatter == pytest.approx(np.mean(u_encoder), rel=0.03)


def test_missing_readings_cost_certainty_and_not_truth():
    """The same readings are lost in every run, so that one design serves all."""
    artefact = PolygonArtefact.random(np.random.default_rng(12), 12, deviation_arcsec=2.0)
    kept = np.setdiff1d(np.arange(144), np.random.default_rng(5).choice(144, 40, replace=False))
    seen = []
    for seed in range(300):
        how = ClosureConditions(tuple(range(1, 13)), 30.0)
        run = simulate_closure(ENCODER, artefact, Autocollimator(0.1), how, np.random.default_rng([seed, 4]))
        nominal_deg = (run.face - 1) * 30.0 + (run.setting - 1) * 30.0
        seen.append((3600.0 * (run.position_deg - nominal_deg) + run.autocollimator_x_arcsec)[kept])
    design = SettingsDesign.of(12, 30.0, run.setting[kept], run.face[kept] - 1)
    solution = solve_closure(design, np.array(seen))
    u_encoder, _ = solution.standard_uncertainty_arcsec()
    true_error = ENCODER.error_arcsec(design.position_deg)
    inside = np.abs(solution.encoder_error_arcsec - true_error + true_error.mean()) <= 2 * u_encoder
    assert 0.93 < inside.mean() < 0.975
    assert np.mean(u_encoder) > 0.11 * np.sqrt(11) / 12, "more than a whole set states"


def test_five_settings_a_quarter_apart_lose_the_orders_that_repeat_in_a_quarter():
    """Settings at multiples of 90 deg: orders 4, 8, 12 of encoder and polygon look alike, the others do not."""
    (found, _), _, (truth, _), _ = solved(24, range(1, 6), 90.0, 20)
    left = np.abs(np.fft.rfft(found - truth)) / 12
    lost = np.isin(np.arange(13), [4, 8, 12])
    assert left[:, ~lost].max() < 0.2
    assert left[:, 8].min() > 0.2, "order 8, of 0.4 arcsec, is not found"
