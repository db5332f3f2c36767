"""`arcref twin` as a user runs it."""

import os
import re
import select
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from click.testing import CliRunner
from twin_truth import wait_until, wait_until_homed

from arcref.command import main
from arcref.flags import Flag, describe_faults
from arcref.instrument.recorded_captures import read_capture_file
from arcref.rom_image import save_rom
from arcref_sim.twin.live_faults import NAMED_FAULTS
from arcref_sim.twin.twin_prompt import obey

PROJECT = Path(__file__).parents[3]
BUILDS = PROJECT / "build" / "verilated"


@pytest.fixture
def twin_process(rom, tmp_path):
    """Starts `arcref twin` with options: the process and the link to its port."""
    started = []
    save_rom(rom, tmp_path / "x.rom.json")

    def start(*options):
        link = tmp_path / "port"
        command = [sys.executable, "-m", "arcref.command", "twin", "--rom", str(tmp_path / "x.rom.json")]
        command += ["--link", str(link), "--build-folder", str(BUILDS), "--baud", "25000000", *options]
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
        process = subprocess.Popen(command, text=True, bufsize=1, **pipes)
        started.append(process)
        read_until(process, "link: ")
        return process, link

    yield start
    for process in started:
        if process.poll() is None:
            process.kill()
        process.wait()
        process.stdin.close()
        process.stdout.close()


def read_until(process, text: str, timeout_s: float = 240.0) -> str:
    """The lines up to the one with `text`."""
    lines, deadline = "", time.monotonic() + timeout_s
    while True:
        ready, _, _ = select.select([process.stdout], [], [], max(0.0, deadline - time.monotonic()))
        assert ready, f"{text!r} did not come; there was:\n{lines}"
        line = process.stdout.readline()
        assert line, f"it ended before {text!r}; there was:\n{lines}"
        lines += line
        if text in line:
            return lines


def arcref(*arguments) -> str:
    """What a verb prints."""
    done = subprocess.run(
        [sys.executable, "-m", "arcref.command", *map(str, arguments)], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_verb_of_the_host_runs_on_it_while_lines_are_typed(twin_process, tmp_path):
    process, link = twin_process("--speed", "10", "--strobe", "20000")
    assert os.readlink(link).startswith("/dev/")
    assert "correction ROM" in arcref("info", "--port", link)
    process.stdin.write("speed -3 1e4\nfault illegal 2\nstatus\nspi\nfault\nspeed fast\nreverse\n")
    out = read_until(process, "speed 3 r/s")
    for expected in (
        "speed -3 r/s, at 10000 r/s2",
        "fault illegal: A and B change in one sample",
        "times slower than real time",
        "strobes    ",
        "angle ",
        "fault NAME [N] expected:",
        "'fast' is no number; `speed RPS [RPS_PER_S]` was expected",
    ):
        assert expected in out
    arcref("capture", "--port", link, "-n", 200, "-o", tmp_path / "c.csv")
    assert sum(line[0].isdigit() for line in (tmp_path / "c.csv").read_text().splitlines()) == 200
    assert arcref("read", "--port", link, "--format", "counts").strip().endswith("counts")
    assert "illegal step" in arcref("info", "--port", link)
    process.stdin.write("quit\n")
    assert process.wait(30) == 0
    assert not os.path.lexists(link)
    assert "ended, " in process.stdout.read()


def test_it_ends_by_itself_and_takes_its_port_away(twin_process):
    process, link = twin_process("--seconds", "0.5", "--realtime", "--sleep", "0.1")
    assert process.wait(30) == 0
    assert not os.path.lexists(link)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_it_ends_on_ctrl_c_and_on_kill_and_takes_its_port_away(twin_process, number):
    process, link = twin_process("--speed", "-10")
    process.send_signal(number)
    assert process.wait(30) == 130
    assert not os.path.lexists(link)
    assert "Traceback" not in process.stdout.read()


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--speed", "500"], "--speed is 500, it must lie in -200 .. 200"),
        (["--jitter", "-1"], "--jitter is -1, it must lie in 0 .. 1000"),
        (["--baud", "90000000"], "--baud: 9e+07 baud needs a clock of 720 MHz"),
        (["--fault", "sneeze"], "fault NAME [N] expected"),
        (["--seed", "-1"], "-1 is not in the range x>=0"),
    ],
)
def test_bad_use_is_told_in_a_sentence(rom, tmp_path, options, sentence):
    save_rom(rom, tmp_path / "x.rom.json")
    fixed = ["twin", "--rom", str(tmp_path / "x.rom.json"), "--link", str(tmp_path / "port")]
    baud = [] if "--baud" in options else ["--baud", "25000000"]
    result = CliRunner().invoke(main, [*fixed, *baud, "--build-folder", str(BUILDS), *options])
    assert result.exit_code == 2
    assert sentence in result.output
    assert not (tmp_path / "port").exists()


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("fault drop 0", "drop takes a whole number in 1 .. 1000000, not 0"),
        ("fault drop", "pulses are dropped while the shaft turns; it stands"),
        ("fault drop 1.5", "1.5: a whole number was expected"),
        ("strobe 1e9", "1e+09 strobes/s: it must lie in 0 .. 2e+08"),
        ("burst 0", "a burst needs 1 strobe or more"),
        ("speed 1 -3", "the acceleration must be above 0"),
        ("speed nan", "'nan' is no number"),
        ("dance", "there is no 'dance'; `help` lists what there is"),
    ],
)
def test_a_line_that_cannot_be_obeyed_is_told_in_a_sentence(make_twin, line, sentence):
    with make_twin() as twin, pytest.raises(ValueError, match=re.escape(sentence)):
        obey(twin, line)


FLAG_OF_FAULT = {
    "drop": Flag.CLOSURE_ERROR,
    "extra": Flag.CLOSURE_ERROR,
    "slip": Flag.INDEX_FAULT,
    "illegal": Flag.ILLEGAL_STEP,
    "glitch": Flag.EDGE_SPACING_LIMIT,
    "noise": Flag.EDGE_SPACING_LIMIT,
    "index-missing": Flag.INDEX_FAULT,
    "index-extra": Flag.INDEX_FAULT,
    "index-stuck": Flag.INDEX_FAULT,
}


@pytest.mark.parametrize("name", NAMED_FAULTS)
def test_every_fault_is_seen_by_the_instrument(make_twin, name):
    with make_twin(speed_rps=20.0) as twin:
        wait_until_homed(twin)
        assert not describe_faults(twin.status().flags)
        twin.set_speed(-17.3)  # over the zero mark again
        for _ in range(5 if name == "glitch" else 1):  # one that meets an edge only moves it
            # A mark too many close to the true one would be a closure error.
            obey(twin, f"fault {name}" + (" 21000" if name == "index-extra" else ""))
        wait_until(lambda: twin.status().flags & FLAG_OF_FAULT[name])
        assert describe_faults(FLAG_OF_FAULT[name])[0] in obey(twin, "status")


def test_a_host_that_vanishes_in_the_middle_leaves_a_twin_that_serves_the_next_one(twin_process, tmp_path):
    _, link = twin_process("--speed", "10", "--strobe", "90000")
    command = [sys.executable, "-m", "arcref.command", "capture", "--port", str(link)]
    host = subprocess.Popen([*command, "-n", "100000", "-o", str(tmp_path / "first.csv")], stderr=subprocess.PIPE)
    wait_until(lambda: (tmp_path / "first.csv").exists() and (tmp_path / "first.csv").stat().st_size > 10_000)
    host.kill()
    host.communicate()
    arcref("capture", "--port", link, "-n", 300, "-o", tmp_path / "second.csv")
    for name in ("first.csv", "second.csv"):
        captures = read_capture_file(tmp_path / name).captures
        assert len(captures) >= 150
        assert not captures["lost_before"][1:].any()


def test_a_file_where_the_link_should_stand_is_left_alone(rom, tmp_path):
    save_rom(rom, tmp_path / "x.rom.json")
    (tmp_path / "port").write_text("mine")
    fixed = ["twin", "--rom", str(tmp_path / "x.rom.json"), "--link", str(tmp_path / "port"), "--baud", "25000000"]
    result = CliRunner().invoke(main, [*fixed, "--build-folder", str(BUILDS)])
    assert result.exit_code == 2
    assert "another file stands there" in result.output
    assert (tmp_path / "port").read_text() == "mine"
