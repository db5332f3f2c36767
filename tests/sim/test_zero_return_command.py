"""`arcref simulate zero-return`: PASS where samples suffice, an honest FAIL where not, one line for bad input."""

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from arcref.command import main

CURVE = Path(__file__).parents[2] / "examples" / "polygon_before_correction.csv"


@pytest.fixture(scope="session")
def rom_path(tmp_path_factory):
    path = tmp_path_factory.mktemp("rom") / "published.rom.json"
    assert CliRunner().invoke(main, ["rom", str(CURVE), "-o", str(path)]).exit_code == 0
    return path


def run(rom_path, *arguments):
    words = ["simulate", "zero-return", "--rom", rom_path, "--curve", CURVE, *arguments]
    return CliRunner().invoke(main, [str(word) for word in words])


@pytest.mark.parametrize(("samples", "speed"), [(1, 10), (2, 10), (4, 10), (4, 63.48)])
def test_every_count_is_accounted_for_where_samples_suffice(samples, speed, rom_path, tmp_path):
    files = {"--json": tmp_path / "figures.json", "--page": tmp_path / "page.html"}
    options = [word for pair in files.items() for word in pair]
    result = run(rom_path, "--samples", samples, "--speed", speed, "--revolutions", 1, *options)
    assert result.exit_code == 0, result.output
    assert result.stdout.rstrip().endswith("PASS")
    figures = json.loads(files["--json"].read_text())
    assert figures["passed"]
    assert all(figures["checks"].values())
    marks = [(mark["turn"], mark["direction"], mark["closure_error_counts"]) for mark in figures["closure"]]
    assert marks == [(0, 1, 0), (1, 1, 0), (1, -1, 0), (0, -1, 0)]
    assert figures["counts_per_turn"] == [1 << 23, 1 << 23]
    assert figures["zero_drift_counts"] == figures["lost_counts"] == figures["illegal_steps"] == 0
    assert figures["shortest_edge_spacing_samples"] == int(figures["samples_per_count"])
    assert figures["counts"] > 2 * (1 << 23)
    assert figures["error_after_rms_arcsec"] < 0.1 < 1 < figures["error_before_rms_arcsec"]
    page = files["--page"].read_text()
    assert page.count("<svg") == 3
    assert "PASS" in page
    assert "http://" not in page.replace("http://www.w3.org", "").replace("http://purl.org", "").replace(
        "http://creativecommons.org", ""
    )


def test_too_fast_for_the_samples_fails_and_says_so(rom_path, tmp_path):
    figures = tmp_path / "figures.json"
    result = run(rom_path, "--samples", 1, "--speed", 30, "--revolutions", 1, "--json", figures)
    assert result.exit_code == 1
    assert result.stdout.rstrip().endswith("FAIL")
    assert "FAILED: no illegal step" in result.stdout
    told = json.loads(figures.read_text())
    assert told["illegal_steps"] > 0
    assert told["checks"]["core and golden model agree at every word"]


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--speed", "0"], "--speed is 0 r/s, it must lie in 0.1 .. 500"),
        (["--speed", "nan"], "--speed is nan r/s"),
        (["--rom", "none.rom.json"], "none.rom.json"),
        (["--curve", "none.csv"], "none.csv"),
    ],
)
def test_bad_input_gives_one_line_and_no_file(arguments, complaint, rom_path, tmp_path):
    result = run(rom_path, "--page", tmp_path / "page.html", *arguments)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert complaint in result.stderr
    assert not (tmp_path / "page.html").exists()
