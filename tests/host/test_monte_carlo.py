"""The Monte Carlo of the whole reduction against the budget, which shares none of its arithmetic."""

import numpy as np
import pytest
from made_calibration_result import reduced
from made_polygon_run import STATED

from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.monte_carlo import FEWEST_RUNS, monte_carlo
from arcref.calibration.polygon_budget import face_u_arcsec, polygon_budget
from arcref.error_curve import ErrorCurve

CONFIGURATIONS = {
    "24 faces, 4 rounds, tilt": {"psi_arcsec": 300.0, "metadata": STATED},
    "both directions, drift and return error": {
        "psi_arcsec": 300.0,
        "directions": (1, -1),
        "return_arcsec": 0.3,
        "drift_arcsec": 0.5,
        "metadata": STATED,
    },
    "8 faces, tilt below a limit": {"faces": 8, "rounds": 2, "metadata": (*STATED, ("tilt_limit_arcsec", 200))},
    "36 faces, one round": {"faces": 36, "rounds": 1, "metadata": (*STATED, ("u_repeatability_arcsec", 0.2))},
    "72 faces, large tilt and roll": {
        "faces": 72,
        "rounds": 2,
        "psi_arcsec": 1369.0,
        "noise_arcsec": 0.05,
        "metadata": (("u_autocollimator_roll_arcmin", 2),),
    },
    "7 faces, little stated": {"faces": 7, "rounds": 2},
    "17 faces, error within the line alone": {
        "faces": 17,
        "noise_arcsec": 0.01,
        "metadata": (("u_interpolation_arcsec", 0.3),),
    },
    "12 faces, flatness and temperature": {
        "faces": 12,
        "metadata": (
            ("eccentricity_mm", 0.5),
            ("u_face_flatness_arcsec_per_mm", 0.6),
            ("temperature_change_k", 1),
            ("u_temperature_coefficient_arcsec_per_k", 0.5),
        ),
    },
    "no certificate": {"certificate": False, "metadata": STATED},
}


def calibrated(path, fit="rbf", **made):
    reduction, inputs = reduced(path, **made)
    fitted = fit_curve(ErrorCurve(reduction.angle_deg, reduction.error_arcsec, face_u_arcsec(inputs)), fit)
    return reduction, fitted, polygon_budget(inputs, fitted)


@pytest.mark.parametrize("name", CONFIGURATIONS)
def test_monte_carlo_agrees_with_the_budget_within_five_percent(tmp_path, name):
    reduction, fitted, budget = calibrated(tmp_path / "run.csv", **CONFIGURATIONS[name])
    found = monte_carlo(reduction, fitted, budget.combined_arcsec, 1000)
    assert abs(found.from_budget) < 0.05, f"{found.u_arcsec} arcsec, the budget says {budget.combined_arcsec}"
    assert found.agrees
    assert found.interval_95_arcsec == pytest.approx(2 * found.u_arcsec, rel=0.12)


@pytest.mark.parametrize("fit", ["rbf", "fourier", "spline", "gaussian-process"])
def test_monte_carlo_agrees_with_the_budget_for_every_fit(tmp_path, fit):
    reduction, fitted, budget = calibrated(tmp_path / "run.csv", fit, metadata=STATED, seed=8)
    assert abs(monte_carlo(reduction, fitted, budget.combined_arcsec, 1000).from_budget) < 0.05


def test_each_input_alone_is_drawn_and_agrees(tmp_path):
    """Nearly no scatter, and one input large: what is not drawn, or is drawn wrongly, cannot hide behind the others."""
    for key, value in (
        ("u_face_certificate_arcsec", 1.0),
        ("u_autocollimator_arcsec", 1.0),
        ("u_eccentric_mounting_arcsec", 1.0),
        ("u_temperature_arcsec", 1.0),
        ("u_interpolation_arcsec", 1.0),
        ("u_autocollimator_roll_arcmin", 10.0),
        ("tilt_limit_arcsec", 1000.0),
    ):
        psi_arcsec = None if key.startswith("tilt") else 300.0
        made = {
            "rounds": 2,
            "noise_arcsec": 0.01,
            "psi_arcsec": psi_arcsec,
            "y_noise_arcsec": 0.01,
            "metadata": ((key, value),),
        }
        reduction, fitted, budget = calibrated(tmp_path / "run.csv", **made)
        found = monte_carlo(reduction, fitted, budget.combined_arcsec, 2000, seed=4)
        assert budget.combined_arcsec > 0.3, key
        assert abs(found.from_budget) < 0.07, f"{key}: {found.from_budget:+.1%}"


def test_a_budget_that_is_wrong_is_noticed(tmp_path):
    reduction, fitted, budget = calibrated(tmp_path / "run.csv", metadata=STATED)
    assert not monte_carlo(reduction, fitted, 1.15 * budget.combined_arcsec, 300).agrees


def test_scatter_is_how_the_result_changes_from_seed_to_seed(tmp_path):
    made = {"psi_arcsec": 300.0, "noise_arcsec": 0.02, "metadata": (("u_autocollimator_roll_arcmin", 3),)}
    reduction, fitted, budget = calibrated(tmp_path / "run.csv", **made)
    found = [monte_carlo(reduction, fitted, budget.combined_arcsec, 200, seed) for seed in range(40)]
    from_seed_to_seed = np.std([each.u_arcsec for each in found]) / budget.combined_arcsec
    assert np.mean([each.scatter for each in found]) == pytest.approx(from_seed_to_seed, rel=0.35)
    assert sum(each.agrees for each in found) >= 38


def test_the_same_seed_gives_the_same_numbers_and_another_seed_others(tmp_path):
    reduction, fitted, budget = calibrated(tmp_path / "run.csv", metadata=STATED)
    runs = [monte_carlo(reduction, fitted, budget.combined_arcsec, 250, seed) for seed in (5, 5, 6)]
    assert runs[0].figures() == runs[1].figures()
    assert runs[0].u_arcsec != runs[2].u_arcsec


def test_too_few_runs_are_refused(tmp_path):
    reduction, fitted, budget = calibrated(tmp_path / "run.csv")
    with pytest.raises(ValueError, match="at least 100"):
        monte_carlo(reduction, fitted, budget.combined_arcsec, FEWEST_RUNS - 1)
