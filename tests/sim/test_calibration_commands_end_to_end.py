"""The commands one after the other, as a person uses them: simulate, calibrate, rom, and then the truth."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner
from simulated_calibration import NAMED, corrected_errors_arcsec, rms

from arcref.command import main
from arcref.rom_image import load_rom
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder
from arcref_sim.metrology.operator_mistakes import MISTAKES


@pytest.fixture
def arcref(tmp_path, monkeypatch):
    """Runs the command in a folder of its own: `arcref("simulate", "polygon", ...)` gives click's result."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        return CliRunner().invoke(main, [str(word) for word in words])

    return run


@pytest.fixture
def calibrated(arcref, tmp_path):
    """Runs the three commands: `calibrated("polygon", [simulate options], [calibrate options])`."""

    def run(kind, simulate=(), calibrate=()):
        for words in (
            ["simulate", kind, "-o", "run.csv", *simulate],
            ["calibrate", kind, "run.csv", "-o", "cal.json", *calibrate],
            ["rom", "cal.json", "-o", "x.rom.json"],
        ):
            result = arcref(*words)
            assert result.exit_code == 0, result.output
        return json.loads((tmp_path / "run.truth.json").read_text()), json.loads((tmp_path / "cal.json").read_text())

    return run


def encoder_of(truth):
    """The encoder again, from what the truth file tells of it."""
    terms = truth["encoder"]["harmonics"]
    return KnownEncoder(tuple(Harmonic(**term) for term in terms))


def about_mean(values):
    return np.asarray(values) - np.mean(values)


@pytest.mark.parametrize("kind", ["polygon", "closure"])
def test_a_turn_comes_out_as_it_is(kind, calibrated, tmp_path):
    truth, calibration = calibrated(kind, ["--seed", 3])
    encoder, curve = encoder_of(truth), calibration["curve"]
    off = about_mean(np.array(curve["error_arcsec"]) - encoder.error_arcsec(curve["angle_deg"]))
    assert np.mean(np.abs(off) <= 2 * np.array(curve["u_arcsec"])) >= 0.8, "24 faces, 95 % of them expected"
    assert rms(off) < 0.15
    error = corrected_errors_arcsec(load_rom(tmp_path / "x.rom.json"), encoder)
    assert rms(error) < 0.15
    expanded = calibration["results"]["expanded_uncertainty_arcsec"]
    assert np.mean(np.abs(error) <= expanded) > 0.9
    assert rms(error) > expanded / 4, "no more is stated than there is"


def test_a_tilted_polygon_comes_out_as_it_is(calibrated, tmp_path):
    options = ["--tilt", 300, "--tilt-azimuth", 70, "--roll", 5, "--backward", "--rounds", 2, "--sign=-1"]
    truth, calibration = calibrated("polygon", options)
    tilt = calibration["results"]["tilt"]
    assert tilt["psi_arcsec"] == pytest.approx(300, abs=4 * tilt["u_psi_arcsec"])
    assert tilt["omega_deg"] == pytest.approx(70, abs=4 * tilt["u_omega_deg"])
    assert rms(corrected_errors_arcsec(load_rom(tmp_path / "x.rom.json"), encoder_of(truth))) < 0.15


def test_face_deviations_come_out_of_a_closure_run(calibrated):
    truth, calibration = calibrated("closure", ["--missing", 30])
    found = about_mean(calibration["results"]["face_deviation_arcsec"])
    assert rms(found - about_mean(truth["polygon"]["face_deviation_arcsec"])) < 0.04


def test_five_settings_say_what_they_lost(calibrated, arcref):
    """Settings at multiples of 90 deg cannot tell orders 4, 8 and 12 of the encoder from those of the polygon."""
    truth, calibration = calibrated("closure", ["--settings", 5, "--setting-step", 90])
    printed = arcref("calibrate", "closure", "run.csv", "-o", "cal.json").stdout
    assert re.search(r"orders lost +4, 8, 12", printed)
    curve = calibration["curve"]
    off = about_mean(np.array(curve["error_arcsec"]) - encoder_of(truth).error_arcsec(curve["angle_deg"]))
    assert rms(off) > 0.2, "orders 4 and 8 of the encoder are not found"
    assert np.all(np.abs(off) <= 2 * np.array(curve["u_arcsec"])), "and the statement knows of it"


def test_an_error_within_the_line_shows_as_a_slow_one_and_is_stated(calibrated, tmp_path):
    """Order 4096 looks like order 8 to 24 faces and is burnt into the ROM: the stated amplitude makes it known."""
    options = ["--harmonic", "1:1:0", "--line-harmonic", "1:0.5:35", "--setting-scatter", 1]
    truth, calibration = calibrated("polygon", options)
    spectrum = np.abs(np.fft.rfft(calibration["curve"]["error_arcsec"])) / 12
    assert spectrum[8] == pytest.approx(0.5, abs=0.15)
    error = corrected_errors_arcsec(load_rom(tmp_path / "x.rom.json"), encoder_of(truth))
    assert rms(error) > 0.4, "the reading's own and the false term"
    assert np.mean(np.abs(error) <= calibration["results"]["expanded_uncertainty_arcsec"]) > 0.9


def test_the_return_error_is_that_of_the_encoder(calibrated):
    options = ["--backward", "--hysteresis", 1.5, "--hysteresis-variation", 0.5, "--rounds", 8]
    truth, calibration = calibrated("polygon", options)
    found = np.array(calibration["results"]["return_error_arcsec"])
    true = -(1.5 + 0.5 * np.sin(np.radians(calibration["curve"]["angle_deg"])))
    assert truth["encoder"]["hysteresis_arcsec"] == 1.5
    assert np.abs(found - true).max() < 4 * np.sqrt(2 * (0.2**2 + 0.045**2) / 8)


def test_a_round_that_drifts_does_not_close_and_fails(arcref, tmp_path):
    assert arcref("simulate", "polygon", "-o", "run.csv", "--drift", 4).exit_code == 0
    result = arcref("calibrate", "polygon", "run.csv", "-o", "cal.json")
    assert result.exit_code == 1
    assert "FAILED" in result.stdout
    assert (tmp_path / "cal.json").exists()


def test_an_arc_comes_out_as_it_is(calibrated, tmp_path):
    options = ["--harmonic", "2:4:20", "--rounds", 3, "--start", 100]
    truth, calibration = calibrated("theodolite", options)
    curve, results = calibration["curve"], calibration["results"]
    assert min(curve["angle_deg"]) == pytest.approx(100, abs=0.01)
    assert max(curve["angle_deg"]) == pytest.approx(140, abs=0.01)
    off = about_mean(np.array(curve["error_arcsec"]) - encoder_of(truth).error_arcsec(curve["angle_deg"]))
    assert np.mean(np.abs(off) <= 2 * np.array(curve["u_arcsec"])) > 0.88
    for name, true in (("alpha", 6.7348), ("delta", 129.3174), ("omega", -1.6617)):
        assert results[f"{name}_deg"] == pytest.approx(true, abs=4 * results[f"u_{name}_deg"])
    # Outside the arc the table is 0; inside it is the error.
    table = load_rom(tmp_path / "x.rom.json").line_table
    line_deg = (np.arange(4096) + 0.5) * 360 / 4096
    assert not table[(line_deg < 99.9) | (line_deg > 140.1)].any()
    assert table[(line_deg > 101) & (line_deg < 139)].any()


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_refused_in_one_line_that_names_it(mistake, arcref, tmp_path):
    faces_rounds = ["--faces", 36, "--rounds", 1]
    assert arcref("simulate", "polygon", "-o", "run.csv", "--mistake", mistake, *faces_rounds).exit_code == 0
    result = arcref("calibrate", "polygon", "run.csv", "-o", "cal.json", "--report", "report.html")
    assert result.exit_code == 2, result.output
    assert result.stderr.count("\n") == 1
    assert result.stderr.startswith("arcref: run.csv, row ")
    assert re.search(NAMED[mistake], result.stderr)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["run.csv", "run.truth.json"]


@pytest.mark.parametrize("faces", [7, 8, 12, 17, 23, 24, 36, 72])
def test_a_clean_run_passes_without_alarm(faces, arcref):
    assert arcref("simulate", "polygon", "-o", "run.csv", "--faces", faces, "--tilt", 60).exit_code == 0
    result = arcref("calibrate", "polygon", "run.csv", "-o", "cal.json")
    assert (result.exit_code, result.stderr) == (0, ""), result.output
    assert "FAILED" not in result.stdout
    assert "Not in the budget" not in result.stdout
