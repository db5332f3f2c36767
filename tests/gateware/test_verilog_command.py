"""`arcref verilog` writes what others instantiate, or one clear line and nothing."""

import json
import re

import numpy as np
import pytest
from click.testing import CliRunner

from arcref.command import main
from arcref.correction_rom import CorrectionRom
from arcref.rom_image import save_rom
from arcref_gateware.core_ports import CORE_PORTS


@pytest.fixture
def rom_path(tmp_path):
    path = tmp_path / "x.rom.json"
    line = np.arange(4096) % 97 - 48
    save_rom(CorrectionRom(line.astype(np.int16)), path)
    return path


def run(*arguments):
    return CliRunner().invoke(main, ["verilog", *map(str, arguments)])


def ports_of(text: str) -> dict[str, tuple[str, int]]:
    """Direction and width of the ports that the module arcref_core declares."""
    module = re.search(r"^module arcref_core\(.*?^endmodule", text, re.DOTALL | re.MULTILINE)[0]
    named = re.search(r"module arcref_core\((.*?)\);", module, re.DOTALL)[1].replace("\n", " ").split(",")
    declared = re.findall(r"^  (input|output) (?:signed )?(?:\[(\d+):0\] )?(\w+);", module, re.MULTILINE)
    ports = {name: (direction, int(high or 0) + 1) for direction, high, name in declared}
    assert sorted(ports) == sorted(name.strip() for name in named)
    return ports


@pytest.mark.parametrize("samples", [1, 2, 4])
def test_the_module_has_exactly_the_promised_ports(samples, rom_path, tmp_path):
    result = run("--samples", samples, "--rom", rom_path, "-o", tmp_path / "core.v")
    assert result.exit_code == 0, result.output
    ports = ports_of((tmp_path / "core.v").read_text())
    assert ports == {port.name: (port.direction, port.bits(samples)) for port in CORE_PORTS}
    description = json.loads((tmp_path / "core.json").read_text())
    assert description["ports"] == {name: width for name, (_, width) in ports.items()}
    assert description["samples_per_word"] == samples
    assert description["latency_cycles"] <= 24


def test_the_tables_of_the_image_stand_in_the_file(rom_path, tmp_path):
    assert run("--rom", rom_path, "-o", tmp_path / "core.v").exit_code == 0
    words = re.findall(r"\[(\d+)\] = 16'h([0-9a-f]{4});", (tmp_path / "core.v").read_text())
    line = np.arange(4096) % 97 - 48
    for place in (0, 1, 96, 4095):
        assert (str(place), f"{line[place] & 0xFFFF:04x}") in words


def test_the_strobe_delay_is_the_one_asked_for(rom_path, tmp_path):
    texts = []
    for delay in (0, 4000):
        assert run("--rom", rom_path, "-o", tmp_path / "core.v", "--strobe-delay", delay).exit_code == 0
        assert json.loads((tmp_path / "core.json").read_text())["strobe_delay_samples"] == delay
        texts.append((tmp_path / "core.v").read_text())
    assert texts[0] != texts[1]


def test_the_same_image_gives_the_same_bytes(rom_path, tmp_path):
    for name in ("one.v", "two.v"):
        assert run("--rom", rom_path, "-o", tmp_path / name).exit_code == 0
    assert (tmp_path / "one.v").read_bytes() == (tmp_path / "two.v").read_bytes()


def corrupt(rom_path, **changes):
    rom_path.write_text(json.dumps(json.loads(rom_path.read_text()) | changes))


@pytest.mark.parametrize(
    ("changes", "complaint"),
    [
        ({"format": "arcref-calibration"}, "format"),
        ({"version": 2}, "version"),
        ({"line_table": [0] * 4095}, "4096"),
        ({"subdivision_table": [0] * 511 + [40000]}, "40000"),
        ({"crc32": 1}, "crc32"),
    ],
)
def test_a_bad_image_gives_one_line_and_no_file(changes, complaint, rom_path, tmp_path):
    corrupt(rom_path, **changes)
    result = run("--rom", rom_path, "-o", tmp_path / "core.v")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert str(rom_path) in result.stderr
    assert complaint in result.stderr
    assert not list(tmp_path.glob("core*"))


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["-o", "core.txt"], "must end in .v"),
        (["-o", "core.v", "--strobe-delay", "65536"], "0<=x<=65535"),
        (["-o", "core.v", "--samples", "3"], "'3' is not one of"),
        (["-o", "core.v", "--gate", "12"], "'12' is not one of"),
        ([], "Missing option '-o'"),
    ],
)
def test_bad_use_gives_a_line_and_no_file(arguments, complaint, rom_path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run("--rom", rom_path, *arguments)
    assert result.exit_code == 2
    assert complaint in result.stderr
    assert "Traceback" not in result.output
    assert not list(tmp_path.glob("core*"))


def test_a_missing_image_gives_one_line(tmp_path):
    result = run("--rom", tmp_path / "none.rom.json", "-o", tmp_path / "core.v")
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert "none.rom.json" in result.stderr
