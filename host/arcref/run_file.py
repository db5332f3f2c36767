"""Run files: the CSV files that hold measurements.

UTF-8, comma; first `# key: value` lines (the metadata), then one line of column names with their units, then one row
for each reading. A key that stands on several lines has their values joined by "; ". A `#` line without a colon is a
remark. Empty lines are passed over. The columns may stand in any order.
"""

import csv
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from arcref.input_error import InputError
from arcref.input_file import InputFile, read_input_file

# Python's float() also takes "1_000", "nan" and digits of other scripts: none is a reading.
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)

# str.splitlines() also splits at rarer characters, and then the row numbers would not be those of an editor.
_LINE_END = re.compile(r"\r\n|\n|\r")


@dataclass(frozen=True)
class RunFile:
    """A run file that was read.

    `columns` maps each column's name to its numbers, float64[n]; `rows` holds the line in the file (from 1) of each of
    the n readings, for messages; `metadata` maps keys to text.
    """

    file: InputFile
    metadata: dict[str, str]
    columns: dict[str, np.ndarray] = field(repr=False)
    rows: tuple[int, ...] = field(repr=False)

    @property
    def path(self) -> Path:
        """Where it was read from."""
        return self.file.path

    def __getitem__(self, column: str) -> np.ndarray:
        return self.columns[column]

    def error(self, problem: str, *, reading: int | None = None, column: str | None = None) -> InputError:
        """The error for a place in this file; `reading` counts the rows of numbers from 0."""
        row = None if reading is None else self.rows[reading]
        return InputError.at(self.path, problem, row=row, column=column)


def read_run_file(path, required: Sequence[str], optional: Sequence[str] = ()) -> RunFile:
    """Read a run file that has all the columns of `required` and may have those of `optional`, and no others.

    Raises `InputError` when it cannot be read, is no UTF-8, has other columns, a row of another length, or a cell that
    is not a finite number.
    """
    file = read_input_file(path)
    metadata, lines = _split_metadata(_LINE_END.split(file.text()))
    rows = _csv_rows(file.path, lines)
    line, header = next(rows, (None, None))
    if header is None:
        raise InputError.at(path, f"no line of column names, {_names(required)} were expected")
    names = [name.strip() for name in header]
    _check_names(file.path, line, names, required, optional)
    cells: dict[str, list[float]] = {name: [] for name in names}
    numbers = []
    for line, row in rows:
        if row[0].startswith("#"):
            raise InputError.at(path, "a line with # stands behind the column names, it belongs before them", row=line)
        if len(row) != len(names):
            problem = f"{len(row)} cells, {len(names)} were expected ({_names(names)})"
            raise InputError.at(path, problem, row=line)
        for name, cell in zip(names, row, strict=True):
            cells[name].append(_number(file.path, line, name, cell))
        numbers.append(line)
    columns = {name: np.array(values, float) for name, values in cells.items()}
    return RunFile(file, metadata, columns, tuple(numbers))


def _split_metadata(lines: list[str]) -> tuple[dict[str, str], list[tuple[int, str]]]:
    """The metadata before the column names, and what follows as numbered lines."""
    metadata: dict[str, str] = {}
    for index, line in enumerate(lines):
        if line.startswith("#"):
            key, colon, value = line[1:].partition(":")
            key, value = key.strip(), value.strip()
            if colon:
                metadata[key] = f"{metadata[key]}; {value}" if key in metadata else value
        elif line.strip():
            return metadata, list(enumerate(lines[index:], index + 1))
    return metadata, []


def _csv_rows(path: Path, lines: list[tuple[int, str]]):
    """Each row that is not empty, with its line number."""
    for number, line in lines:
        if not line.strip():
            continue
        # One line at a time, so that a quotation mark left open cannot swallow the rows behind it.
        try:
            (row,) = csv.reader([line], strict=True)
        except csv.Error as error:
            raise InputError.at(path, f"not a CSV row: {error}", row=number) from None
        yield number, row


def _check_names(path: Path, row: int, names: list[str], required: Sequence[str], optional: Sequence[str]) -> None:
    complete = set(required) <= set(names) <= {*required, *optional}
    if complete and len(set(names)) == len(names):
        return
    expected = _names(required)
    if optional:
        expected += f" (and, if wanted, {_names(optional)})"
    raise InputError.at(path, f"the columns are {_names(names)}, expected were {expected}", row=row)


def _number(path: Path, row: int, column: str, cell: str) -> float:
    text = cell.strip()
    if not text:
        raise InputError.at(path, "the cell is empty, a number was expected", row=row, column=column)
    if not _NUMBER.fullmatch(text) or not math.isfinite(float(text)):
        shown = text if len(text) <= 40 else text[:37] + "..."
        raise InputError.at(path, f"{shown!r} is not a finite number", row=row, column=column)
    return float(text)


def _names(names: Sequence[str]) -> str:
    text = ",".join(names)
    return repr(text if len(text) <= 120 else text[:117] + "...")
