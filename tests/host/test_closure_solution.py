"""Closure calibration of simulated encoders and polygons whose truth is known."""

import numpy as np
import pytest
from scipy.stats import f as fisher

from arcref.calibration.closure_design import SettingsDesign
from arcref.calibration.closure_solution import solve_closure

RUNS = 1000


def simulated(settings, step_deg=15.0, noise_arcsec=0.1, runs=RUNS, faces=24, seed=4):
    """Design, readings float64[runs, n], true encoder errors and face deviations (mean zero)."""
    setting, face = np.meshgrid(settings, np.arange(faces), indexing="ij")
    design = SettingsDesign.of(faces, step_deg, setting.ravel(), face.ravel())
    random = np.random.default_rng(seed)
    encoder = random.normal(0, 2.0, len(design.position_deg))
    deviation = random.normal(0, 1.5, faces)
    encoder, deviation = encoder - encoder.mean(), deviation - deviation.mean()
    mounting = random.uniform(-120, 120, (runs, design.series_count))
    truth = encoder[design.position] + deviation[design.face] + mounting[:, design.series]
    return design, truth + noise_arcsec * random.standard_normal(truth.shape), encoder, deviation


def inside_95_percent(difference_arcsec, covariance, sigma_arcsec, freedom) -> np.ndarray:
    """bool[runs]: which runs have their whole curve inside the 95 % region that its covariance states (Hotelling)."""
    value, vector = np.linalg.eigh(covariance)
    kept = value > 1e-9 * value[-1]
    square = np.sum((difference_arcsec @ vector[:, kept]) ** 2 / value[kept], axis=1) / sigma_arcsec**2
    return square / kept.sum() < fisher.ppf(0.95, kept.sum(), freedom)


def test_24_faces_at_24_positions_encoder_and_faces_within_their_uncertainty_in_95_percent_of_1000_runs():
    design, reading, encoder, deviation = simulated(range(1, 25))
    solution = solve_closure(design, reading)
    assert solution.sigma_arcsec.shape == (RUNS,)
    assert solution.sigma_arcsec.mean() == pytest.approx(0.1, rel=0.01)
    u_encoder, u_face = solution.standard_uncertainty_arcsec()
    covariance = design.covariance
    for found, true, u, part in (
        (solution.encoder_error_arcsec, encoder, u_encoder, covariance[:24, :24]),
        (solution.face_deviation_arcsec, deviation, u_face, covariance[24:, 24:]),
    ):
        difference = found - true
        each = np.mean(np.abs(difference) < 1.96 * u)
        assert 0.94 < each < 0.96  # point by point
        whole = inside_95_percent(difference, part, solution.sigma_arcsec, design.degrees_of_freedom).mean()
        assert 0.90 <= whole <= 0.98  # the curve as one
        assert u.mean() == pytest.approx(0.0200, rel=0.01)
        np.testing.assert_allclose(difference.std(), u.mean(), rtol=0.02)


def test_the_covariance_between_encoder_and_faces_is_kept():
    design, reading, encoder, deviation = simulated(range(1, 6), runs=4000)
    solution = solve_closure(design, reading)
    both = np.hstack([solution.encoder_error_arcsec - encoder, solution.face_deviation_arcsec - deviation])
    stated = solution.covariance_arcsec2().mean(axis=0)
    scatter = both.T @ both / len(both)
    assert np.abs(scatter - stated).max() < 0.08 * stated.max()
    assert np.abs(stated[:24, 24:]).max() > 0.1 * stated.max()  # a partial set ties them


def test_a_partial_set_of_5_positions_is_right_about_what_it_kept_and_leaves_out_what_it_lost():
    design, reading, encoder, deviation = simulated(range(1, 6), step_deg=60.0)
    assert design.lost_orders == (6, 12)
    solution = solve_closure(design, reading)
    lost = np.hstack([design.basis(6), design.basis(12)])
    assert np.abs(solution.encoder_error_arcsec @ lost).max() < 1e-9
    kept = encoder - lost @ (lost.T @ encoder)
    u, _ = solution.standard_uncertainty_arcsec()
    within = np.abs(solution.encoder_error_arcsec - kept) < 1.96 * u
    assert 0.94 < within.mean() < 0.96
    # The encoder's true error is what was found, and what the faces took of it.
    given_to_faces = design.lost_from_faces @ (solution.face_deviation_arcsec - deviation).T
    rest = solution.encoder_error_arcsec + given_to_faces.T - encoder
    assert np.abs(rest.mean(axis=0)).max() < 0.02


def test_two_adjacent_settings_separate_every_order_but_say_how_badly():
    design, reading, encoder, _ = simulated([1, 2])
    assert design.lost_orders == ()
    assert design.noise_factor[0] == pytest.approx(7.66, abs=0.01)
    assert design.degrees_of_freedom == 0
    solution = solve_closure(design, reading)
    assert np.isnan(solution.sigma_arcsec).all()
    u, _ = solution.standard_uncertainty_arcsec(np.full(RUNS, 0.1))
    assert np.mean(np.abs(solution.encoder_error_arcsec - encoder) < 1.96 * u) == pytest.approx(0.95, abs=0.02)


def test_an_honest_run_names_an_outlier_as_seldom_as_it_states():
    design, reading, *_ = simulated(range(1, 25))
    solution = solve_closure(design, reading)
    alarms = (np.abs(solution.studentized_residual).max(axis=1) > solution.outlier_limit).mean()
    assert alarms <= 0.005


@pytest.mark.parametrize("seed", range(5))
def test_an_outlier_is_named_and_no_other_reading(seed):
    design, reading, *_ = simulated(range(1, 25), runs=1, seed=seed)
    wrong = int(np.random.default_rng(seed).integers(design.readings))
    reading[0, wrong] += 1.0
    solution = solve_closure(design, reading[0])
    studentized = np.abs(solution.studentized_residual)
    assert list(np.flatnonzero(studentized > solution.outlier_limit)) == [wrong]


def test_readings_without_noise_have_no_outliers():
    design, reading, *_ = simulated(range(1, 25), noise_arcsec=0.0, runs=1)
    solution = solve_closure(design, reading)
    assert np.abs(solution.studentized_residual).max() < solution.outlier_limit
    assert solution.sigma_arcsec[0] < 1e-9
