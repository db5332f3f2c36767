"""The ROM image `NAME.rom.json`: the correction tables with everything needed to trust them, and their check.

Beside it stand the same tables for Verilog's `$readmemh`, one word of four hexadecimal digits a line:
`NAME.line.mem`, `NAME.subdivision.mem` and `NAME.identity.mem`.
"""

import json
from pathlib import Path

import numpy as np

from arcref.angle import COUNTS_PER_TURN, LINES_PER_TURN
from arcref.atomic_file import write_files
from arcref.correction_rom import ENTRY_MAX, ENTRY_MIN, FRACTION_BITS, SUBDIVISION_ENTRIES, CorrectionRom
from arcref.input_error import InputError
from arcref.input_file import read_input_file
from arcref.rom_identity import identity_words

FORMAT = "arcref-rom"
VERSION = 1

_ENTRIES_A_LINE = 16


def save_rom(rom: CorrectionRom, path) -> list[Path]:
    """Write the image of `rom` to `path` and its three `.mem` files beside it; gives their paths, the image's first.

    Raises `InputError` when a file cannot be written; then none is changed.
    """
    files = rom_files(rom, path)
    write_files(files)
    return list(files)


def rom_files(rom: CorrectionRom, path) -> dict[Path, bytes]:
    """The content of every file that `save_rom` writes, by path. The same ROM gives the same bytes."""
    path = Path(path)
    stem = path.name.removesuffix(".json").removesuffix(".rom")
    tables = {"line": rom.line_table, "subdivision": rom.subdivision_table, "identity": identity_words(rom)}
    files = {path: rom_json(rom).encode()}
    files |= {path.with_name(f"{stem}.{name}.mem"): readmemh(words).encode() for name, words in tables.items()}
    return files


def rom_json(rom: CorrectionRom) -> str:
    """The image's text."""
    entries = {
        "format": json.dumps(FORMAT),
        "version": str(VERSION),
        "counts_per_turn": str(COUNTS_PER_TURN),
        "fraction_bits": str(FRACTION_BITS),
        "crc32": str(rom.crc32),
        "provenance": json.dumps(rom.provenance, indent=2, allow_nan=False).replace("\n", "\n  "),
        "line_table": _table_json(rom.line_table),
        "subdivision_table": _table_json(rom.subdivision_table),
    }
    return "{\n" + ",\n".join(f'  "{key}": {value}' for key, value in entries.items()) + "\n}\n"


def readmemh(words) -> str:
    """16-bit words as `$readmemh` reads them: four hexadecimal digits a line, negative ones in two's complement.

    >>> readmemh([1, -1])
    '0001\\nffff\\n'
    """
    return "".join(f"{int(word) & 0xFFFF:04x}\n" for word in words)


def load_rom(path) -> CorrectionRom:
    """Read the image at `path` and check all of it. Raises `InputError`, which says what is wrong and where."""
    file = read_input_file(path)
    image = file.json_object()
    expected = {
        "format": FORMAT,
        "version": VERSION,
        "counts_per_turn": COUNTS_PER_TURN,
        "fraction_bits": FRACTION_BITS,
    }
    for key, value in expected.items():
        if key not in image:
            raise InputError.at(path, f"is missing, {value!r} was expected", column=key)
        # `True == 1` in Python, so the type is compared as well.
        if type(image[key]) is not type(value) or image[key] != value:
            raise InputError.at(path, f"is {_short(image[key])}, {value!r} was expected", column=key)
    line = _read_table(path, image, "line_table", LINES_PER_TURN)
    subdivision = _read_table(path, image, "subdivision_table", SUBDIVISION_ENTRIES)
    provenance = image.get("provenance")
    if not isinstance(provenance, dict):
        raise InputError.at(path, f"is {_short(provenance)}, a JSON object was expected", column="provenance")
    crc32 = image.get("crc32")
    if type(crc32) is not int or not 0 <= crc32 < 1 << 32:
        raise InputError.at(path, f"is {_short(crc32)}, an integer in 0 .. 4294967295 was expected", column="crc32")
    rom = CorrectionRom(line, subdivision, provenance)
    if crc32 != rom.crc32:
        problem = f"is 0x{crc32:08X}, the tables give 0x{rom.crc32:08X}: the file is damaged"
        raise InputError.at(path, problem, column="crc32")
    return rom


def _read_table(path, image: dict, key: str, length: int) -> np.ndarray:
    table = image.get(key)
    if not isinstance(table, list):
        raise InputError.at(path, f"is {_short(table)}, a list of {length} integers was expected", column=key)
    if len(table) != length:
        raise InputError.at(path, f"has {len(table)} entries, {length} were expected", column=key)
    for index, entry in enumerate(table):
        if type(entry) is not int or not ENTRY_MIN <= entry <= ENTRY_MAX:
            problem = f"is {_short(entry)}, an integer in {ENTRY_MIN} .. {ENTRY_MAX} was expected"
            raise InputError.at(path, problem, column=f"{key}[{index}]")
    return np.array(table, np.int16)


def _table_json(table: np.ndarray) -> str:
    lines = [", ".join(map(str, table[i : i + _ENTRIES_A_LINE])) for i in range(0, len(table), _ENTRIES_A_LINE)]
    return "[\n    " + ",\n    ".join(lines) + "\n  ]"


def _short(value) -> str:
    """A value out of a file, on one line and not too long for an error message."""
    if value is None:
        return "missing"
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."
