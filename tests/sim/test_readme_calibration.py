"""The README's chapter on calibration shows what its commands print and plot, and `make calibrate` runs them."""

import re
import shlex
from pathlib import Path

import pytest

from arcref_sim.readme_calibration import PICTURE, chapter_commands, error_picture, fill_outputs, run_commands

ROOT = Path(__file__).parents[2]
README = (ROOT / "README.md").read_text(encoding="utf-8")

NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


@pytest.fixture(scope="module")
def run():
    return run_commands(chapter_commands(README))


def test_the_chapter_has_the_three_commands():
    commands = chapter_commands(README)
    assert [words[:2] for words in commands[:2]] == [["simulate", "polygon"], ["calibrate", "polygon"]]
    assert commands[2][0] == "rom"


def test_the_outputs_are_those_of_the_commands(run):
    printed, _ = run
    for name in ("simulate-polygon", "calibrate-polygon"):
        assert f"<!-- output {name} -->\n    " in README
        assert printed[name]
    assert fill_outputs(README, printed) == README, "run `make manual`"


def test_the_picture_is_the_plot_of_the_report(run):
    """Numbers may differ by a third of a pixel: not every machine rounds alike."""
    picture, shown = error_picture(run[1]), (ROOT / PICTURE).read_text(encoding="utf-8")
    assert NUMBER.sub("#", picture) == NUMBER.sub("#", shown), "run `make manual`"
    numbers = [[float(number) for number in NUMBER.findall(text)] for text in (picture, shown)]
    assert numbers[0] == pytest.approx(numbers[1], abs=0.35), "run `make manual`"
    assert f"]({PICTURE.as_posix()})" in README


def test_make_calibrate_runs_the_same_commands():
    recipe = re.search(r"^calibrate:.*\n((?:\t.*\n)+)", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)[
        1
    ]
    lines = [line.strip().lstrip("@") for line in recipe.replace("$(BUILD)", "build").splitlines()]
    commands = [shlex.split(line)[1:] for line in lines if line.startswith("$(BIN)/arcref ")]
    assert commands == chapter_commands(README)
