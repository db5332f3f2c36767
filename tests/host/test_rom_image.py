import json

import click
import numpy as np
import pytest

from arcref.command import HOST_VERBS
from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.rom_identity import identity_words
from arcref.rom_image import load_rom, save_rom

ROM = CorrectionRom(np.arange(-2048, 2048), np.arange(-256, 256), {"encoder_serial": "7", "note": "naïve"})


@click.command()
@click.argument("path")
@click.argument("output")
def copy_rom(path, output):
    """Load an image and save it: a verb as short as one can be."""
    save_rom(load_rom(path), output)


@pytest.fixture
def image(tmp_path):
    """A good image as a dictionary, to be spoilt."""
    save_rom(ROM, tmp_path / "good.rom.json")
    return json.loads((tmp_path / "good.rom.json").read_text())


def test_round_trip(tmp_path):
    paths = save_rom(ROM, tmp_path / "x.rom.json")
    assert [path.name for path in paths] == ["x.rom.json", "x.line.mem", "x.subdivision.mem", "x.identity.mem"]
    loaded = load_rom(paths[0])
    assert loaded == ROM
    assert loaded.line_table.dtype == np.int16
    assert sorted(tmp_path.iterdir()) == sorted(paths), "nothing is left beside the files"


def test_keys(image):
    assert list(image)[:5] == ["format", "version", "counts_per_turn", "fraction_bits", "crc32"]
    assert (image["format"], image["version"], image["counts_per_turn"]) == ("arcref-rom", 1, 8388608)
    assert image["fraction_bits"] == 4
    assert image["crc32"] == ROM.crc32
    assert image["line_table"] == list(range(-2048, 2048))
    assert image["subdivision_table"] == list(range(-256, 256))


def test_same_rom_same_bytes(tmp_path):
    first, second = (save_rom(ROM, tmp_path / name / "x.rom.json") for name in _folders(tmp_path))
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]


def _folders(tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
    return "ab"


def test_memory_files(tmp_path):
    save_rom(ROM, tmp_path / "x.rom.json")
    for name, expected in (
        ("line", ROM.line_table.view(np.uint16)),
        ("subdivision", ROM.subdivision_table.view(np.uint16)),
        ("identity", identity_words(ROM)),
    ):
        lines = (tmp_path / f"x.{name}.mem").read_text().splitlines()
        assert {len(line) for line in lines} == {4}
        assert [int(line, 16) for line in lines] == expected.tolist()


def spoil(**changes):
    return lambda image: json.dumps(image | changes)


def without(key):
    return lambda image: json.dumps({name: value for name, value in image.items() if name != key})


def entry(key, index, value):
    def change(image):
        image[key][index] = value
        return json.dumps(image)

    return change


BAD = {
    "empty": (lambda image: "", ": the file is empty"),
    "not UTF-8": (lambda image: b'{\n"a": "\xff"}', ", row 2: not UTF-8 text: byte 0xFF at offset 8"),
    "not JSON": (lambda image: "line,subdivision\n1,2\n", ", row 1: not JSON: Expecting value"),
    "half a file": (lambda image: json.dumps(image)[:-9], ", row 1: not JSON: Expecting ',' delimiter"),
    "a list": (lambda image: "[1, 2]", ": a JSON object was expected, with keys and values in braces"),
    "no format": (without("format"), ", column format: is missing, 'arcref-rom' was expected"),
    "another format": (
        spoil(format="arcref-calibration"),
        ", column format: is \"arcref-calibration\", 'arcref-rom' was expected",
    ),
    "version 2": (spoil(version=2), ", column version: is 2, 1 was expected"),
    "version true": (spoil(version=True), ", column version: is true, 1 was expected"),
    "version as text": (spoil(version="1"), ', column version: is "1", 1 was expected'),
    "another encoder": (spoil(counts_per_turn=1 << 24), ", column counts_per_turn: is 16777216, 8388608 was expected"),
    "another fraction": (spoil(fraction_bits=5), ", column fraction_bits: is 5, 4 was expected"),
    "no line table": (without("line_table"), ", column line_table: is missing, a list of 4096 integers was expected"),
    "short line table": (spoil(line_table=[0] * 4095), ", column line_table: has 4095 entries, 4096 were expected"),
    "long subdivision table": (
        spoil(subdivision_table=[0] * 513),
        ", column subdivision_table: has 513 entries, 512 were expected",
    ),
    "a fraction": (
        entry("line_table", 17, 1.5),
        ", column line_table[17]: is 1.5, an integer in -32768 .. 32767 was expected",
    ),
    "NaN": (
        entry("subdivision_table", 3, float("nan")),
        ", column subdivision_table[3]: is NaN, an integer in -32768 .. 32767 was expected",
    ),
    "text": (
        entry("line_table", 0, "0"),
        ', column line_table[0]: is "0", an integer in -32768 .. 32767 was expected',
    ),
    "too large": (
        entry("line_table", 4095, 32768),
        ", column line_table[4095]: is 32768, an integer in -32768 .. 32767 was expected",
    ),
    "too small": (
        entry("subdivision_table", 511, -32769),
        ", column subdivision_table[511]: is -32769, an integer in -32768 .. 32767 was expected",
    ),
    "no provenance": (without("provenance"), ", column provenance: is missing, a JSON object was expected"),
    "no CRC": (without("crc32"), ", column crc32: is missing, an integer in 0 .. 4294967295 was expected"),
    "CRC as text": (
        spoil(crc32="0x0"),
        ', column crc32: is "0x0", an integer in 0 .. 4294967295 was expected',
    ),
    "wrong CRC": (
        spoil(crc32=0x12345678),
        f", column crc32: is 0x12345678, the tables give 0x{ROM.crc32:08X}: the file is damaged",
    ),
}


@pytest.mark.parametrize(("spoiler", "expected"), BAD.values(), ids=BAD.keys())
def test_a_bad_image_gives_one_line_and_no_file(tmp_path, monkeypatch, arcref, image, spoiler, expected):
    monkeypatch.setitem(HOST_VERBS, "copy-rom", f"{__name__}:copy_rom")
    path, output = tmp_path / "bad.rom.json", tmp_path / "out.rom.json"
    content = spoiler(image)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    before = sorted(tmp_path.iterdir())
    result = arcref("copy-rom", path, output)
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"arcref: {path}{expected}\n")
    assert sorted(tmp_path.iterdir()) == before


def test_a_changed_entry_is_found_by_the_crc(tmp_path, image):
    path = tmp_path / "bad.rom.json"
    path.write_text(entry("line_table", 100, 5)(image))
    with pytest.raises(InputError, match="column crc32: .*the file is damaged"):
        load_rom(path)


def test_brackets_without_end(tmp_path):
    path = tmp_path / "bad.rom.json"
    path.write_text("[" * 200_000)
    with pytest.raises(InputError, match="JSON"):
        load_rom(path)


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        load_rom(tmp_path / "none.rom.json")
    with pytest.raises(InputError, match="is a folder"):
        load_rom(tmp_path)
