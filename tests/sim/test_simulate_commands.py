"""`arcref simulate polygon|closure|theodolite`: run files as the project reads them, and one line for bad use."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arcref.command import main
from arcref.run_file import read_run_file
from arcref_sim.metrology.operator_mistakes import MISTAKES

EXAMPLES = Path(__file__).parents[2] / "examples"

POLYGON = ("face_deviation_arcsec", "autocollimator_x_arcsec", "autocollimator_y_arcsec", "round", "direction")
COLUMNS = {
    "polygon": ("position_deg", *POLYGON),
    "closure": ("setting", "face", "position_deg", "autocollimator_x_arcsec"),
    "theodolite": ("reading_deg", "azimuth_deg", "zenith_deg"),
}
READINGS = {"polygon": 100, "closure": 576, "theodolite": 41}


@pytest.fixture
def simulate(tmp_path):
    """Runs a verb: `simulate("polygon", "--faces", 8)` gives click's result; the run is at `tmp_path / "run.csv"`."""

    def run(verb, *options, output="run.csv"):
        words = ["simulate", verb, "-o", tmp_path / output, *options]
        return CliRunner().invoke(main, [str(word) for word in words])

    return run


def test_the_group_lists_its_verbs_with_their_help():
    shown = CliRunner().invoke(main, ["simulate", "--help"]).stdout
    for verb in ("polygon", "closure", "theodolite", "zero-return"):
        assert f"  {verb} " in shown
    assert "Write a closure run of known truth." in shown


def test_help_of_the_group_imports_none_of_its_verbs():
    code = "import sys, arcref_sim.simulate_command as c; c.simulate.main(['--help'], standalone_mode=False); "
    code += "bad = {'numpy', 'rich', 'amaranth', 'arcref_gateware', 'arcref_sim.metrology'} & set(sys.modules); "
    code += "sys.exit(f'imported {bad}' if bad else 0)"
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert result.returncode == 0, result.stderr


@pytest.mark.parametrize("verb", COLUMNS)
def test_the_run_file_is_as_the_design_has_it(verb, simulate, tmp_path):
    result = simulate(verb, "--seed", 7)
    assert result.exit_code == 0, result.output
    run = read_run_file(tmp_path / "run.csv", COLUMNS[verb])
    assert tuple(run.columns) == COLUMNS[verb]
    assert len(run.rows) == READINGS[verb]
    assert run.metadata["encoder_serial"] == "SIM-7"
    truth = json.loads((tmp_path / "run.truth.json").read_text())
    assert (truth["format"], truth["kind"], truth["seed"], truth["run_file"]) == (
        "arcref-simulated-truth",
        verb,
        7,
        "run.csv",
    )
    assert len(truth["encoder"]["error_arcsec"]) == 360
    assert len(truth["rows"]["true_deg"]) == READINGS[verb]
    assert sum(term["amplitude_arcsec"] for term in truth["encoder"]["harmonics"]) == pytest.approx(3.0)
    assert f"{READINGS[verb]} readings" in result.stdout


@pytest.mark.parametrize("verb", COLUMNS)
def test_the_same_seed_gives_the_same_bytes_and_another_seed_does_not(verb, simulate, tmp_path):
    contents = []
    for seed in (3, 3, 4):
        assert simulate(verb, "--seed", seed).exit_code == 0
        contents.append([(tmp_path / name).read_bytes() for name in ("run.csv", "run.truth.json")])
    assert contents[0] == contents[1]
    assert contents[0][0] != contents[2][0]


def test_an_option_of_one_part_leaves_the_others_alone(simulate, tmp_path):
    simulate("polygon", "--tilt", 0, output="level.csv")
    simulate("polygon", "--tilt", 300, "--no-y", "--counts", output="tilted.csv")
    level = read_run_file(tmp_path / "level.csv", ("position_deg",), POLYGON)
    tilted = read_run_file(tmp_path / "tilted.csv", ("count",), POLYGON)
    assert "autocollimator_y_arcsec" not in tilted.columns
    assert np.array_equal(level["face_deviation_arcsec"], tilted["face_deviation_arcsec"])
    assert np.abs(level["position_deg"] - tilted["count"] * 360 / 2**23).max() < 1e-8
    assert not np.array_equal(level["autocollimator_x_arcsec"], tilted["autocollimator_x_arcsec"])


def test_the_truth_tells_the_encoder_that_was_asked_for(simulate, tmp_path):
    options = ["--harmonic", "2:1.5:30", "--harmonic", "5:0.5:-10", "--line-harmonic", "1:0.2:0"]
    assert simulate("polygon", *options, "--truth", tmp_path / "known.json").exit_code == 0
    truth = json.loads((tmp_path / "known.json").read_text())
    terms = [(term["order"], term["amplitude_arcsec"], term["phase_deg"]) for term in truth["encoder"]["harmonics"]]
    assert terms == [(2, 1.5, 30), (5, 0.5, -10), (4096, 0.2, 0)]
    assert (
        read_run_file(tmp_path / "run.csv", ("position_deg",), POLYGON).metadata["interpolation_amplitude_arcsec"]
        == "0.2"
    )


def test_a_curve_file_is_the_encoder(simulate, tmp_path):
    curve = EXAMPLES / "polygon_before_correction.csv"
    assert simulate("polygon", "--curve", curve).exit_code == 0
    published = read_run_file(curve, ("position_deg", "error_arcsec"))["error_arcsec"][:24]
    error = np.array(json.loads((tmp_path / "run.truth.json").read_text())["encoder"]["error_arcsec"])
    assert error[::15] == pytest.approx(published, abs=1e-5)


def test_a_mistake_is_told_in_the_truth_and_not_in_the_run(simulate, tmp_path):
    assert simulate("polygon", "--mistake", "arcmin").exit_code == 0
    truth = json.loads((tmp_path / "run.truth.json").read_text())
    assert truth["mistake"] == {"name": "arcmin", "what": "x and y are in arc minutes"}
    written = (tmp_path / "run.csv").read_text()
    assert "mistake" not in written
    assert "in arc minutes" not in written


def test_a_roll_that_the_operator_does_not_know(simulate, tmp_path):
    assert simulate("polygon", "--tilt", 100, "--roll", 5, "--stated-roll", 2).exit_code == 0
    metadata = read_run_file(tmp_path / "run.csv", COLUMNS["polygon"]).metadata
    assert metadata["autocollimator_roll_arcmin"] == "2"
    assert metadata["u_autocollimator_roll_arcmin"] == "3"
    assert simulate("polygon", "--nothing-stated").exit_code == 0
    assert not any(key.startswith("u_") for key in read_run_file(tmp_path / "run.csv", COLUMNS["polygon"]).metadata)


def test_the_manual_names_every_mistake():
    page = (EXAMPLES.parent / "docs" / "simulated_runs.md").read_text(encoding="utf-8")
    assert set(re.findall(r"^\| `([a-z-]+)` \|", page, re.MULTILINE)) == set(MISTAKES)


@pytest.mark.parametrize(
    ("verb", "options", "complaint"),
    [
        ("polygon", ["--faces", "2"], "--faces is '2', a whole number in 3 .. 360 was expected"),
        ("polygon", ["--faces", "24.5"], "--faces is '24.5', a whole number in 3 .. 360 was expected"),
        ("polygon", ["--noise", "nan"], "--noise is 'nan', a number in 0 .. 10000 arcsec was expected"),
        ("polygon", ["--noise", "-1"], "--noise is '-1', a number in 0 .. 10000 arcsec was expected"),
        ("polygon", ["--noise", "a lot"], "--noise is 'a lot', a number"),
        ("polygon", ["--seed", "-1"], "--seed is '-1'"),
        ("polygon", ["--tilt", "1e9"], "--tilt is '1e9', a number in 0 .. 7200 arcsec was expected"),
        ("polygon", ["--harmonic", "3:2"], "--harmonic is '3:2', ORDER:ARCSEC:PHASE_DEG was expected"),
        ("polygon", ["--harmonic", "0:2:1"], "--harmonic is '0', a whole number in 1 .. 2048 cycles a turn"),
        ("polygon", ["--line-harmonic", "1:50:1"], "--line-harmonic is '50', a number in 0 .. 20 arcsec"),
        ("polygon", ["--missing", "99"], "--missing is 99, at most half of the 92 readings may be left out"),
        ("polygon", ["--mistake", "skip", "--faces", "4"], "--faces is 4, at least 6 were expected for a mistake"),
        (
            "polygon",
            ["--mistake", "certificate-order", "--no-certificate"],
            "--mistake certificate-order needs the certificate",
        ),
        ("polygon", ["--curve", "none.csv"], "none.csv"),
        ("closure", ["--settings", "1,2,2"], "--settings is '1,2,2', each number was expected once"),
        ("closure", ["--settings", "0"], "--settings is '0', a whole number in 1 .. 360 was expected"),
        ("closure", ["--settings", "1", "--missing", "13"], "--missing is 13, at most half of the 24 readings"),
        ("theodolite", ["--last", "-1"], "make an arc of -1 deg"),
        ("theodolite", ["--first", "-180", "--last", "180"], "make an arc of 360 deg"),
        ("theodolite", ["--step", "0"], "--step is '0', a number in 0.001 .. 120 deg was expected"),
        ("theodolite", ["--first", "-150", "--last", "150", "--step", "0.001"], "makes 300001 readings"),
        ("theodolite", ["--missing", "21"], "--missing is 21, at most half of the 41 readings"),
        ("theodolite", ["--alpha", "90"], "--alpha is '90', a number in 0 .. 45 deg was expected"),
    ],
)
def test_bad_use_gives_one_line_and_no_file(verb, options, complaint, simulate, tmp_path):
    result = simulate(verb, *options)
    assert result.exit_code == 2
    assert result.stderr.startswith("arcref: ")
    assert result.stderr.count("\n") == 1
    assert complaint in result.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("output", "options", "complaint"),
    [
        ("run.txt", [], "run.txt: the name of a run file must end in .csv"),
        ("none/run.csv", [], "its folder does not exist"),
        ("run.csv", ["--truth", "{folder}/run.csv"], "this name is given to two files of this run"),
        ("run.csv", ["--curve", "{folder}/run.csv"], "this name is given to two files of this run"),
    ],
)
def test_files_that_cannot_be_written_are_refused_before_the_work(output, options, complaint, simulate, tmp_path):
    result = simulate("polygon", *[option.format(folder=tmp_path) for option in options], output=output)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert complaint in result.stderr
    assert not list(tmp_path.iterdir())
