"""`arcref calibrate polygon` from the run file to its files, its figures and its exit status."""

import json

import numpy as np
import pytest
from made_polygon_run import STATED, polygon_run_text

from arcref.correction_rom import CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.rom_image import load_rom

FULL = (*STATED, ("encoder_serial", "AR-7"), ("date", "2026-11-23"), ("autocollimator_sign", "+1"))


@pytest.fixture
def run(tmp_path):
    """Writes a made run: `run("name.csv", **made)` gives its path."""

    def write(name="run.csv", **made):
        path = tmp_path / name
        made.setdefault("metadata", FULL)
        path.write_text(polygon_run_text(**made), encoding="utf-8")
        return path

    return write


@pytest.fixture
def calibrate(arcref, tmp_path):
    """Runs the verb: its result and the content of CAL.json."""

    def command(path, *options, status=0):
        output = tmp_path / "cal.json"
        result = arcref("calibrate", "polygon", path, "-o", output, *options)
        assert result.exit_code == status, result.output
        return result, json.loads(output.read_text(encoding="utf-8")) if output.exists() else None

    return command


def test_the_calibration_is_what_design_says(run, calibrate, tmp_path):
    path = run(psi_arcsec=300.0, directions=(1, -1))
    result, content = calibrate(path)
    assert {key: content[key] for key in ("format", "version", "kind")} == {
        "format": "arcref-calibration",
        "version": 1,
        "kind": "polygon",
    }
    assert set(content["curve"]) == {"angle_deg", "error_arcsec", "u_arcsec"}
    assert {len(values) for values in content["curve"].values()} == {24}
    assert content["curve"]["error_arcsec"][0] == 0
    tilt = content["results"]["tilt"]
    assert tilt["psi_arcsec"] == pytest.approx(300, abs=5 * tilt["u_psi_arcsec"])
    assert tilt["omega_deg"] == pytest.approx(40, abs=5 * tilt["u_omega_deg"])
    assert content["provenance"]["encoder_serial"] == "AR-7"
    (entry,) = content["provenance"]["inputs"]
    assert entry["file"] == "run.csv"
    assert len(entry["sha256"]) == 64
    curve = ErrorCurve.from_calibration_json(tmp_path / "cal.json")
    assert curve.u_arcsec.min() > 0
    assert "expanded uncertainty" in result.stdout
    assert "Caution: An error of order 4096" in result.stdout


def test_the_rom_takes_it(run, calibrate, arcref, tmp_path):
    _, content = calibrate(run())
    result = arcref("rom", tmp_path / "cal.json", "-o", tmp_path / "x.rom.json")
    assert result.exit_code == 0, result.output
    rom = load_rom(tmp_path / "x.rom.json")
    assert isinstance(rom, CorrectionRom)
    assert rom.provenance["expanded_uncertainty_arcsec"] >= 2 * min(content["curve"]["u_arcsec"])


def test_every_file_at_once_and_the_same_again(run, calibrate, tmp_path):
    names = {"--report": "r.html", "--json": "r.json", "--csv": "r.csv"}
    options = [part for option, name in names.items() for part in (option, tmp_path / name)]
    path = run(psi_arcsec=300.0)
    contents = []
    for _ in range(2):
        calibrate(path, *options)
        contents.append([(tmp_path / name).read_bytes() for name in (*names.values(), "cal.json")])
    assert contents[0] == contents[1]
    page = contents[0][0].decode()
    assert "Tower tilt" in page
    assert 'src="http' not in page
    record = json.loads(contents[0][1])
    assert record["runs"][0]["results"]["tilt"]["corrected"] is True
    rows = [line for line in contents[0][2].decode().splitlines() if not line.startswith("#")]
    assert len(rows) == 25


def test_a_round_that_does_not_close_fails_and_is_written_all_the_same(run, calibrate):
    result, content = calibrate(run(drift_arcsec=1.5, noise_arcsec=0.05), status=1)
    assert "FAILED: each round closes within 0.5 arcsec" in result.stdout
    assert "in round" in result.stdout
    assert "4 of 4 beyond the limit" in result.stdout
    assert content["results"]["series"][0]["closing_error_arcsec"] == pytest.approx(1.5, abs=0.3)


def test_the_limit_of_the_closing_error_is_the_users(run, calibrate):
    made = {"drift_arcsec": 0.4, "noise_arcsec": 0.02}
    calibrate(run(metadata=(*FULL, ("closing_limit_arcsec", 1.0)), **made))
    result, _ = calibrate(run(metadata=(*FULL, ("closing_limit_arcsec", 0.2)), **made), status=1)
    assert "each round closes within 0.2 arcsec (stated in the run file)" in result.stdout


def test_noise_alone_is_no_reason_to_fail(run, calibrate):
    """With 0.4 arcsec of noise a closing error beyond 0.5 arcsec is nothing unusual; the limit knows the scatter."""
    for seed in range(12):
        _, content = calibrate(run(noise_arcsec=0.4, seed=seed, directions=(1, -1)))
        assert content["results"]["closing_limit_arcsec"] == pytest.approx(4 * np.sqrt(2) * 0.4, rel=0.25)


def test_tilt_correction_on_and_off(run, calibrate):
    path = run(psi_arcsec=1369.0, noise_arcsec=0.05)
    _, on = calibrate(path)
    result, off = calibrate(path, "--no-tilt-correction")
    assert off["curve"]["error_arcsec"] == on["results"]["error_without_tilt_correction_arcsec"]
    assert np.ptp(np.subtract(off["curve"]["error_arcsec"], on["curve"]["error_arcsec"])) > 8
    assert (on["results"]["tilt"]["corrected"], off["results"]["tilt"]["corrected"]) == (True, False)
    assert "Tower tilt and roll were left in x, as asked for." in result.stdout


def test_tolerance_and_screws(run, calibrate):
    more = (
        ("encoder_grade", 2),
        ("screw_angles_deg", "0 120 240"),
        ("screw_radius_mm", 60),
        ("screw_pitch_mm", 0.5),
    )
    path = run(psi_arcsec=300.0, omega_deg=0.0, y_noise_arcsec=0.01, metadata=(*FULL, *more))
    result, content = calibrate(path)
    tolerance = content["results"]["tilt"]["tolerance"]
    assert tolerance["formula_arcsec"] == pytest.approx(176.72, abs=0.005)
    assert tolerance["published_arcsec"] == 178
    assert "beyond the tolerance of 176.7 arcsec; it was corrected" in result.stdout
    first, second, third = content["results"]["tilt"]["screws"]
    assert first["rise_um"] == pytest.approx(-87.3, abs=0.05)
    assert first["turn_deg"] == pytest.approx(-62.8, abs=0.05)
    assert second["rise_um"] == pytest.approx(third["rise_um"], abs=0.05) == pytest.approx(43.6, abs=0.05)
    result, _ = calibrate(path, "--no-tilt-correction", status=1)
    assert "FAILED: the tower tilt, left uncorrected, is within 176.7 arcsec (300.0 arcsec)" in result.stdout


def test_sign_by_option(run, calibrate):
    path = run(noise_arcsec=0.05)
    result, _ = calibrate(path, "--sign", "-1", "--accept-suspect")
    assert "The sign of x is -1 by the command's option, against +1 in the run file." in result.stdout
    result, _ = calibrate(run(metadata=STATED))
    assert "Caution: The sign of x was assumed to be +1" in result.stdout


def test_a_suspicion_is_refused_unless_accepted_and_never_repaired(run, arcref, calibrate, tmp_path):
    path = run(noise_arcsec=0.05)
    refused = arcref("calibrate", "polygon", path, "-o", tmp_path / "cal.json", "--sign", "-1")
    assert refused.exit_code == 2
    assert refused.stdout == ""
    assert refused.stderr.count("\n") == 1
    assert refused.stderr.startswith(f"arcref: {path}, row ")
    assert "column autocollimator_x_arcsec: the sign of x seems to be flipped" in refused.stderr
    assert "correct the run file, or accept it as it is with --accept-suspect" in refused.stderr
    assert not (tmp_path / "cal.json").exists()
    result, accepted = calibrate(path, "--sign", "-1", "--accept-suspect")
    assert "Caution: Accepted though it looks like a mistake: row " in result.stdout
    _, right = calibrate(path)
    # Accepted as it stands: the curve is the wrong one, not the right one in disguise.
    assert np.abs(np.subtract(accepted["curve"]["error_arcsec"], right["curve"]["error_arcsec"])).max() > 2


def test_compare_and_verify(run, calibrate, examples):
    path, second = run(), run("second.csv", seed=2, first_deg=7.5)
    result, content = calibrate(path, "--compare", "--verify", second)
    comparison = content["results"]["comparison"]
    assert [entry["fit"] for entry in comparison] == ["rbf", "fourier", "spline", "gaussian-process", None]
    *fits, without = [entry["verification"]["sigma_arcsec"] for entry in comparison]
    assert max(fits) < 0.3 < without
    assert content["provenance"]["verified_with"]["file"] == "second.csv"
    _, reduced = calibrate(path, "--verify", examples / "polygon_before_correction.csv")
    assert reduced["results"]["comparison"][0]["verification"]["n"] == 25


def test_monte_carlo_agrees_and_is_reported(run, calibrate):
    result, content = calibrate(run(psi_arcsec=300.0, directions=(1, -1)), "--monte-carlo", "300")
    repeated = content["results"]["monte_carlo"]
    assert repeated["runs"] == 300
    assert abs(repeated["from_budget"]) < 0.05
    assert "Monte Carlo" in result.stdout


def test_as_found_and_as_left(run, calibrate, tmp_path):
    found = run()
    left = run("left.csv", harmonics=((1, 0.2), (2, 0.1)), seed=3)
    result, content = calibrate(
        found, "--as-left", left, "--report", tmp_path / "r.html", "--json", tmp_path / "r.json"
    )
    assert "as found" in result.stdout
    assert "as left" in result.stdout
    # The calibration to use is that of the encoder as it was left.
    assert content["provenance"]["inputs"][0]["file"] == "left.csv"
    assert np.ptp(content["curve"]["error_arcsec"]) < 1
    record = json.loads((tmp_path / "r.json").read_text(encoding="utf-8"))
    assert [each["label"] for each in record["runs"]] == ["as found", "as left"]
    page = (tmp_path / "r.html").read_text(encoding="utf-8")
    assert "As left" in page or "as left" in page


def test_the_second_run_that_verifies_is_shown_beside_a_run_as_left(run, calibrate):
    found, second = run(), run("second.csv", seed=5)
    left = run("left.csv", harmonics=((1, 0.2), (2, 0.1)), seed=3)
    result, _ = calibrate(found, "--compare", "--verify", second, "--as-left", left)
    as_found, as_left = result.stdout.split("as left: Fits side by side")
    assert "as found: Fits side by side" in as_found
    head = as_found[as_found.index("as found: Fits") :]
    assert "second" in head
    assert "second" not in as_left[: as_left.index("no correction")]


def test_two_encoders_are_not_one_found_and_left(run, arcref, tmp_path):
    found = run()
    left = run("left.csv", metadata=(*STATED, ("encoder_serial", "AR-8")))
    result = arcref("calibrate", "polygon", found, "-o", tmp_path / "cal.json", "--as-left", left)
    assert result.exit_code == 2
    expected = "metadata encoder_serial: 'AR-8', but run.csv is of 'AR-7': one encoder was expected, found and left"
    assert result.stderr == f"arcref: {left}, row 7: {expected}\n"
    assert not (tmp_path / "cal.json").exists()


def test_what_is_missing_is_named_and_not_guessed(run, calibrate):
    result, content = calibrate(run(metadata=(), certificate=False, rounds=1, noise_arcsec=0.05))
    for text in (
        "No face deviations",
        "Not in the budget: face deviations",
        "'# u_face_certificate_arcsec: ...'",
        "'# u_autocollimator_arcsec: ...'",
        "'# u_repeatability_arcsec: ...'",
        "'# tilt_limit_arcsec: ...'",
    ):
        assert text in result.stdout
    assert content["results"]["repeatability_arcsec"] is None
    assert content["results"]["certificate_used"] is False
    assert "tilt" not in content["results"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["-o", "run.csv"], "the name of a calibration must end in .json"),
        (["-o", "x.rom.json"], "the name of a calibration must end in .json, and not in .rom.json"),
        (["-o", "cal.json", "--json", "cal.json"], "this name is given to two files of this run"),
        (["-o", "cal.json", "--csv", "run.csv"], "this name is given to two files of this run"),
        (["-o", "cal.json", "--report", "nowhere/r.html"], "its folder does not exist"),
        (["-o", "cal.json", "--as-left", "none.csv"], "there is no such file"),
        (["-o", "cal.json", "--verify", "none.csv"], "there is no such file"),
        (["-o", "cal.json", "--fit", "guess"], "Invalid value for '--fit'"),
        (["-o", "cal.json", "--monte-carlo", "5"], "Invalid value for '--monte-carlo'"),
        (["-o", "cal.json", "--sign", "2"], "Invalid value for '--sign'"),
        ([], "Missing option '-o'"),
    ],
)
def test_bad_use(run, arcref, tmp_path, monkeypatch, options, expected):
    run()
    monkeypatch.chdir(tmp_path)
    before = (tmp_path / "run.csv").read_bytes()
    result = arcref("calibrate", "polygon", "run.csv", *options)
    assert result.exit_code == 2
    assert expected in result.stderr
    assert result.stdout == ""
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.csv"]
    assert (tmp_path / "run.csv").read_bytes() == before


def test_help_lists_the_verbs(arcref):
    result = arcref("calibrate", "--help")
    assert result.exit_code == 0
    for text in ("polygon", "Calibrate against a polygon and an autocollimator.", "closure", "theodolite"):
        assert text in result.stdout


def test_y_in_minutes_of_arc_is_cautioned(run, calibrate):
    """The rounds tell: x and y of one instrument scatter alike."""
    path = run(psi_arcsec=300.0)
    result, content = calibrate(path)
    assert "minutes of arc" not in result.output
    head, *rows = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    assert head.endswith("autocollimator_y_arcsec")
    rows = [f"{line.rsplit(',', 1)[0]},{float(line.rsplit(',', 1)[1]) / 60:.4f}" for line in rows]
    metadata = [line for line in path.read_text().splitlines() if line.startswith("#")]
    path.write_text("\n".join([*metadata, head, *rows]) + "\n")
    result, _ = calibrate(path)
    assert "was y written in minutes of arc" in " ".join(result.output.split())


def test_a_number_stated_twice_is_refused(run, calibrate):
    result, content = calibrate(run(metadata=(*FULL, ("faces", 23))), status=2)
    assert "stated more than once (24; 23)" in result.output
    assert content is None


def test_a_single_round_of_unknown_scatter_says_what_to_state(run, calibrate):
    """One round does not tell noise from a set-up that moved: the line says so, and the stated scatter settles it."""
    noisy = {"rounds": 1, "noise_arcsec": 0.8, "seed": 2}
    result, _ = calibrate(run(**noisy), status=1)
    assert "or state u_repeatability_arcsec" in " ".join(result.output.split())
    calibrate(run(**noisy, metadata=(*FULL, ("u_repeatability_arcsec", 0.8))))
