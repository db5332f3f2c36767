"""Each board is built in earnest, once, and its timing report, its tables and its records are looked at.

All boards but the smallest are the long part of the suite, `make test-boards`; `make test` leaves it out.
"""

import json
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from random_roms import random_rom

from arcref.rom_image import load_rom, save_rom
from arcref_gateware.boards.bitstream_tables import compare_tables, unpack
from arcref_gateware.boards.board_file import load_board
from arcref_gateware.boards.build_record import read_built
from arcref_gateware.table_contents import rom_contents

HERE = Path(__file__).parent
CONSTRAINTS = HERE.parents[2] / "constraints"

MUST_REACH_HZ = {
    "ulx3s": 160e6,
    "hx8k": 168e6,
    "icebreaker": 84e6,
    "ecpix5": None,
    "encoder_board": None,
    str(HERE / "encoder_board_ice40.toml"): None,
}
"""Boards, and the word clock that each must reach after routing; None where only its own constraint counts."""

SMALLEST = "icebreaker"
"""The board that every run of the suite builds, and the long part twice."""

BOARDS = [
    pytest.param(board, id=Path(board).stem, marks=() if board == SMALLEST else pytest.mark.long)
    for board in MUST_REACH_HZ
]


def arcref(folder: Path, *arguments) -> subprocess.CompletedProcess:
    """The command, as a user calls it."""
    command = [sys.executable, "-m", "arcref.command", *map(str, arguments)]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Where everything is built, with two ROM images."""
    folder = tmp_path_factory.mktemp("boards")
    rng = np.random.default_rng(23)
    for name in ("one", "two"):
        save_rom(random_rom(rng, name), folder / f"{name}.rom.json")
    return folder


@pytest.fixture(scope="module")
def build(folder):
    """Builds a board once: `build(board)` gives the path of its bitstream."""

    @cache
    def built(board: str, build_folder: str = "build") -> Path:
        options = ["--constraints", CONSTRAINTS, "--build-folder", build_folder]
        done = arcref(folder, "build", "--board", board, "--rom", "one.rom.json", *options)
        assert done.returncode == 0, done.stderr
        (path,) = (folder / build_folder / Path(board).stem).glob("arcref.bi[tn]")
        return path

    return built


@pytest.mark.long
@pytest.mark.parametrize("board", ["ulx3s", "hx8k", "icebreaker"])
def test_the_timing_holds_with_the_test_generator_too(board, folder):
    options = ["--constraints", CONSTRAINTS, "--build-folder", "self_test", "--self-test", 10]
    done = arcref(folder, "build", "--board", board, "--rom", "one.rom.json", *options)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("board", BOARDS)
def test_the_timing_of_the_complete_design_holds(board, build):
    record = json.loads(build(board).with_name("build.json").read_text())
    assert record["clocks"]
    for clock in record["clocks"]:
        assert clock["reached_hz"] >= clock["constraint_hz"]
        assert clock["constraint_hz"] != pytest.approx(11.137e6, rel=1e-3)
    assert record["word_clock_reached_hz"] >= record["word_clock_hz"] * (1 - 1e-4)
    if MUST_REACH_HZ[board] is not None:
        assert record["word_clock_reached_hz"] >= MUST_REACH_HZ[board]
        assert record["word_clock_hz"] >= MUST_REACH_HZ[board]
    log = build(board).with_name("place_and_route.log").read_text()
    assert "ignoring" not in log
    assert "PASS at 11.14" not in log
    # The oscillator is the only clock that may be a 12 MHz one.
    if record["oscillator_hz"] != 12e6:
        assert "at 12.00 MHz" not in log
    assert record["samples_per_s"] == pytest.approx(record["samples_per_word"] * record["word_clock_reached_hz"])
    assert record["highest_speed_1_samples_per_count_rps"] == pytest.approx(record["samples_per_s"] / 2**23)
    linked = load_board(board, CONSTRAINTS)
    assert record["has_link"] == linked.has_link
    assert record["baud"] == (linked.baud if linked.has_link else None)
    assert 0 < record["cells"] < record["cells_available"]
    assert record["block_rams"] >= (6 if record["family"] == "ecp5" else 20)
    assert record["tools"]


@pytest.mark.parametrize("board", BOARDS)
def test_the_tables_are_the_roms_and_can_be_patched(board, build, folder):
    built = read_built(build(board))
    one, two = load_rom(folder / "one.rom.json"), load_rom(folder / "two.rom.json")
    assert built.rom_crc32 == one.crc32
    compare_tables(unpack(built.path.read_bytes(), built.layout.family), built.layout.unpacked, rom_contents(one))

    copy = folder / f"copy_of_{built.board}{built.path.suffix}"
    shutil.copy(built.path, copy)
    shutil.copy(built.path.with_name("build.json"), copy.with_suffix(".json"))
    done = arcref(folder, "patch", copy, "--rom", "two.rom.json")
    assert done.returncode == 0, done.stderr
    compare_tables(unpack(copy.read_bytes(), built.layout.family), built.layout.unpacked, rom_contents(two))
    assert arcref(folder, "patch", copy, "--rom", "one.rom.json").returncode == 0
    assert copy.read_bytes() == built.path.read_bytes()


@pytest.mark.long
def test_the_same_inputs_give_the_same_bytes(build):
    one, two = build(SMALLEST), build(SMALLEST, "again")
    for name in (one.name, "build.json"):
        assert one.with_name(name).read_bytes() == two.with_name(name).read_bytes()
