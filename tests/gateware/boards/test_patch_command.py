"""`arcref patch` puts another ROM into a bitstream and compares every word; what it refuses stays as it was."""

import json
from pathlib import Path

import numpy as np
from packed_tables import BUILT_BOARDS, unpack

from arcref.rom_image import load_rom
from arcref_gateware.boards.bitstream_tables import UNPACKED
from arcref_gateware.boards.build_record import read_built
from arcref_gateware.boards.table_layout import TableLayout, place_tables, read_tables
from arcref_gateware.table_contents import placeholder_contents, rom_contents


def tables_in(built, board, tmp_path):
    """The words of a bitstream as the public unpacker and the record's places give them."""
    device, family, _ = BUILT_BOARDS[board]
    layout = TableLayout.from_json(json.loads(built.with_name("build.json").read_text())["tables"]["unpacked"])
    return read_tables(UNPACKED[family](unpack(tmp_path, device, built.read_bytes())), layout)


def same(one, other) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


def snapshot(folder) -> dict:
    return {path: path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def test_another_rom_is_put_in_and_can_be_taken_back(built, board, arcref, tmp_path):
    before = snapshot(built.parent)
    result = arcref("patch", "--board", board, "--rom", "new.rom.json")
    assert result.exit_code == 0, result.output
    new, old = load_rom("new.rom.json"), load_rom("old.rom.json")
    assert f"ROM 0x{new.crc32:08X} in place of 0x{old.crc32:08X}" in result.stdout
    assert "all 5120 words" in result.stdout
    assert "NEW-2" in result.stdout
    assert same(tables_in(built, board, tmp_path), rom_contents(new))
    assert (
        read_built(built).rom_crc32 == new.crc32 == json.loads(built.with_name("build.json").read_text())["rom_crc32"]
    )
    assert arcref("patch", "--board", board, "--rom", "old.rom.json").exit_code == 0
    assert snapshot(built.parent) == before


def test_a_placeholder_gets_its_rom(board, arcref, tmp_path, built, leave_built):
    waiting = leave_built(tmp_path / "other", board, None)
    assert same(tables_in(waiting, board, tmp_path), placeholder_contents())
    assert read_built(waiting).rom_crc32 is None
    result = arcref("patch", waiting, "--rom", "new.rom.json")
    assert result.exit_code == 0, result.output
    assert "in place of the placeholder" in result.stdout
    assert same(tables_in(waiting, board, tmp_path), rom_contents(load_rom("new.rom.json")))


def test_the_result_may_go_elsewhere_with_its_record(built, board, arcref, tmp_path):
    before = snapshot(built.parent)
    other = tmp_path / f"encoder_7{built.suffix}"
    assert arcref("patch", "--board", board, "--rom", "new.rom.json", "-o", other).exit_code == 0
    assert snapshot(built.parent) == before
    assert read_built(other).rom_crc32 == load_rom("new.rom.json").crc32
    # And from there on.
    assert arcref("patch", other, "--rom", "old.rom.json").exit_code == 0
    assert other.read_bytes() == built.read_bytes()


def test_a_board_may_be_named_by_its_file(built, board, arcref):
    assert arcref("patch", "--board", f"some/folder/{board}.toml", "--rom", "new.rom.json").exit_code == 0
    assert read_built(built).rom_crc32 == load_rom("new.rom.json").crc32


def refused(arcref, built, *arguments, complaint):
    """The command refuses in one line, and nothing has changed."""
    before = snapshot(built.parents[2])
    result = arcref("patch", *arguments)
    assert result.exit_code == 2, result.output
    assert result.stderr.count("\n") == 1, result.stderr
    assert complaint in result.stderr, result.stderr
    assert snapshot(built.parents[2]) == before


def test_a_bitstream_of_another_layout_is_refused(built, board, arcref, tmp_path, leave_built):
    other = leave_built(tmp_path / "other", board, load_rom("old.rom.json"), layout=1)
    built.write_bytes(other.read_bytes())
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="another layout")


def test_a_bit_outside_of_the_tables_makes_another_layout(built, board, arcref):
    bitstream = read_built(built).bitstream
    tables = {place for parts in read_built(built).layout.in_file.places.values() for part in parts for place in part}
    taken = {place[:-2] for place in tables}
    free = next(block for block in bitstream.blocks if block not in taken)
    bits = bitstream.bits.copy()
    bits[bitstream.blocks[free][100, 3]] ^= 1
    built.write_bytes(bitstream.with_bits(bits))
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="another layout")


def test_a_stale_placeholder_is_refused(built, board, arcref, rng):
    # As from a version with other placeholder contents: full of words, but no ROM and not this version's placeholder.
    state = read_built(built)
    stale = state.bitstream.bits.copy()
    for parts in state.layout.in_file.places.values():
        for place in (place for part in parts for place in part):
            column = state.bitstream.column(place)
            stale[column] = rng.integers(0, 2, len(column))
    built.write_bytes(state.bitstream.with_bits(stale))
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="nor the placeholder")


def test_one_wrong_word_in_the_tables_is_refused(built, board, arcref):
    state = read_built(built)
    bits = state.bitstream.bits.copy()
    bits[state.bitstream.column(state.layout.in_file.places["line"][1][5])[77]] ^= 1
    built.write_bytes(state.bitstream.with_bits(bits))
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="neither a ROM (the tables' CRC")


def test_a_rom_that_does_not_fit_is_refused(built, board, arcref):
    path = Path("new.rom.json")
    image = json.loads(path.read_text())
    path.write_text(json.dumps(image | {"line_table": image["line_table"][:2048]}))
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="4096 were expected")


def test_a_bitstream_with_less_room_is_refused(built, board, arcref):
    # The record of a design whose line table was half as long.
    state = read_built(built)
    record = json.loads(built.with_name("build.json").read_text())
    for form in ("in_file", "unpacked"):
        record["tables"][form]["line"] = record["tables"][form]["line"][: len(record["tables"][form]["line"]) // 2]
    built.with_name("build.json").write_text(json.dumps(record))
    assert state.rom_crc32 is not None
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="another layout")


def test_what_is_no_bitstream_is_refused(built, board, arcref):
    whole = built.read_bytes()
    built.write_bytes(b"PK\x03\x04 not a bitstream")
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="no bitstream")
    built.write_bytes(whole[: len(whole) // 2])
    refused(
        arcref, built, "--board", board, "--rom", "new.rom.json", complaint=str(built.relative_to(built.parents[2]))
    )
    built.write_bytes(b"")
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", complaint="the file is empty")


def test_records_that_do_not_belong_are_refused(built, board, arcref):
    beside = built.with_name("build.json")
    record = json.loads(beside.read_text())
    command = ("--board", board, "--rom", "new.rom.json")
    for changes, complaint in (
        ({"format": "arcref-rom"}, "'arcref-build' version 1 was expected"),
        ({"version": 2}, "version 2"),
        ({"tables": None}, "tables"),
        ({"tables": record["tables"] | {"family": "ecp3"}}, "no known family"),
        ({"board": "icebreaker"}, "is for 'icebreaker'"),
        ({"layout_sha256": "0" * 64}, "another layout"),
    ):
        beside.write_text(json.dumps(record | changes))
        refused(arcref, built, *command, complaint=complaint)
    beside.write_text("{")
    refused(arcref, built, *command, complaint="not JSON")
    beside.unlink()
    refused(arcref, built, *command, complaint="build.json, which `arcref build` writes beside it, is missing")


def test_bad_use_is_refused(built, board, arcref, tmp_path):
    refused(arcref, built, "--board", "nothing", "--rom", "new.rom.json", complaint="run `arcref build --board nothing")
    refused(arcref, built, "--rom", "new.rom.json", complaint="--board")
    refused(arcref, built, "--board", board, "--rom", "none.rom.json", complaint="no such file")
    refused(arcref, built, built, "--board", "icebreaker", "--rom", "new.rom.json", complaint="not for 'icebreaker'")
    refused(
        arcref, built, "--board", board, "--rom", "new.rom.json", "-o", "x.elf", complaint=f"must end in {built.suffix}"
    )
    # The record beside new.rom.bit would be new.rom.json.
    clash = f"new.rom{built.suffix}"
    refused(arcref, built, "--board", board, "--rom", "new.rom.json", "-o", clash, complaint="would replace the ROM")


def test_a_result_that_does_not_unpack_as_written_is_not_kept(built, board, arcref, monkeypatch):
    before = snapshot(built.parent)
    place = read_built(built).layout.in_file.places["subdivision"][0][9]

    def place_wrongly(bitstream, layout, contents):
        bits = place_tables(bitstream, layout, contents)
        bits[bitstream.column(place)[3]] ^= contents.identity[0] != 0  # the ROM, not the blank of the layout's hash
        return bits

    monkeypatch.setattr("arcref_gateware.boards.bitstream_tables.place_tables", place_wrongly)
    result = arcref("patch", "--board", board, "--rom", "new.rom.json")
    assert result.exit_code == 1
    assert "is left as it was: 1 of 512 words of the subdivision table came out wrong, the first at 3" in result.stderr
    assert snapshot(built.parent) == before


def test_a_result_that_cannot_be_unpacked_is_not_kept(built, board, arcref, monkeypatch):
    before = snapshot(built.parent)
    monkeypatch.setenv("ICEUNPACK" if board == "hx8k" else "ECPUNPACK", "false")
    result = arcref("patch", "--board", board, "--rom", "new.rom.json")
    assert result.exit_code == 1
    assert "is left as it was" in result.stderr
    assert snapshot(built.parent) == before
