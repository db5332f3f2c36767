"""`make bitstream`, `patch` and `flash` call the command with the board and the ROM that were named."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.fixture
def make(tmp_path):
    """`make` in a copy of the front door, telling what it would do."""
    if shutil.which("make") is None:
        pytest.skip("there is no make")
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "requirements").mkdir()
    (tmp_path / "requirements" / "all.txt").touch()
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / ".ready").touch()
    (tmp_path / "examples").mkdir()

    # The tests themselves are run by make: what it tells its children must not reach this one.
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}

    def run(*arguments):
        command = ["make", "-n", *arguments]
        return subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)

    return run


@pytest.mark.parametrize(("target", "verb"), [("bitstream", "build"), ("patch", "patch"), ("flash", "flash")])
def test_a_target_names_board_and_rom(target, verb, make, tmp_path):
    mine = tmp_path / "mine.rom.json"
    mine.write_text("{}")
    # The published run is newer than the user's image; the image is nevertheless not made anew.
    (tmp_path / "examples" / "polygon_before_correction.csv").touch()
    done = make(target, "BOARD=hx8k", "ROM=mine.rom.json")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == [f".venv/bin/arcref {verb} --board hx8k --rom mine.rom.json"]


def test_a_rom_that_is_not_there_is_told_and_not_made(make):
    done = make("patch", "ROM=nowhere.rom.json")
    assert done.returncode == 2
    assert "nowhere.rom.json" in done.stderr
    assert "arcref" not in done.stdout
