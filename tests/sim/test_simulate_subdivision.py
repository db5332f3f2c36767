"""`arcref simulate subdivision`: four kinds of run of one encoder, their truth, and one line for bad use."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from arcref.command import main
from arcref.run_file import read_run_file
from arcref_sim.metrology.simulated_subdivision import EvenMotion

COLUMNS = {
    "samples": ("time_s", "sine_v", "cosine_v"),
    "edges": ("count", "time_s"),
    "scan": ("count", "autocollimator_x_arcsec"),
    "polygon": ("position_deg", "face_deviation_arcsec", "autocollimator_x_arcsec", "autocollimator_y_arcsec")
    + ("round", "direction"),
}


@pytest.fixture
def simulate(tmp_path):
    """`simulate("edges", "--seed", 3)` gives click's result; the run is at `tmp_path / "run.csv"`."""

    def run(kind, *options):
        words = ["simulate", "subdivision", "--run", kind, "-o", tmp_path / "run.csv", *options]
        return CliRunner().invoke(main, [str(word) for word in words])

    return run


@pytest.mark.parametrize("kind", COLUMNS)
def test_each_kind_has_its_columns_and_the_same_encoder(kind, simulate, tmp_path):
    result = simulate(kind, "--seed", 3, "--turns", 0.01)
    assert result.exit_code == 0, result.output
    assert tuple(read_run_file(tmp_path / "run.csv", COLUMNS[kind]).columns) == COLUMNS[kind]
    truth = json.loads((tmp_path / "run.truth.json").read_text())
    assert (truth["kind"], truth["run"]) == ("subdivision", kind)
    encoder = truth["encoder"]
    assert np.ptp(encoder["error_within_line_arcsec"]) == pytest.approx(1.0, abs=0.06)
    assert encoder["sine"]["offset_v"] == pytest.approx(0.0035)
    assert set(encoder["cosine"]["harmonics"]) == {"1", "3", "5"}
    first = (tmp_path / "run.csv").read_bytes()
    assert simulate("samples", "--seed", 3).exit_code == 0
    assert json.loads((tmp_path / "run.truth.json").read_text())["encoder"] == encoder
    assert simulate(kind, "--seed", 3, "--turns", 0.01).exit_code == 0
    assert (tmp_path / "run.csv").read_bytes() == first
    assert simulate(kind, "--seed", 3, "--turns", 0.01, "--noise-seed", 4).exit_code == 0
    assert (tmp_path / "run.csv").read_bytes() != first


@pytest.mark.parametrize("speed", [1.0, -0.5])
def test_edges_come_where_the_shaft_is_then(speed, simulate, tmp_path):
    """Without signals' faults, ripple, delay and jitter the count is speed times time."""
    plain = ("--offset-sine", 0, "--offset-cosine", 0, "--gain", 0, "--quadrature", 0, "--third", 0, "--fifth", 0)
    disc = ("--eccentricity", 0, "--ellipse", 0, "--line-noise", 0, "--graduation", "2:0:0")
    run = ("--speed", speed, "--ripple", "8:0:0", "--delay", 0, "--jitter", 0, "--turns", 0.01, "--clock", 0)
    assert simulate("edges", *plain, *disc, *run).exit_code == 0
    edges = read_run_file(tmp_path / "run.csv", COLUMNS["edges"])
    count, time = edges["count"], edges["time_s"]
    assert np.abs((count - count[0]) - (time - time[0]) * speed * 2**23).max() < 1e-3


def test_motion_and_its_inverse_agree():
    motion = EvenMotion(-2.0, ((8.0, 0.05, 30.0), (4096.0, 0.02, 0.0)))
    turns = -np.linspace(0, 3, 5001)
    assert np.abs(motion.true_turns(motion.time_s(turns)) - turns).max() < 1e-12
    assert motion.true_turns(0.0) == 0.0


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("edges", "--speed", 0), "--speed is 0 r/s"),
        (("edges", "--ripple", "8:50:0"), "--ripple is '50', a number in 0 .. 30 %"),
        (("samples", "--eccentricity", 36.4), "the disc is too eccentric"),
        (("scan", "--lines", 0.5), "--lines is '0.5'"),
        (("scan", "--third", "much"), "--third is 'much'"),
    ],
)
def test_bad_use_gets_one_line_and_no_file(words, expected, simulate, tmp_path):
    result = simulate(*words)
    assert result.exit_code == 2
    assert expected in result.output
    assert not list(tmp_path.iterdir())
