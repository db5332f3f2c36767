"""The figures of Wang Tao et al., Acta Optica Sinica 38(5) 2018 0512001, computed from their equations.

Where the print does not follow from the equations, the right figure is asserted and the printed one named.
"""

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import least_squares as trust_region

from arcref.calibration.theodolite_identification import (
    angles_by_parameters,
    closed_form,
    least_squares,
    parameter_covariance,
)
from arcref.calibration.theodolite_model import MirrorGeometry
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcReadings, solve_arc

DATA = Path(__file__).parents[1] / "data"

ARC = np.radians(np.arange(0.0, 41.0))


@pytest.fixture(scope="module")
def published() -> MirrorGeometry:
    """Section 4 of the paper: the parameters that were identified over 0 .. 40 deg."""
    lines = (DATA / "theodolite_identified_parameters.csv").read_text().splitlines()
    rows = csv.DictReader(line for line in lines if not line.startswith("#"))
    value = {row["parameter"]: float(row["value"]) for row in rows}
    return MirrorGeometry.from_angles(value["alpha"], value["delta"], value["omega"])


def rotated(axis, angle_rad, vector) -> np.ndarray:
    """Rodrigues: `vector` turned right-handed about the unit `axis`."""
    axis, vector = np.asarray(axis, float), np.asarray(vector, float)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    return vector * c + np.cross(axis, vector) * s + axis * (axis @ vector) * (1 - c)


def by_rodrigues(alpha_deg, delta_deg, omega_deg, theta_rad, clockwise_delta=False) -> tuple[float, float]:
    """Azimuth and elevation (rad) of the normal, the axis turned instead of any printed equation."""
    alpha, delta, omega = np.radians([alpha_deg, delta_deg, omega_deg])
    side = 1 if clockwise_delta else -1
    axis = [side * np.sin(alpha) * np.sin(delta), np.sin(alpha) * np.cos(delta), np.cos(alpha)]
    x, y, z = rotated([1, 0, 0], omega, rotated(axis, -theta_rad, [0, 1, 0]))
    return np.arctan2(x, y), np.arcsin(z)


def excess_arcsec(geometry: MirrorGeometry, theta_rad=ARC) -> np.ndarray:
    """theta - A."""
    return ARCSEC_PER_RAD * (theta_rad - geometry.azimuth_rad(theta_rad))


@pytest.mark.parametrize("seed", range(30))
def test_the_printed_equations_turn_the_normal_about_an_axis_whose_delta_runs_counter_clockwise(seed):
    random = np.random.default_rng(seed)
    angles = random.uniform([0, 0, -20], [44, 360, 20])
    geometry = MirrorGeometry.from_angles(*angles)
    for theta in random.uniform(-np.pi, np.pi, 8):
        azimuth, elevation = by_rodrigues(*angles, theta)
        assert geometry.azimuth_rad(np.array([theta]))[0] == pytest.approx(azimuth, abs=1e-12)
        assert geometry.elevation_rad(np.array([theta]))[0] == pytest.approx(elevation, abs=1e-12)


def test_the_printed_matrix_is_no_rotation_and_the_texts_delta_is_another_axis():
    printed = [by_rodrigues(6.7348, 129.3174, -1.6617, theta)[0] for theta in ARC]
    text = [by_rodrigues(6.7348, 129.3174, -1.6617, theta, clockwise_delta=True)[0] for theta in ARC]
    assert np.abs(ARC - printed).max() * ARCSEC_PER_RAD == pytest.approx(738.08, abs=0.005)
    assert np.abs(ARC - text).max() * ARCSEC_PER_RAD == pytest.approx(791.75, abs=0.005)
    flipped = [by_rodrigues(6.7348, 129.3174, 1.6617, theta, clockwise_delta=True)[0] for theta in ARC]
    assert np.abs(ARC - flipped).max() * ARCSEC_PER_RAD == pytest.approx(1371, abs=0.5)
    flipped = excess_arcsec(MirrorGeometry.from_angles(6.7348, 129.3174, 1.6617))
    assert np.abs(flipped).max() == pytest.approx(423.1, abs=0.05)
    # The printed matrix: entries (1,3), (2,1) and (2,3) with the wrong sign. Equality with a rotation would give 1.
    assert abs(np.linalg.det(printed_matrix(np.radians(40), np.radians(30), np.radians(25)))) < 0.9


def printed_matrix(alpha, delta, theta) -> np.ndarray:
    """Rotation by theta clockwise about the printed axis, with the three wrong signs."""
    axis = np.array([-np.sin(alpha) * np.sin(delta), np.sin(alpha) * np.cos(delta), np.cos(alpha)])
    matrix = np.column_stack([rotated(axis, -theta, column) for column in np.eye(3)])
    assert np.linalg.det(matrix) == pytest.approx(1)
    for row, column in ((0, 2), (1, 0), (1, 2)):
        matrix[row, column] *= -1
    return matrix


def test_largest_error_is_738_08_where_742_9_was_printed(published):
    excess = excess_arcsec(published)
    assert np.all(np.diff(excess) > 0)  # grows all the way, as printed
    expected = [0.0, 115.2, 226.0, 330.9, 428.6, 518.4, 599.8, 672.9, 738.1]
    np.testing.assert_allclose(excess[::5], expected, atol=0.05)
    assert excess[-1] == pytest.approx(738.08, abs=0.005)
    # The encoder's own error at 40 deg follows: 4.82 arcsec; the paper prints 4.4 as the largest after correction.
    assert 742.9 - excess[-1] == pytest.approx(4.82, abs=0.005)


def test_rounding_of_the_printed_parameters_cannot_explain_4_4():
    corners = [
        excess_arcsec(MirrorGeometry.from_angles(6.7348 + a * 5e-5, 129.3174 + d * 5e-5, -1.6617 + o * 5e-5))[-1]
        for a in (-1, 1)
        for d in (-1, 1)
        for o in (-1, 1)
    ]
    assert np.ptp(corners) / 2 == pytest.approx(0.013, abs=0.003)


def test_geometry_of_the_paper_case(published):
    axis = np.array([-published.across, published.along, published.up])
    off_plumb = np.degrees(np.arccos(rotated([1, 0, 0], published.omega_rad, axis)[2]))
    assert off_plumb == pytest.approx(5.825, abs=5e-4)
    assert np.degrees(np.arcsin(axis[1])) == pytest.approx(-4.261, abs=1e-3)


@pytest.mark.parametrize(("omega_deg", "excess"), [(2, 21.50), (10, 543.9), (20, 2259.3)])
def test_figure_3_grows_with_omega_and_theta(omega_deg, excess):
    level = MirrorGeometry.from_angles(0, 0, omega_deg)
    theta = np.radians(np.arange(-10, 11.0))
    azimuth = level.azimuth_rad(theta)
    np.testing.assert_allclose(np.tan(azimuth), np.tan(theta) / np.cos(np.radians(omega_deg)), atol=1e-14)
    assert ARCSEC_PER_RAD * (azimuth[-1] - theta[-1]) == pytest.approx(excess, abs=0.05)
    assert np.all(np.diff(np.abs(azimuth - theta)[10:]) > 0)


def test_figure_5_is_like_a_sine_of_delta():
    theta = np.radians([10.0])
    delta = np.arange(0, 360, 10.0)
    excess = np.array([excess_arcsec(MirrorGeometry.from_angles(1, d, 2), theta)[0] for d in delta])
    assert excess.min() == pytest.approx(-19.96, abs=0.01)
    assert excess.max() == pytest.approx(-12.13, abs=0.01)
    spectrum = np.fft.rfft(excess) / len(excess)
    assert spectrum[0].real == pytest.approx(-16.04, abs=0.005)
    assert 2 * abs(spectrum[1]) == pytest.approx(3.81, abs=0.005)
    assert 2 * abs(spectrum[2]) == pytest.approx(0.48, abs=0.005)
    arc = np.radians(np.arange(0, 11.0))
    for d in delta:
        assert np.all(np.diff(np.abs(excess_arcsec(MirrorGeometry.from_angles(1, d, 2), arc))) > 0)


def test_figure_7_falls_only_as_far_as_alpha_2_deg():
    """Printed: the error decreases as alpha grows. It does to alpha = omega, then it grows to three times the start."""
    theta = np.radians([10.0])
    alpha = np.arange(0, 4.01, 0.2)
    excess = np.array([excess_arcsec(MirrorGeometry.from_angles(a, 10, 2), theta)[0] for a in alpha])
    assert (excess[0], excess[10], excess[-1]) == (
        pytest.approx(-21.50, abs=0.005),
        pytest.approx(-0.68, abs=0.005),
        pytest.approx(65.69, abs=0.005),
    )
    assert np.all(np.diff(excess) > 0)  # the signed error, theta - A, rises all the way
    assert alpha[np.argmin(np.abs(excess))] == pytest.approx(2.0)
    assert np.abs(excess).max() == pytest.approx(3 * abs(excess[0]), rel=0.03)


def test_a_zenith_reading_of_90_deg_is_a_level_normal():
    assert MirrorGeometry.from_angles(0, 0, 0).elevation_rad(np.array([0.0]))[0] == 0.0


def test_second_order_law(published):
    for scale, tolerance in ((1.0, 0.38), (0.3, 0.0035)):
        alpha, omega, delta = scale * np.radians(6.7348), -scale * np.radians(1.6617), np.radians(129.3174)
        s, c = np.sin(ARC), np.cos(ARC)
        v, sd, cd = 1 - c, np.sin(delta), np.cos(delta)
        law = (omega**2 - alpha**2) / 2 * s * c - alpha**2 * sd * cd * v * c - alpha**2 * cd**2 * v * s
        law += omega * alpha * (sd * s**2 + cd * v * s)
        exact = MirrorGeometry.from_angles(*np.degrees([alpha, delta, omega])).azimuth_rad(ARC) - ARC
        assert np.abs(law - exact).max() * ARCSEC_PER_RAD < tolerance


@pytest.mark.parametrize(
    ("angles", "end_deg"),
    [
        ((6.7348, 129.3174), 39.795),
        ((173.2652, 50.6826), -39.795),
        ((87.3934, 174.7891), 2.887),
        ((92.6066, 5.2109), -2.887),
    ],
)
def test_four_axes_give_the_same_elevations_and_one_of_them_is_upright(published, angles, end_deg):
    twins = published.twins()
    assert len(twins) == 4
    (twin,) = [g for g in twins if abs(g.alpha_deg - angles[0]) < 1e-4 and abs(g.delta_deg - angles[1]) < 1e-4]
    difference = twin.elevation_rad(ARC) - published.elevation_rad(ARC)
    assert np.abs(difference).max() * ARCSEC_PER_RAD < 2e-10
    assert np.degrees(twin.azimuth_rad(ARC)[-1]) == pytest.approx(end_deg, abs=5e-4)
    assert sum(g.alpha_deg < 45 for g in twins) == 1


def test_the_other_sense_of_elevation_gives_the_same_true_angles(published):
    """Zenith readings counted the other way change delta and omega, not the angle found: nothing can go wrong there."""
    readings = ArcReadings(
        ARC, published.azimuth_rad(ARC), published.elevation_rad(ARC), np.arange(41), np.zeros(41, int)
    )
    other = ArcReadings(ARC, readings.azimuth_rad, -readings.elevation_rad, readings.place, readings.round)
    first, second = solve_arc(readings), solve_arc(other)
    assert np.abs(first.theta_rad - second.theta_rad).max() * ARCSEC_PER_RAD < 1e-6
    assert second.geometry.omega_deg == pytest.approx(-first.geometry.omega_deg, abs=1e-9)


def test_both_methods_recover_the_paper_case_exactly(published):
    elevation = published.elevation_rad(ARC)
    for found in (closed_form(ARC, elevation), least_squares(ARC, elevation)):
        assert found.alpha_deg == pytest.approx(6.7348, abs=1e-9)
        assert found.delta_deg == pytest.approx(129.3174, abs=1e-8)
        assert found.omega_deg == pytest.approx(-1.6617, abs=1e-10)


def test_closed_form_and_least_squares_agree_within_0_02_arcsec(published):
    random = np.random.default_rng(38)
    azimuth = published.azimuth_rad(ARC)
    elevation = published.elevation_rad(ARC) + 0.76 / ARCSEC_PER_RAD * random.standard_normal((1000, 41))
    difference = closed_form(ARC, elevation).theta_rad(azimuth) - least_squares(ARC, elevation).theta_rad(azimuth)
    assert np.abs(difference).max() * ARCSEC_PER_RAD < 0.02


def test_every_random_case_is_found():
    random = np.random.default_rng(5)
    angles = random.uniform([0, 0, -10], [15, 360, 10], (150, 3))
    true = MirrorGeometry.from_angles(*angles.T)
    theta = np.broadcast_to(ARC, (150, 41))
    for found in (closed_form(theta, true.elevation_rad(theta)), least_squares(theta, true.elevation_rad(theta))):
        assert np.abs(found.parameters - true.parameters).max() < 1e-9


STARTS = [(delta, omega) for delta in range(0, 360, 30) for omega in (-10, -5, 0, 5)]


def right_answers(found: MirrorGeometry, true: MirrorGeometry) -> int:
    return int((np.abs(found.parameters - true.parameters).max(axis=-1) < 1e-7).sum())


@pytest.mark.parametrize("alpha_deg", [1, 5, 15])
def test_least_squares_finds_the_axis_from_any_start_nearby(published, alpha_deg):
    delta, omega = np.transpose(STARTS).astype(float)
    start = MirrorGeometry.from_angles(np.full(48, float(alpha_deg)), delta, omega)
    theta = np.broadcast_to(ARC, (48, 41))
    found = least_squares(theta, np.broadcast_to(published.elevation_rad(ARC), (48, 41)), start)
    assert right_answers(found, published) == 48


@pytest.mark.parametrize(("alpha_deg", "lowest", "highest"), [(5, 48, 48), (30, 48, 48), (45, 38, 44), (75, 2, 8)])
def test_starts_of_a_trust_region_search_in_alpha_delta_omega(published, alpha_deg, lowest, highest):
    """The search as the paper does it: from 30 deg every start is good, from 75 deg nearly all lead to a twin."""
    elevation = published.elevation_rad(ARC)

    def residual(angles):
        return MirrorGeometry.from_angles(*np.degrees(angles)).elevation_rad(ARC) - elevation

    tight = {"xtol": 1e-15, "ftol": 1e-15, "gtol": 1e-15}
    ends = [trust_region(residual, np.radians([alpha_deg, *start]), **tight).x for start in STARTS]
    found = MirrorGeometry.from_angles(*np.degrees(ends).T)
    upright = found.upright > 0
    assert lowest <= (upright & (np.abs(found.parameters - published.parameters).max(axis=-1) < 1e-7)).sum() <= highest


# standard deviation of one elevation: of alpha, delta, omega, of the corrected angle from the parameters at 20 and 40
# deg and rms over the arc, all in arcsec
IDENTIFIED = {
    0.5: (3.72, 19.5, 0.22, 0.128, 0.223, 0.138),
    0.76: (5.66, 29.6, 0.34, 0.195, 0.338, 0.210),
    1.0: (7.45, 38.9, 0.44, 0.257, 0.445, 0.277),
}


@pytest.mark.parametrize("sigma", IDENTIFIED)
def test_uncertainty_of_the_parameters_and_of_the_angle(published, sigma):
    covariance = sigma**2 * parameter_covariance(published, ARC)
    turn = angles_by_parameters(published)
    by_parameters = published.derivatives(ARC).theta_by_parameters
    angle = np.sqrt(np.einsum("ni,ij,nj->n", by_parameters, covariance, by_parameters))
    found = (*np.sqrt(np.diag(turn @ covariance @ turn.T)), angle[20], angle[40], np.sqrt(np.mean(angle**2)))
    np.testing.assert_allclose(found, IDENTIFIED[sigma], rtol=0.02)
    correlation = turn @ covariance @ turn.T / np.outer(found[:3], found[:3])
    np.testing.assert_allclose(correlation[[0, 0, 1], [1, 2, 2]], [0.985, -0.775, -0.675], atol=0.001)


@pytest.mark.parametrize(
    ("end_deg", "sd"), [(5, 5.4), (10, 2.2), (20, 0.88), (30, 0.50), (40, 0.34), (60, 0.20), (90, 0.12)]
)
def test_range_effect(published, end_deg, sd):
    arc = np.radians(np.arange(0, end_deg + 1.0))
    by_parameters = published.derivatives(arc).theta_by_parameters
    covariance = 0.76**2 * parameter_covariance(published, arc)
    end = by_parameters[-1]
    assert np.sqrt(end @ covariance @ end) == pytest.approx(sd, rel=0.03)


def test_a_range_to_both_sides_is_better(published):
    arc = np.radians(np.arange(-20, 21.0))
    by_parameters = published.derivatives(arc).theta_by_parameters
    covariance = 0.76**2 * parameter_covariance(published, arc)
    angle = np.sqrt(np.einsum("ni,ij,nj->n", by_parameters, covariance, by_parameters))
    assert angle.max() == pytest.approx(0.20, abs=0.005)


def test_0_76_is_a_difference_of_two_runs_with_0_54_each(published):
    random = np.random.default_rng(12)
    noise = random.standard_normal((2, 2, 1000, 41)) * 0.54 / ARCSEC_PER_RAD
    curves = []
    for azimuth_noise, elevation_noise in noise:
        geometry = least_squares(ARC, published.elevation_rad(ARC) + elevation_noise)
        curves.append(geometry.theta_rad(published.azimuth_rad(ARC) + azimuth_noise))
    sigma = ARCSEC_PER_RAD * (curves[0] - curves[1]).std(axis=1, ddof=1)
    assert sigma.mean() == pytest.approx(0.765, abs=0.01)
    low, high = np.percentile(sigma, [2.5, 97.5])
    assert (low, high) == (pytest.approx(0.59, abs=0.025), pytest.approx(0.93, abs=0.025))


def test_the_encoders_own_error_as_theta_biases_by_0_05_arcsec_and_not_at_all_when_put_right(published):
    ramp = 3.5 / ARCSEC_PER_RAD * ARC / ARC[-1]
    azimuth, elevation = published.azimuth_rad(ARC), published.elevation_rad(ARC)
    as_printed = least_squares(ARC + ramp, elevation).theta_rad(azimuth)
    error = ARCSEC_PER_RAD * (ARC + ramp - as_printed)
    assert abs(error[-1] - error[0] - 3.5) == pytest.approx(0.05, abs=0.005)
    solved = solve_arc(ArcReadings(ARC + ramp, azimuth, elevation, np.arange(41), np.zeros(41, int)))
    np.testing.assert_allclose(np.ptp(solved.error_arcsec), 3.5, atol=1e-6)


def test_an_index_error_of_the_zenith_circle_of_2_arcsec_is_worth_0_1(published):
    azimuth, elevation = published.azimuth_rad(ARC), published.elevation_rad(ARC) + 2.0 / ARCSEC_PER_RAD
    found = least_squares(ARC, elevation).theta_rad(azimuth)
    assert ARCSEC_PER_RAD * abs(found[-1] - ARC[-1]) == pytest.approx(0.10, abs=0.01)


@pytest.mark.parametrize(("tilt_arcmin", "excess"), [(1, 0.010), (5, 0.25), (10, 0.98), (1 / 60, 3e-6)])
def test_alignment_that_needs_no_correction(tilt_arcmin, excess):
    """Both alpha and omega at this size, the worst delta."""
    tilt_deg = tilt_arcmin / 60
    worst = max(
        np.abs(excess_arcsec(MirrorGeometry.from_angles(tilt_deg, delta, sign * tilt_deg))).max()
        for delta in range(0, 360, 5)
        for sign in (-1, 1)
    )
    assert worst == pytest.approx(excess, rel=0.15)
