"""The uncertainty budget of a polygon run against numbers worked by hand, and what it names as missing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from made_calibration_result import reduced
from made_polygon_run import STATED

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.correction_budget import interpolation_u_arcsec, line_phasor_of
from arcref.calibration.fit_transfer import FitTransfer
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.metadata_keys import KEYS_BY_NAME, METADATA_KEYS
from arcref.calibration.polygon_budget import TILT_LIMIT_FACTOR, face_contributions, face_u_arcsec, polygon_budget
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.polygon_reduction import reduce_polygon
from arcref.calibration.polygon_run import read_polygon_run
from arcref.calibration.stated_values import stated_number
from arcref.calibration.tower_tilt import horizontal_reading_arcsec
from arcref.calibration.uncertainty_budget import Contribution, UncertaintyBudget
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError


def terms(contributions) -> dict:
    return {term.name: term for term in contributions}


def at_faces(inputs) -> dict:
    return terms(face_contributions(inputs, FitTransfer.to_faces(inputs.faces))[0])


def budget_of(reduction, inputs, fit="fourier", **parameters):
    curve = ErrorCurve(reduction.angle_deg, reduction.error_arcsec, face_u_arcsec(inputs))
    return polygon_budget(inputs, fit_curve(curve, fit, **parameters))


def test_combined_expanded_and_degrees_of_freedom_as_worked_by_hand():
    # 3, 4 and 12 combine to 13; of them 4 has 16 degrees of freedom and 12 has 144.
    budget = UncertaintyBudget(
        (
            Contribution("a", "B", "normal", 1.5, "arcsec", -2.0, ""),
            Contribution("b", "A", "normal", 8.0, "arcmin", 0.5, "", 16),
            Contribution("c", "A", "normal", 12.0, "arcsec", 1.0, "", 144),
        )
    )
    assert budget.combined_arcsec == pytest.approx(13)
    assert budget.expanded_arcsec == pytest.approx(26)
    assert budget.effective_degrees_of_freedom == pytest.approx(13**4 / (4**4 / 16 + 12**4 / 144))  # 178.3


def test_coverage_factor_is_that_of_the_gum_table():
    # GUM table G.2, column 95.45 %: 2.28 for 10 degrees of freedom, 2.13 for 20, 2.00 for infinitely many.
    for freedom, factor in ((10, 2.28), (20, 2.13), (50, 2.05), (math.inf, 2.00)):
        budget = UncertaintyBudget((Contribution("a", "A", "normal", 1.0, "arcsec", 1.0, "", freedom),))
        assert budget.coverage_factor_95 == pytest.approx(factor, abs=0.005)


def test_independent_errors_at_the_faces_lose_only_their_mean():
    for faces in (7, 8, 24, 72):
        assert FitTransfer.to_faces(faces).of_independent == pytest.approx(math.sqrt(1 - 1 / faces))


def test_order_one_at_the_faces_has_its_rms_and_a_constant_has_none():
    theta = np.radians(np.arange(24) * 15.0)
    transfer = FitTransfer.to_faces(24)
    assert transfer.of_shape(3 * np.cos(theta)) == pytest.approx(3 / math.sqrt(2))
    assert transfer.of_shape(np.full(24, 5.0)) == pytest.approx(0, abs=1e-12)
    assert transfer.of_offset(np.full(24, 5.0)) == pytest.approx(5)


def test_a_trigonometric_fit_passes_noise_as_its_number_of_coefficients(tmp_path):
    # Least squares of order m through n faces: mean variance (2 m + 1) / n, less 1 / n for the mean.
    reduction, inputs = reduced(tmp_path / "run.csv", rounds=2)
    curve = ErrorCurve(reduction.angle_deg, reduction.error_arcsec)
    for order in (2, 5, 8):
        transfer = FitTransfer.over_turn(fit_curve(curve, "fourier", order=order))
        assert transfer.of_independent == pytest.approx(math.sqrt(2 * order / 24), rel=1e-6)


def test_certificate_autocollimator_and_repeatability_as_worked_by_hand(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", faces=24, rounds=4, metadata=STATED)
    found = at_faces(inputs)
    lost = math.sqrt(23 / 24)
    assert found["face certificate"].u_arcsec == pytest.approx(0.10 * lost)
    assert found["autocollimator"].u_arcsec == pytest.approx(0.08 * lost)
    repeatability = found["repeatability"]
    assert repeatability.type == "A"
    assert repeatability.degrees_of_freedom == 3 * 23
    assert repeatability.u == pytest.approx(0.2, rel=0.2)
    assert repeatability.u_arcsec == pytest.approx(repeatability.u * lost / math.sqrt(4))


def test_directions_count_alike_whatever_their_number(tmp_path):
    # Three rounds forward and one backward: weights 1/6, 1/6, 1/6, 1/2.
    path = tmp_path / "run.csv"
    reduced(path, rounds=3, directions=(1, -1))
    lines = [line for line in path.read_text().splitlines() if line[:4] not in ("2,-1", "3,-1")]
    path.write_text("\n".join(lines))
    inputs = PolygonInputs.of(reduce_polygon(read_polygon_run(path)))
    assert inputs.averaging == pytest.approx(math.sqrt(3 / 36 + 1 / 4))


def test_expanded_certificates_are_halved_and_may_not_stand_twice(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", metadata=(("expanded_face_certificate_arcsec", 0.3),))
    assert inputs.u_face_certificate_arcsec == pytest.approx(0.15)
    both = (("expanded_face_certificate_arcsec", 0.3), ("u_face_certificate_arcsec", 0.1))
    with pytest.raises(InputError, match="metadata expanded_face_certificate_arcsec: u_face_certificate_arcsec stands"):
        reduced(tmp_path / "run.csv", metadata=both)


@pytest.mark.parametrize("value", ["abc", "nan", "-0.1", "inf"])
def test_a_stated_uncertainty_that_is_none_is_refused_with_its_row(tmp_path, value):
    with pytest.raises(InputError, match="row 2.*u_autocollimator_arcsec"):
        reduced(tmp_path / "run.csv", metadata=(("u_autocollimator_arcsec", value),))


def test_what_nobody_stated_is_named_with_the_key_that_would_state_it(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", rounds=1)
    missing = {each.metadata_key for each in budget_of(reduction, inputs).missing}
    assert missing == {
        "u_face_certificate_arcsec",
        "u_autocollimator_arcsec",
        "u_repeatability_arcsec",
        "tilt_limit_arcsec",
        "u_autocollimator_roll_arcmin",
        "u_eccentric_mounting_arcsec",
        "u_interpolation_arcsec",
    }
    assert missing <= set(KEYS_BY_NAME)


def test_a_budget_with_everything_stated_misses_nothing(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", psi_arcsec=300.0, metadata=STATED)
    assert budget_of(reduction, inputs).missing == ()


def test_without_certificate_the_missing_uncertainty_is_that_of_the_faces_themselves(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", certificate=False)
    assert "taken as nil" in budget_of(reduction, inputs).missing[0].name


def test_one_round_takes_the_stated_repeatability_as_type_b(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", rounds=1, metadata=(("u_repeatability_arcsec", 0.3),))
    term = at_faces(inputs)["repeatability"]
    assert (term.type, term.u, term.degrees_of_freedom) == ("B", 0.3, math.inf)


def test_roll_acts_through_the_tilt_as_the_tower_paper_has_it(tmp_path):
    # Roll of 1' at psi = 300 arcsec: 300 / 3438 = 0.087 arcsec peak, 0.0617 rms.
    _, inputs = reduced(
        tmp_path / "run.csv", psi_arcsec=300.0, y_noise_arcsec=0.0, metadata=(("u_autocollimator_roll_arcmin", 1),)
    )
    assert at_faces(inputs)["roll of the autocollimator"].u_arcsec == pytest.approx(0.0617, rel=0.01)


def test_corrected_tilt_leaves_next_to_nothing_and_uncorrected_tilt_its_whole_error(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", psi_arcsec=300.0, omega_deg=90.0)
    found = at_faces(inputs)
    assert found["tower tilt, its size"].u_arcsec < 1e-3
    assert found["tower tilt, its azimuth"].u_arcsec < 1e-3
    left = at_faces(replace(inputs, tilt_corrected=False))["tower tilt"]
    x = horizontal_reading_arcsec(inputs.theta_deg, 300.0, 90.0)
    assert left.u_arcsec == pytest.approx(np.std(x), rel=0.01)


def test_tilt_limit_is_the_rms_over_tilts_below_it_and_all_azimuths(tmp_path):
    random = np.random.default_rng(3)
    theta = np.arange(24) * 15.0
    psi, omega = random.uniform(0, 400.0, (4000, 1)), random.uniform(-180, 180, (4000, 1))
    x = horizontal_reading_arcsec(theta, psi, omega)
    drawn = np.sqrt(np.mean((x - x.mean(axis=1, keepdims=True)) ** 2))
    _, inputs = reduced(tmp_path / "run.csv", metadata=(("tilt_limit_arcsec", 400),))
    assert at_faces(inputs)["tower tilt"].u_arcsec == pytest.approx(TILT_LIMIT_FACTOR * 400**2)
    assert at_faces(inputs)["tower tilt"].u_arcsec == pytest.approx(drawn, rel=0.05)


def test_eccentric_mounting_is_flatness_times_how_far_the_beam_wanders(tmp_path):
    stated = (("eccentricity_mm", 0.2), ("u_face_flatness_arcsec_per_mm", 0.5))
    _, inputs = reduced(tmp_path / "run.csv", metadata=stated)
    assert at_faces(inputs)["eccentric mounting"].u_arcsec == pytest.approx(0.1 / math.sqrt(2) * math.sqrt(23 / 24))


def test_half_of_what_describes_a_contribution_names_the_other_half_as_missing(tmp_path):
    halves = (("eccentricity_mm", 0.2), ("temperature_change_k", 0.5))
    _, inputs = reduced(tmp_path / "run.csv", metadata=halves)
    missing = face_contributions(inputs, FitTransfer.to_faces(24))[1]
    keys = {each.metadata_key for each in missing}
    assert {"u_face_flatness_arcsec_per_mm", "u_temperature_coefficient_arcsec_per_k"} <= keys


def test_temperature_is_its_change_over_root_twelve_times_the_coefficient(tmp_path):
    stated = (("temperature_change_k", 0.6), ("u_temperature_coefficient_arcsec_per_k", 0.5))
    _, inputs = reduced(tmp_path / "run.csv", metadata=stated)
    assert at_faces(inputs)["temperature"].u_arcsec == pytest.approx(0.3 / math.sqrt(12) * math.sqrt(23 / 24))


def test_drift_within_rounds_is_found_beyond_the_scatter(tmp_path):
    # A ramp of 2 arcsec over each round: rms about its mean 2 / sqrt(12).
    _, inputs = reduced(tmp_path / "run.csv", drift_arcsec=2.0, noise_arcsec=0.02)
    assert at_faces(inputs)["drift within a round"].u_arcsec == pytest.approx(2 / math.sqrt(12), rel=0.02)
    quiet = [at_faces(reduced(tmp_path / "run.csv", seed=seed)[1]) for seed in range(30)]
    assert np.median([found["drift within a round"].u_arcsec for found in quiet]) < 0.02


def test_drift_of_rounds_in_both_directions_cancels(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", drift_arcsec=2.0, noise_arcsec=0.02, directions=(1, -1))
    assert at_faces(inputs)["drift within a round"].u_arcsec < 0.25


def test_return_error_counts_with_half_of_itself(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", directions=(1, -1), rounds=3, noise_arcsec=0.02, return_arcsec=1.0)
    assert at_faces(inputs)["return error"].u_arcsec == pytest.approx(0.5, rel=0.05)


def test_rounding_resolution_and_slope_as_worked_by_hand(tmp_path):
    reduction, inputs = reduced(tmp_path / "run.csv", noise_arcsec=0.0, harmonics=((1, 10.0),), metadata=STATED)
    found = terms(budget_of(reduction, inputs, order=4).contributions)
    assert found["rounding of the ROM"].u_arcsec == pytest.approx(ARCSEC_PER_COUNT / math.sqrt(12))  # 0.0446
    assert found["resolution of the reading"].u_arcsec == pytest.approx(0.044599, rel=1e-4)
    # Slope of 10 sin: 10 / sqrt(2) arcsec a radian rms; a line is 360 / 4096 deg wide.
    slope = 10 / math.sqrt(2) * math.pi / 180
    assert found["one ROM entry a grating line"].u_arcsec == pytest.approx(slope * 360 / 4096 / math.sqrt(12), rel=1e-3)


def test_error_within_a_line_counts_twice_where_the_faces_burn_it_in_and_once_where_they_do_not(tmp_path):
    # 4096 mod 24 = 16: at 24 faces it is order 8, which the fit passes. 4096 mod 8 = 0: at 8 faces it is a constant.
    for faces, order, factor in ((24, 11, math.sqrt(2)), (8, 3, 1.0), (24, 4, 1.0)):
        reduction, inputs = reduced(tmp_path / "run.csv", faces=faces, metadata=STATED)
        found = terms(budget_of(reduction, inputs, order=order).contributions)
        assert found["interpolation, not seen by the faces"].sensitivity == pytest.approx(factor, abs=0.01)


def test_faces_read_at_many_phases_within_the_line_do_not_burn_it_in():
    random = np.random.default_rng(2)
    position = np.arange(24) * 15.0 + random.uniform(0, 1, (400, 24))
    assert np.abs(line_phasor_of(position).mean(axis=0)).max() < 0.2


def test_an_amplitude_within_the_line_is_that_of_a_sine(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", metadata=(("interpolation_amplitude_arcsec", 0.2),))
    assert interpolation_u_arcsec(inputs.run) == pytest.approx(0.2 / math.sqrt(2))


def test_the_curve_is_as_uncertain_at_its_first_face_as_at_any_other(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", metadata=STATED)
    u = face_u_arcsec(inputs)
    assert u.shape == (24,)
    assert np.ptp(u) == 0
    assert u[0] == pytest.approx(math.hypot(*(term.u_arcsec for term in at_faces(inputs).values())))


def test_every_key_stands_once_and_every_number_has_its_unit_in_its_name():
    assert len(KEYS_BY_NAME) == len(METADATA_KEYS)
    unit_ends = {"arcsec": "_arcsec", "arcmin": "_arcmin", "deg": "_deg", "mm": "_mm", "deg C": "_c", "K": "_k"}
    for key in METADATA_KEYS:
        if key.unit in unit_ends:
            assert key.name.endswith(unit_ends[key.unit])


def test_a_number_not_stated_is_none(tmp_path):
    _, inputs = reduced(tmp_path / "run.csv", metadata=(("u_temperature_arcsec", ""),))
    assert stated_number(inputs.run, "u_temperature_arcsec") is None
