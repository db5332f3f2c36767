"""The verbs of the instrument as a user runs them, on an instrument behind a pseudo-terminal."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from pseudo_instrument import PseudoInstrument

from arcref.angle import COUNTS_PER_TURN
from arcref.command import main
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref.link.registers import REGISTERS
from arcref.rom_identity import identity_words
from arcref.rom_image import save_rom

POSITION = 3 * COUNTS_PER_TURN + COUNTS_PER_TURN // 4
FLAGS = int(Flag.CORRECTION_ACTIVE | Flag.ILLEGAL_STEP)


def rom_of(serial: str | None, seed: int = 0) -> CorrectionRom:
    line = np.random.default_rng(seed).integers(-300, 300, 4096).astype(np.int16)
    return CorrectionRom(line, np.zeros(512, np.int16), {"encoder_serial": serial, "expanded_uncertainty_arcsec": 0.31})


@pytest.fixture
def instrument():
    rom = rom_of("0042")
    values = {
        "snapshot_position": POSITION,
        "snapshot_raw": POSITION + 7,
        "snapshot_time": 4_000_000_000,
        "snapshot_flags": 0x100 | FLAGS,
        "flags": FLAGS,
        "rom_crc32": rom.crc32,
        "rom_state": 1,
    }
    with PseudoInstrument(values, identity=identity_words(rom).tolist()) as instrument:
        yield instrument


@pytest.fixture
def arcref(instrument):
    def run(verb, *arguments, port=None):
        return CliRunner().invoke(main, [verb, "--port", str(port or instrument.port), *map(str, arguments)])

    return run


def test_info_names_the_calibration_and_the_faults(arcref, tmp_path):
    result = arcref("info", "--json", tmp_path / "info.json")
    assert result.exit_code == 0, result.output
    for expected in ("800 M samples/s", "0042", "0.31 arcsec (k=2)", "good", "illegal step"):
        assert expected in result.output
    written = json.loads((tmp_path / "info.json").read_text())
    assert written["calibration"]["serial"] == "0042"
    assert written["sample_rate_hz"] == 8e8
    assert written["faults"] == ["illegal step"]


@pytest.mark.parametrize(
    ("form", "shown"),
    [("dms", "90° 00' 00.00\", turn 3"), ("deg", "90.0000000 deg, turn 3"), ("counts", f"{POSITION} counts")],
)
def test_read_shows_the_angle_in_each_format_and_the_fault(arcref, tmp_path, form, shown):
    result = arcref("read", "--format", form, "--json", tmp_path / "r.json")
    assert result.exit_code == 0
    assert result.stdout == shown + "\n"
    assert result.stderr == "fault: illegal step\n"
    assert json.loads((tmp_path / "r.json").read_text()) == {
        "angle_deg": 90.0,
        "position_counts": POSITION,
        "raw_position_counts": POSITION + 7,
        "turns": 3,
        "counts_per_turn": COUNTS_PER_TURN,
        "time_s": 5.0,
        "homed": True,
        "corrected": True,
        "faults": ["illegal step"],
    }


def test_read_says_what_the_angle_is_not(instrument, arcref):
    instrument.values["snapshot_flags"] = 0
    assert "not homed" in arcref("read").stderr
    instrument.values["snapshot_flags"] = 0x100
    assert arcref("read").stderr == "not corrected\n"


def test_watch_into_a_pipe_is_one_line_a_reading(arcref):
    result = arcref("watch", "--seconds", 0.35, "--format", "deg")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert len(lines) >= 2
    assert all(line == "5.000000 s  90.0000000 deg, turn 3  -  corrected  faults: illegal step" for line in lines)


def test_registers_are_listed_within_80_columns(arcref, tmp_path):
    result = arcref("registers", "--json", tmp_path / "all.json")
    assert result.exit_code == 0, result.output
    lines = result.stdout.splitlines()
    readable = [entry.name for entry in REGISTERS.registers if entry.access.value != "command"]
    assert len(lines) == 1 + len(readable)
    assert max(len(line.rstrip()) for line in lines) <= 80
    assert list(json.loads((tmp_path / "all.json").read_text())) == readable


def test_registers_are_written_and_read_by_name(instrument, arcref):
    result = arcref("registers", "strobe_delay=0xFA0", "strobe_control=4", "home=1", "magic")
    assert result.exit_code == 0, result.output
    assert instrument.written == [("strobe_delay", 4000), ("strobe_control", 4), ("home", 1)]
    assert "edge falling" in result.stdout
    assert "strobe_delay: From a strobe to its due sample." in result.stdout


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["strobe_delay=1", "strobe_dealy"], "there is no register 'strobe_dealy'; did you mean strobe_delay?"),
        (["strobe_delay=1", "compare_start=0x800000"], "compare_start is 8388608, it must lie in 0 .. 8388607"),
        (["strobe_delay=1", "strobe_delay=-1"], "strobe_delay is -1, it must lie in 0 .. 65535"),
        (["strobe_delay=1", "strobe_delay=fast"], "strobe_delay=fast: a whole number was expected behind the ="),
        (["strobe_delay=1", "magic=1"], "the register magic can only be read"),
        (["strobe_delay=1", "home"], "home is a command, it can only be written: home=1"),
        (["strobe_delay=1", "identity"], "identity is a memory of 512 words, a register was expected"),
    ],
)
def test_what_cannot_be_asked_is_told_in_a_sentence_before_anything_is_written(instrument, arcref, arguments, sentence):
    result = arcref("registers", *arguments)
    assert (result.exit_code, result.stderr) == (2, f"arcref: {sentence}\n")
    assert instrument.written == []


@pytest.mark.parametrize("verb", ["info", "read", "watch", "registers", "zero-return"])
def test_a_port_that_does_not_serve_is_told_in_a_sentence(arcref, tmp_path, verb):
    (tmp_path / "file").write_text("no port")
    for port, sentence in ((tmp_path / "none", "there is no such port"), (tmp_path / "file", "no serial port behind")):
        result = arcref(verb, port=port)
        assert result.exit_code == 2
        assert sentence in result.stderr
        assert result.stderr.count("\n") == 1
    assert (tmp_path / "file").read_text() == "no port"


def test_an_older_protocol_is_told_with_status_2(arcref, instrument):
    instrument.values["protocol"] = 0
    result = arcref("read")
    assert result.exit_code == 2
    assert "speaks protocol 0, older than this arcref's 1; build and flash its bitstream anew" in result.stderr


def test_a_speed_that_no_port_has_is_refused(arcref):
    result = arcref("read", "--baud", 2**40)
    assert result.exit_code == 2
    assert "Traceback" not in result.output


def loads(instrument, state_after, crc32_after):
    """What the gateware does when a trial is begun and finished."""

    def on_write(name, value):
        if name == "trial":
            instrument.model.loading = value == 1
            instrument.values |= {"rom_state": 3 if value == 1 else state_after, "rom_crc32": crc32_after}

    return on_write


def test_a_trial_is_loaded_and_verified(instrument, arcref, tmp_path):
    other = rom_of("0042", seed=1)
    save_rom(other, tmp_path / "x.rom.json")

    instrument.on_write = loads(instrument, 4 | 8, other.crc32)
    result = arcref("trial", tmp_path / "x.rom.json")
    assert result.exit_code == 0, result.output
    assert f"0x{other.crc32:08X} verified" in result.stdout
    table = [instrument.windows["line_table"][place] for place in range(4096)]
    assert np.array_equal(np.array(table, np.uint16).view(np.int16), other.line_table)
    assert [instrument.windows["identity"][place] for place in range(512)] == identity_words(other).tolist()


def test_a_trial_of_another_encoder_is_refused_unless_allowed(instrument, arcref, tmp_path):
    other = rom_of("0017", seed=1)
    save_rom(other, tmp_path / "x.rom.json")
    result = arcref("trial", tmp_path / "x.rom.json")
    assert result.exit_code == 2
    assert "belongs to another encoder: it was made for 0017, the instrument carries that of 0042" in result.stderr
    assert instrument.written == []
    instrument.on_write = loads(instrument, 4 | 8, other.crc32)
    assert arcref("trial", tmp_path / "x.rom.json", "--any-encoder").exit_code == 0


def test_a_trial_that_did_not_arrive_whole_fails_with_status_1(instrument, arcref, tmp_path):
    save_rom(rom_of("0042", seed=1), tmp_path / "x.rom.json")
    instrument.on_write = loads(instrument, 2, 0)
    result = arcref("trial", tmp_path / "x.rom.json")
    assert result.exit_code == 1
    assert "did not arrive whole" in result.stderr
