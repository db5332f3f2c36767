"""`arcref calibrate theodolite`: from the run file to the calibration, and what is said of it."""

import json

import numpy as np
import pytest
from theodolite_files import PUBLISHED, STATED, encoder_error, theodolite_rows, theodolite_text

from arcref.calibration.theodolite_arc import arc_u_arcsec, shortest_arc_deg
from arcref.calibration.theodolite_model import MirrorGeometry
from arcref.calibration.theodolite_result import theodolite_result
from arcref.calibration.theodolite_run import read_theodolite_run
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcReadings, solve_arc
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError

ARC = np.arange(41.0)


@pytest.fixture
def calibrated(tmp_path):
    """Calibrate a run file given as text, without the command."""

    def run(text, *arguments):
        path = tmp_path / "run.csv"
        path.write_text(text)
        return theodolite_result(read_theodolite_run(path), *arguments)

    return run


def off_truth(result, theta_deg=ARC) -> np.ndarray:
    truth = encoder_error(theta_deg)
    return result.curve.error_arcsec - truth + truth.mean()


def simulated(noise_arcsec, runs=2000, rounds=1, seed=38, angles=PUBLISHED, theta_deg=ARC) -> ArcReadings:
    """Readings float64[runs, n] of an encoder with an error."""
    random = np.random.default_rng(seed)
    theta = np.tile(np.radians(theta_deg), rounds)
    geometry = MirrorGeometry.from_angles(*angles)
    shape = (runs, theta.size)
    noise = noise_arcsec / ARCSEC_PER_RAD * random.standard_normal((2, *shape))
    reading = theta + encoder_error(np.degrees(theta)) / ARCSEC_PER_RAD
    return ArcReadings(
        np.broadcast_to(reading, shape),
        geometry.azimuth_rad(theta) + noise[0],
        geometry.elevation_rad(theta) + noise[1],
        np.tile(np.arange(len(theta_deg)), rounds),
        np.repeat(np.arange(rounds), len(theta_deg)),
    )


def test_published_case_with_0_76_arcsec_corrects_to_0_80_and_states_it():
    readings = simulated(0.76)
    solution = solve_arc(readings)
    truth = encoder_error(ARC)
    off = solution.error_arcsec - truth + truth.mean()
    assert off.std() == pytest.approx(0.80, rel=0.1)
    stated = np.sqrt(np.diag(solve_arc(simulated(0.76, runs=1)).sensitivity().error_covariance(0.76, 0.76)[0]))
    assert stated.mean() == pytest.approx(off.std(), rel=0.02)
    assert np.mean(np.abs(off) < 1.96 * stated) == pytest.approx(0.95, abs=0.006)
    assert solution.elevation_sigma_arcsec.mean() == pytest.approx(0.76, rel=0.01)


def test_the_covariance_is_that_of_the_scatter_parameters_and_errors_alike():
    solution = solve_arc(simulated(0.76, runs=2000, rounds=2))
    one = solve_arc(simulated(0.0, runs=1, rounds=2))
    sensitivity = one.sensitivity()
    off = solution.error_arcsec - one.error_arcsec
    covariance = sensitivity.error_covariance(0.76, 0.76)[0]
    assert np.abs(off.T @ off / len(off) - covariance).max() < 0.12 * covariance.max()
    angles = np.sqrt(np.diag(sensitivity.angle_covariance(0.76, 0.76)[0]))
    geometry = solution.geometry
    scatter = [3600 * np.std(values) for values in (geometry.alpha_deg, geometry.delta_deg, geometry.omega_deg)]
    np.testing.assert_allclose(scatter, angles, rtol=0.06)
    assert solution.azimuth_freedom == 40
    assert solution.azimuth_sigma_arcsec.mean() == pytest.approx(0.76, rel=0.02)


def test_without_noise_the_truth_comes_back_in_any_quarter_of_the_circle(calibrated):
    for angles in ((0.5, 10, 3), (12, 250, -8), (0.001, 0, 0.002), (3, 180, 0)):
        rows = theodolite_rows(angles, np.arange(-25, 26, 2.5), noise_arcsec=0.0, north_deg=350.0)
        result = calibrated(theodolite_text(rows))
        truth = encoder_error(np.arange(-25, 26, 2.5))
        assert np.abs(result.curve.error_arcsec - truth + truth.mean()).max() < 1e-3  # the file has 8 decimals
        assert result.curve.arc_deg == pytest.approx((-25, 25), abs=1e-3)


def test_run_to_calibration_to_rom(tmp_path, arcref):
    path, cal = tmp_path / "run.csv", tmp_path / "cal.json"
    path.write_text(theodolite_text(theodolite_rows()))
    outputs = ("--report", tmp_path / "r.html", "--json", tmp_path / "r.json", "--csv", tmp_path / "r.csv")
    result = arcref("calibrate", "theodolite", path, "-o", cal, "--require", 0.7, *outputs)
    assert (result.exit_code, result.stderr) == (0, "")
    curve = ErrorCurve.from_calibration_json(cal)
    assert curve.arc_deg == pytest.approx((0, 40), abs=1e-3)
    results = json.loads(cal.read_text())["results"]
    for name, value in zip(("alpha", "delta", "omega"), PUBLISHED, strict=True):
        assert abs(results[f"{name}_deg"] - value) < 4 * results[f"u_{name}_deg"]
    assert results["correlation"]["alpha_delta"] == pytest.approx(0.985, abs=0.003)
    assert results["closed_form_difference_arcsec"] < 0.02
    assert "Axis and mirror" in (tmp_path / "r.html").read_text()
    assert arcref("rom", cal, "-o", tmp_path / "x.rom.json").exit_code == 0
    table = json.loads((tmp_path / "x.rom.json").read_text())["line_table"]
    assert any(table[10:450])
    assert not any(table[460:4090])


def test_an_arc_over_the_encoders_zero_and_over_north(calibrated):
    rows = theodolite_rows(start_deg=340.0, north_deg=345.0)
    result = calibrated(theodolite_text(rows, STATED + "# datum_deg: 340\n"))
    assert np.all(np.diff(result.curve.angle_deg) > 0)
    assert result.curve.arc_deg == pytest.approx((-20, 20), abs=1e-3)
    assert np.abs(off_truth(result)).max() < 4 * result.curve.u_arcsec.max()
    assert result.results["delta_deg"] == pytest.approx(PUBLISHED[1], abs=0.05)


@pytest.mark.parametrize("turns", [-2, 0, 1])
def test_whole_turns_of_the_reading_do_not_matter(calibrated, turns):
    """An error curve begins within a turn of the encoder's zero, or the ROM could not be made of it."""
    rows = [(reading + 360.0 * turns, *rest) for reading, *rest in theodolite_rows(start_deg=100.0)]
    result = calibrated(theodolite_text(rows))
    assert -360 <= result.curve.angle_deg[0] <= 360
    assert np.mod(result.curve.angle_deg[0], 360.0) == pytest.approx(100.0, abs=0.01)
    assert np.abs(off_truth(result)).max() < 4 * result.curve.u_arcsec.max()


def test_the_datum_moves_the_angles_and_not_the_errors(calibrated):
    rows = theodolite_rows(start_deg=100.0)
    first = calibrated(theodolite_text(rows))
    assert first.results["datum_deg"] == pytest.approx(100.0, abs=1e-3)
    other = calibrated(theodolite_text(rows, STATED + "# datum_deg: 120\n"))
    # Both angles are stated against a mirror that is level to one side at the datum: another datum, other angles.
    assert abs(other.results["alpha_deg"] - first.results["alpha_deg"]) > 0.5
    assert abs(other.results["delta_deg"] - first.results["delta_deg"]) > 5
    np.testing.assert_allclose(other.curve.error_arcsec, first.curve.error_arcsec, atol=1e-6)
    np.testing.assert_allclose(other.curve.u_arcsec, first.curve.u_arcsec, rtol=1e-4)


def test_an_encoder_that_counts_the_other_way(calibrated):
    rows = theodolite_rows(direction=-1, start_deg=50.0)
    result = calibrated(theodolite_text(rows, STATED + "# encoder_direction: -1\n# datum_deg: 50\n"))
    truth = encoder_error(ARC[::-1])
    assert np.abs(result.curve.error_arcsec - truth + truth.mean()).max() < 4 * result.curve.u_arcsec.max()
    assert result.results["alpha_deg"] == pytest.approx(PUBLISHED[0], abs=0.01)


def test_rounds_with_the_circle_turned_between_them(calibrated):
    first, second = theodolite_rows(seed=1), theodolite_rows(seed=2, north_deg=200.0)
    lines = [
        f"{number}," + ",".join(f"{v:.8f}" for v in row) for number, rows in ((1, first), (2, second)) for row in rows
    ]
    text = "# u_zenith_arcsec: 0.3\nround,reading_deg,azimuth_deg,zenith_deg\n" + "\n".join(lines) + "\n"
    result = calibrated(text)
    assert np.abs(off_truth(result)).max() < 4 * result.curve.u_arcsec.max()
    assert result.curve.u_arcsec.max() < 0.3
    (azimuth,) = [term for term in result.budget.contributions if term.name == "repeatability"]
    assert (azimuth.type, azimuth.degrees_of_freedom) == ("A", 40)
    assert azimuth.u == pytest.approx(0.3, rel=0.4)
    assert len(result.series.direction) == 2


def test_without_a_word_on_azimuths_one_round_states_no_uncertainty(calibrated):
    result = calibrated(theodolite_text(theodolite_rows(), ""))
    assert result.curve.u_arcsec is None
    assert any(missing.metadata_key == "u_azimuth_arcsec" for missing in result.budget.missing)


def test_near_upright_delta_is_not_stated_and_the_angle_is_as_good_as_ever(calibrated):
    result = calibrated(theodolite_text(theodolite_rows((0.0, 0.0, 0.0))))
    assert result.results["delta_deg"] is None
    assert any("delta is not defined" in warning for warning in result.warnings)
    assert np.abs(off_truth(result)).max() < 4 * 0.3


def test_a_short_arc_is_refused_in_a_sentence_and_the_arc_it_names_would_do(calibrated):
    rows = theodolite_rows(theta_deg=np.linspace(0, 4, 41))
    with pytest.raises(InputError) as refused:
        theodolite_require(calibrated, rows, 0.9)
    sentence = str(refused.value)
    assert "an arc of 4 deg gives the error with an expanded uncertainty of" in sentence
    arc = float(sentence.rsplit("an arc of ", 1)[1].split(" deg")[0])
    assert 4 < arc < 20
    longer = theodolite_rows(theta_deg=np.linspace(0, arc, 41))
    assert theodolite_require(calibrated, longer, 0.9).passed


def theodolite_require(calibrated, rows, required_arcsec):
    return calibrated(theodolite_text(rows, STATED + f"# required_expanded_uncertainty_arcsec: {required_arcsec}\n"))


def test_an_arc_cannot_make_up_for_azimuths_that_are_too_coarse(calibrated):
    with pytest.raises(InputError, match="no arc would do, the 0.3 arcsec of an azimuth reading are too much"):
        theodolite_require(calibrated, theodolite_rows(), 0.5)


def test_uncertainty_falls_with_the_arc():
    geometry = MirrorGeometry.from_angles(*PUBLISHED)
    u = [arc_u_arcsec(geometry, 0.0, arc, 41, 0.76, 0.0).max() for arc in (5, 10, 20, 40, 80)]
    assert all(np.diff(u) < 0)
    arc = shortest_arc_deg(0.5, geometry, 0.0, 41, 0.76, 0.3, 1)
    assert arc_u_arcsec(geometry, 0.0, arc, 41, 0.76, 0.3).max() <= 0.5
    assert arc_u_arcsec(geometry, 0.0, arc / 1.02, 41, 0.76, 0.3).max() > 0.5


def test_what_all_readings_share_is_put_through_the_reduction(calibrated):
    """SCIENCE: 2 arcsec of zenith index are worth 0.10 arcsec at 40 deg; about the mean, less than half of it."""
    stated = "# u_zenith_index_arcsec: 2\n# u_levelling_arcsec: 1\n# u_collimation_arcsec: 5\n"
    result = calibrated(theodolite_text(theodolite_rows(), STATED + stated))
    terms = {term.name: term for term in result.budget.contributions}
    assert terms["index of the zenith circle"].u_arcsec == pytest.approx(0.03, abs=0.01)
    assert 0.001 < terms["levelling of the theodolite"].u_arcsec < 0.1
    assert terms["collimation of the theodolite"].u_arcsec < 0.01  # 1 / cos of 2 deg
    assert [missing.metadata_key for missing in result.budget.missing] == [
        "u_mirror_walk_arcsec",
        "u_interpolation_arcsec",
    ]


def test_an_outlier_and_a_scatter_beyond_what_is_stated_fail(calibrated):
    rows = theodolite_rows()
    reading, azimuth, zenith = rows[12]
    rows[12] = (reading, azimuth, zenith + 3 / 3600)
    result = calibrated(theodolite_text(rows))
    assert not result.passed
    assert f"row {12 + 4} (12.0" in result.checks[0].found
    coarse = calibrated(theodolite_text(theodolite_rows(noise_arcsec=1.0)))
    assert not coarse.passed


def test_a_slip_of_an_azimuth_is_pointed_at(calibrated):
    rows = theodolite_rows()
    reading, azimuth, zenith = rows[20]
    rows[20] = (reading, azimuth + 30 / 3600, zenith)
    assert any(
        f"is the azimuth in row {20 + 4} a slip?" in warning for warning in calibrated(theodolite_text(rows)).warnings
    )


def test_a_whole_turn_is_no_arc(calibrated):
    rows = theodolite_rows((1.0, 40.0, 0.5), np.arange(0, 360, 10.0))
    result = calibrated(theodolite_text(rows))
    assert result.curve.arc_deg is None
    assert np.abs(off_truth(result, np.arange(0, 360, 10.0))).max() < 4 * result.curve.u_arcsec.max()
