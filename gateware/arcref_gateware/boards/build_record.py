"""`build.json`: what was built for which board, with what, how fast it is, and where its tables are."""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref.input_file import read_input_file
from arcref_gateware.boards.bitstream import Bitstream, BitstreamError
from arcref_gateware.boards.bitstream_tables import BitstreamLayout, is_placeholder, read_bitstream, rom_of
from arcref_gateware.boards.table_layout import TablesNotFound, read_tables

FORMAT = "arcref-build"
VERSION = 1

DEFAULT_BUILD_FOLDER = Path("build")
BITSTREAM_NAMES = ("arcref.bit", "arcref.bin")
RECORD_NAME = "build.json"

SPEED_MARGINS = {"1": 1.0, "1_5": 1.5}
"""Samples per count at which a highest speed is stated, by the part of the key that names it."""


def highest_speed_rps(samples_per_s: float, samples_per_count: float) -> float:
    """Turns a second at which every count gets that many samples."""
    return samples_per_s / samples_per_count / COUNTS_PER_TURN


def speed_figures(samples_per_word: int, word_clock_hz: float) -> dict:
    """Samples a second at a word clock, and the highest speeds they allow, by name."""
    samples_per_s = samples_per_word * word_clock_hz
    speeds = {
        f"highest_speed_{name}_samples_per_count_rps": highest_speed_rps(samples_per_s, samples)
        for name, samples in SPEED_MARGINS.items()
    }
    return {"samples_per_s": samples_per_s} | speeds


@dataclass(frozen=True)
class BuiltBitstream:
    """A bitstream, its record, and the ROM it carries, checked against each other."""

    path: Path
    bitstream: Bitstream
    record: dict
    layout: BitstreamLayout
    rom_crc32: int | None
    """CRC-32 of the tables in the bitstream, None when it still carries the placeholder."""

    @property
    def board(self) -> str:
        """Name of the board it was built for."""
        return self.record["board"]


def record_path(bitstream: Path) -> Path:
    """The record beside a bitstream: `build.json`, or NAME.json for a bitstream that was given a name of its own."""
    return bitstream.with_name(RECORD_NAME) if bitstream.name in BITSTREAM_NAMES else bitstream.with_suffix(".json")


def bitstream_of_board(board: str, build_folder: Path) -> Path:
    """The bitstream that `arcref build` left for a board. Raises `InputError` when there is none."""
    folder = build_folder / board
    for name in BITSTREAM_NAMES:
        if (folder / name).is_file():
            return folder / name
    raise InputError(f"{folder}: there is no bitstream; run `arcref build --board {board} --rom X.rom.json` first")


def read_built(path: Path) -> BuiltBitstream:
    """Read a bitstream and its record, and check that they belong together.

    Raises `InputError`: no bitstream, no record, a record of another layout, tables that are neither a ROM nor the
    placeholder.
    """
    try:
        bitstream = read_bitstream(read_input_file(path).content)
    except BitstreamError as error:
        raise InputError.at(path, str(error)) from None
    beside = record_path(path)
    if not beside.is_file():
        raise InputError.at(path, f"{beside.name}, which `arcref build` writes beside it, is missing")
    record = read_input_file(beside).json_object()
    if record.get("format") != FORMAT or record.get("version") != VERSION:
        found = f"{record.get('format')!r} version {record.get('version')!r}"
        raise InputError.at(beside, f"is {found}, {FORMAT!r} version {VERSION} was expected", column="format")
    try:
        layout = BitstreamLayout.from_json(record.get("tables"))
    except ValueError as error:
        raise InputError.at(beside, str(error), column="tables") from None
    if bitstream.board != record.get("board"):
        named = "no board" if bitstream.board is None else f"the board {bitstream.board!r}"
        raise InputError.at(path, f"was built for {named}, {beside.name} is for {record.get('board')!r}")
    try:
        same_layout = layout.sha256(bitstream) == record.get("layout_sha256")
        contents = read_tables(bitstream, layout.in_file)
    except TablesNotFound:
        same_layout = False
    if not same_layout:
        raise InputError.at(path, f"has another layout than the one {beside.name} describes; build it again")
    crc32 = None
    if not is_placeholder(contents):
        try:
            crc32, _ = rom_of(contents)
        except ValueError as error:
            problem = f"its tables are neither a ROM ({error}) nor the placeholder of this version; build it again"
            raise InputError.at(path, problem) from None
    return BuiltBitstream(path, bitstream, record, layout, crc32)


def with_rom(record: dict, content: bytes, crc32: int) -> dict:
    """The record of the same build with another ROM in it."""
    return record | {"rom_crc32": crc32, "bitstream_sha256": hashlib.sha256(content).hexdigest()}


def record_json(record: dict) -> bytes:
    """The record as it is written: one key a line, the places of the tables one part a line."""
    record = dict(record)
    tables = record.pop("tables", None)
    text = json.dumps(record, indent=2, allow_nan=False)
    if tables is not None:
        forms = []
        for form in ("in_file", "unpacked"):
            memories = []
            for memory, parts in tables[form].items():
                lines = ",\n        ".join(json.dumps(part, separators=(",", ":")) for part in parts)
                memories.append(f'"{memory}": [\n        {lines}\n      ]')
            forms.append(f'"{form}": {{\n      ' + ",\n      ".join(memories) + "\n    }")
        family = json.dumps(tables["family"])
        text = text[:-2] + f',\n  "tables": {{\n    "family": {family},\n    ' + ",\n    ".join(forms) + "\n  }\n}"
    return f"{text}\n".encode()
