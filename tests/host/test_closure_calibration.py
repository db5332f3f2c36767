"""`arcref calibrate closure`: from the run file to the calibration, and what is said of it."""

import json

import numpy as np
import pytest
from closure_files import COLUMNS, closure_rows, closure_text, encoder_error

from arcref.calibration.closure_result import closure_result
from arcref.calibration.closure_run import read_closure_run
from arcref.error_curve import ErrorCurve


@pytest.fixture
def calibrated(tmp_path):
    """Calibrate a run file given as text, without the command."""

    def run(text, **options):
        path = tmp_path / "run.csv"
        path.write_text(text)
        return closure_result(read_closure_run(path, **options))

    return run


def test_run_to_calibration_to_rom(tmp_path, arcref):
    path, cal = tmp_path / "run.csv", tmp_path / "cal.json"
    path.write_text(closure_text(closure_rows()))
    outputs = ("--report", tmp_path / "r.html", "--json", tmp_path / "r.json", "--csv", tmp_path / "r.csv")
    result = arcref("calibrate", "closure", path, "-o", cal, *outputs)
    assert (result.exit_code, result.stderr) == (0, "")
    curve = ErrorCurve.from_calibration_json(cal)
    truth = encoder_error(curve.angle_deg)
    off = curve.error_arcsec - truth + truth.mean()
    assert np.abs(off).max() < 4 * curve.u_arcsec.max() < 0.12
    content = json.loads(cal.read_text())
    assert content["kind"] == "closure"
    assert len(content["results"]["face_deviation_arcsec"]) == 8
    assert np.shape(content["results"]["covariance_arcsec2"]) == (16, 16)
    np.testing.assert_allclose(
        np.sqrt(np.diag(content["results"]["covariance_arcsec2"]))[:8], curve.u_arcsec, rtol=1e-5
    )
    assert "Faces of the polygon" in (tmp_path / "r.html").read_text()
    assert arcref("rom", cal, "-o", tmp_path / "x.rom.json").exit_code == 0


def test_the_same_run_gives_the_same_bytes(tmp_path, arcref):
    path = tmp_path / "run.csv"
    path.write_text(closure_text(closure_rows()))
    for name in "ab":
        arcref("calibrate", "closure", path, "-o", tmp_path / f"{name}.json", "--report", tmp_path / f"{name}.html")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_encoder_that_starts_anywhere_and_rows_in_any_order(calibrated):
    rows = closure_rows(start_deg=123.4)
    np.random.default_rng(3).shuffle(rows)
    curve = calibrated(closure_text(rows)).curve
    truth = encoder_error(curve.angle_deg)
    assert np.all(np.diff(curve.angle_deg) > 0)
    assert np.abs(curve.error_arcsec - truth + truth.mean()).max() < 0.1


def test_the_sign_of_x_may_be_stated_or_given(calibrated):
    rows = closure_rows(sign=-1)
    negative = closure_text(rows, "# faces: 8\n# setting_step_deg: 45\n# autocollimator_sign: -1\n")
    unstated = closure_text(rows, "# faces: 8\n# setting_step_deg: 45\n")
    first, second = calibrated(negative), calibrated(unstated, sign=-1)
    np.testing.assert_array_equal(first.curve.error_arcsec, second.curve.error_arcsec)


def test_missing_readings_and_a_missing_face(calibrated):
    rows = [row for index, row in enumerate(closure_rows()) if row[1] != 3 and index % 5]
    result = calibrated(closure_text(rows))
    assert result.results["face_deviation_arcsec"][2] is None
    truth = encoder_error(result.curve.angle_deg)
    assert np.abs(result.curve.error_arcsec - truth + truth.mean()).max() < 5 * result.curve.u_arcsec.max()


def test_rounds_have_their_own_mountings_and_make_it_surer(calibrated):
    one = calibrated(closure_text(closure_rows()))
    lines = [f"1,{','.join(f'{v:.8f}' for v in row)}" for row in closure_rows()]
    lines += [f"2,{','.join(f'{v:.8f}' for v in row)}" for row in closure_rows(seed=2)]
    text = "# faces: 8\n# setting_step_deg: 45\nround," + COLUMNS + "\n" + "\n".join(lines).replace(".00000000", "")
    two = calibrated(text)
    assert len(two.results["mounting"]) == 16
    assert len(two.series.direction) == 16
    assert two.curve.u_arcsec.max() == pytest.approx(one.curve.u_arcsec.max() / np.sqrt(2), rel=0.25)


def test_closing_readings_tell_the_closing_error_and_are_no_readings_of_their_own(calibrated):
    rows = closure_rows()
    again = [(s, f, p + 360.0, x + 0.2) for s, f, p, x in rows if f == 1]
    result = calibrated(closure_text(rows + again))
    plain = calibrated(closure_text(rows))
    np.testing.assert_allclose(result.curve.error_arcsec, plain.curve.error_arcsec, atol=1e-8)
    np.testing.assert_allclose(result.series.closing_error_arcsec, 0.2, atol=1e-6)
    assert result.passed
    late = [(s, f, p + 360.0, x + 0.9) for s, f, p, x in rows if f == 1]
    assert not calibrated(closure_text(rows + late)).passed


def test_an_outlier_is_named_by_its_row_and_the_command_ends_with_1(tmp_path, arcref):
    rows = closure_rows()
    setting, face, position, x = rows[19]
    rows[19] = (setting, face, position, x + 1.0)
    path = tmp_path / "run.csv"
    path.write_text(closure_text(rows))
    result = arcref("calibrate", "closure", path, "-o", tmp_path / "cal.json")
    assert result.exit_code == 1
    assert f"row {19 + 5} (setting {setting}, face {face})" in result.output
    assert (tmp_path / "cal.json").exists()


def test_what_a_partial_set_lost_is_said_and_bounded_only_by_what_is_stated(calibrated):
    settings = range(1, 5)
    rows = closure_rows(settings=settings, step_deg=90.0)
    text = closure_text(rows, "# faces: 8\n# setting_step_deg: 90\n")
    open_ended = calibrated(text)
    assert open_ended.results["lost_orders"] == [4]
    assert any("cannot tell order 4 of the encoder's error from the faces" in text for text in open_ended.warnings)
    assert any("lost orders (4)" in missing.name for missing in open_ended.budget.missing)
    bounded = calibrated("# u_face_deviation_arcsec: 2\n" + text)
    assert not any("lost orders" in missing.name for missing in bounded.budget.missing)
    # Order 4 of 8 faces: one of seven directions about the mean, shared by all positions.
    added = np.sqrt(bounded.curve.u_arcsec**2 - open_ended.curve.u_arcsec**2)
    np.testing.assert_allclose(added, 2 / np.sqrt(8), rtol=1e-6)


def test_without_a_reading_left_over_the_repeatability_must_be_stated(calibrated):
    text = closure_text(closure_rows(settings=[1, 2]))
    silent = calibrated(text)
    assert silent.curve.u_arcsec is None
    assert any(missing.metadata_key == "u_repeatability_arcsec" for missing in silent.budget.missing)
    stated = calibrated("# u_repeatability_arcsec: 0.05\n" + text)
    assert stated.curve.u_arcsec.max() > 0.05


def test_a_stated_repeatability_that_the_readings_exceed_fails(calibrated):
    text = closure_text(closure_rows(noise_arcsec=0.5))
    assert calibrated("# u_repeatability_arcsec: 0.5\n" + text).passed
    assert not calibrated("# u_repeatability_arcsec: 0.1\n" + text).passed


def test_the_budget_holds_what_was_stated_and_names_what_was_not(calibrated):
    stated = "# u_autocollimator_arcsec: 0.1\n# tilt_limit_arcsec: 100\n# u_temperature_arcsec: 0.05\n"
    result = calibrated(stated + closure_text(closure_rows()))
    names = {term.name: term for term in result.budget.contributions}
    assert names["autocollimator"].u == 0.1
    assert names["repeatability"].type == "A"
    assert names["repeatability"].degrees_of_freedom == 64 - 22
    # 9/160 psi^4 in the mean square: rectangular below the limit, over all azimuths.
    assert names["tower tilt"].u == pytest.approx(np.sqrt(9 / 160) * 100**2 / 206264.8, rel=1e-6)
    assert [missing.metadata_key for missing in result.budget.missing] == [
        "u_eccentric_mounting_arcsec",
        "u_interpolation_arcsec",
    ]


def plan(arcref, faces, settings, step_deg):
    options = ("--faces", faces, "--settings", settings, "--setting-step", step_deg)
    return arcref("calibrate", "closure", "--plan", *options)


def test_plan_says_what_is_lost_before_the_run(arcref):
    result = plan(arcref, 24, 5, 60)
    assert result.exit_code == 0
    assert "Lost: orders 6, 12 of the encoder's error cannot be told from the faces." in result.output
    result = plan(arcref, 24, 5, 15)
    assert "Every order that these positions show is separated" in result.output
    assert "Weak: order 1 with 2.77 times" in result.output
    assert "Better with as many settings: 1," in result.output
    whole = arcref("calibrate", "closure", "--plan", "--faces", 24)
    assert "24 settings, 15 deg apart" in whole.output
    assert "Better" not in whole.output


def test_plan_of_a_run_file_counts_the_readings_it_will_have(tmp_path, arcref):
    """With or without readings in it; a face that cannot be read at a setting is left out."""
    path = tmp_path / "plan.csv"
    rows = "\n".join(f"{setting},{face}" for setting in (1, 3) for face in range(1, 9) if (setting, face) != (3, 5))
    path.write_text("# faces: 8\n# setting_step_deg: 45\nsetting,face\n" + rows + "\n")
    result = arcref("calibrate", "closure", path, "--plan")
    assert (result.exit_code, result.stderr) == (0, "")
    assert "15 for" in result.output
    path.write_text(closure_text(closure_rows()))
    assert "64 for 22 unknowns" in arcref("calibrate", "closure", path, "--plan").output
    assert [file.name for file in tmp_path.iterdir()] == ["plan.csv"]


def test_without_plan_run_and_output_are_needed(tmp_path, arcref):
    result = arcref("calibrate", "closure")
    assert result.exit_code == 2
    assert "RUN.csv" in result.stderr
    (tmp_path / "run.csv").write_text(closure_text(closure_rows()))
    result = arcref("calibrate", "closure", tmp_path / "run.csv")
    assert result.exit_code == 2
    assert "--output" in result.stderr


@pytest.mark.parametrize(
    ("faces", "settings", "step_deg", "line"),
    [
        (24, 1, 15, "--settings: 1 settings, 2 .. 1000 were expected"),
        (2, 5, 15, "2 faces, 3 .. 360 were expected"),
        (24, "1,x", 15, "--settings: '1,x' is neither how many settings nor their numbers, as in 1,2,5"),
        (24, 5, 0, "a step of 0 deg, 0.1 to less than 360 deg was expected"),
        (24, "1,1", 15, "at least two different settings of the polygon were expected: one separates nothing"),
    ],
)
def test_a_plan_that_cannot_be(arcref, faces, settings, step_deg, line):
    result = plan(arcref, faces, settings, step_deg)
    assert (result.exit_code, result.stderr) == (2, f"arcref: {line}\n")


def test_a_plan_needs_faces_or_a_run_file(arcref):
    result = arcref("calibrate", "closure", "--plan")
    assert (result.exit_code, result.stderr) == (2, "arcref: --plan needs --faces, or a run file that states them\n")


def test_as_found_and_as_left_and_a_second_run(tmp_path, arcref):
    for name, seed in (("found", 1), ("left", 2)):
        (tmp_path / f"{name}.csv").write_text(closure_text(closure_rows(seed=seed)))
    found, left = tmp_path / "found.csv", tmp_path / "left.csv"
    result = arcref("calibrate", "closure", found, "-o", tmp_path / "c.json", "--as-left", left, "--verify", left)
    assert (result.exit_code, result.stderr) == (0, "")
    assert "as left" in result.output
    content = json.loads((tmp_path / "c.json").read_text())
    assert content["provenance"]["inputs"][0]["file"] == "left.csv"
