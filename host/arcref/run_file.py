"""Run files: the CSV files that hold measurements.

UTF-8, comma; first `# key: value` lines (the metadata), then one line of column names with their units, then one row
for each reading. A key that stands on several lines has their values joined by "; ". A `#` line without a colon is a
remark. Empty lines are passed over. The columns may stand in any order.

What Excel makes of such a file is read too: a byte order mark, a line `sep=;`, semicolons with decimal commas, metadata
lines padded with empty cells or in quotation marks, rows and last columns of empty cells.
"""

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from arcref.csv_dialect import CsvDialect, announced_delimiter
from arcref.input_error import InputError
from arcref.input_file import InputFile, read_input_file

# str.splitlines() also splits at rarer characters, and then the row numbers would not be those of an editor.
_LINE_END = re.compile(r"\r\n|\n|\r")

# How alike two keys must be, 1 being the same, for the one to be the other misspelt.
_ALIKE = 0.8


@dataclass(frozen=True)
class RunFile:
    """A run file that was read.

    `columns` maps each column's name to its numbers, float64[n]; `rows` holds the line in the file (from 1) of each of
    the n readings, for messages; `metadata` maps keys to text, a number's decimals after a point; `metadata_rows` keys
    to lines in the file; `header_row` is the line of the column names.
    """

    file: InputFile
    metadata: dict[str, str]
    columns: dict[str, np.ndarray] = field(repr=False)
    rows: tuple[int, ...] = field(repr=False)
    metadata_rows: dict[str, int] = field(default_factory=dict, repr=False)
    header_row: int | None = None

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

    def metadata_error(self, key: str, problem: str) -> InputError:
        """The error for the value of a metadata key."""
        return InputError.at(self.path, f"metadata {key}: {problem}", row=self.metadata_rows.get(key))


def read_run_file(
    path,
    required: Sequence[str],
    optional: Sequence[str] = (),
    known_metadata: Sequence[str] = (),
    alternatives: Sequence[Sequence[str]] = (),
) -> RunFile:
    """Read a run file that has all the columns of `required` and may have those of `optional`, and no others.

    `alternatives`: sets of columns, any of which may stand in place of `required`.

    `known_metadata`: the keys that this kind of run knows, if its reader wants misspelt ones refused.

    Raises `InputError` when it cannot be read, is no UTF-8, has other columns, a row of another length, a cell that
    is not a finite number, a metadata key that looks like a known one misspelt, or an uncertainty nobody asks for.
    """
    file = read_input_file(path)
    lines = _LINE_END.split(file.text())
    header_index = next((i for i, line in enumerate(lines) if _is_content(line)), None)
    if header_index is None:
        raise InputError.at(path, f"no line of column names, {_names(required or optional)} were expected")
    announced = next(filter(None, map(announced_delimiter, lines[:header_index])), None)
    dialect = CsvDialect.of_header(file.path, header_index + 1, lines[header_index], announced)
    metadata, metadata_rows = _read_metadata(dialect, lines[:header_index])
    names = _column_names(dialect, header_index + 1, lines[header_index])
    _check_names(file.path, header_index + 1, names, [required, *alternatives], optional)
    # Behind the columns: the file of another method has keys of its own, and that is not what is wrong with it.
    _check_keys(file.path, metadata_rows, known_metadata)
    cells: dict[str, list[float]] = {name: [] for name in names}
    numbers = []
    for line, row in _csv_rows(dialect, lines, header_index + 1):
        if len(row) > len(names) and not any(cell.strip() for cell in row[len(names) :]):
            row = row[: len(names)]
        if len(row) != len(names):
            problem = f"{len(row)} cells, {len(names)} were expected ({_names(names)})"
            if len(row) > len(names) and dialect.delimiter == ",":
                problem += "; decimal commas need semicolons between the columns"
            raise InputError.at(path, problem, row=line)
        for name, cell in zip(names, row, strict=True):
            cells[name].append(dialect.number(line, name, cell))
        numbers.append(line)
    columns = {name: np.array(values, float) for name, values in cells.items()}
    return RunFile(file, metadata, columns, tuple(numbers), metadata_rows, header_index + 1)


def _is_content(line: str) -> bool:
    """True for a line that is neither empty, nor metadata, nor Excel's `sep=;`."""
    bare = line.strip(" \t,;")
    return bool(bare) and not bare.startswith(("#", '"#')) and announced_delimiter(line) is None


def _read_metadata(dialect: CsvDialect, lines: list[str]) -> tuple[dict[str, str], dict[str, int]]:
    """Keys with their text, and with the row each first stands in."""
    metadata: dict[str, str] = {}
    rows: dict[str, int] = {}
    for row, line in enumerate(lines, 1):
        if line.startswith('"#'):
            line = dialect.delimiter.join(dialect.cells(row, line))
        if not line.startswith("#"):
            continue
        key, colon, value = line[1:].rstrip(dialect.delimiter + " ").partition(":")
        key, value = key.strip(), dialect.metadata_number(value.strip())
        if colon:
            metadata[key] = f"{metadata[key]}; {value}" if key in metadata else value
            rows.setdefault(key, row)
    return metadata, rows


def _check_keys(path: Path, rows: dict[str, int], known: Sequence[str]) -> None:
    """Refuse a key that would be passed over though its writer meant something by it."""
    if not known:
        return
    for key, row in rows.items():
        if key in known:
            continue
        plain = key.lower().replace(" ", "_").replace("-", "_")
        in_another_unit = [name for name in known if name.rpartition("_")[0] == plain.rpartition("_")[0] != ""]
        near = in_another_unit or difflib.get_close_matches(plain, known, 1, _ALIKE)
        shown = key if len(key) <= 60 else key[:57] + "..."
        if near:
            problem = f"the metadata key {shown!r} is not known, {near[0]!r} was probably meant"
            raise InputError.at(path, problem, row=row)
        if key.startswith(("u_", "expanded_")):
            wanted = ", ".join(name for name in known if name.startswith(("u_", "expanded_")))
            problem = f"the uncertainty {shown!r} is not one of this kind of run; these are: {wanted}"
            raise InputError.at(path, problem, row=row)


def _column_names(dialect: CsvDialect, row: int, header: str) -> list[str]:
    names = [name.strip() for name in dialect.cells(row, header)]
    while names and not names[-1]:
        names.pop()
    return names


def _csv_rows(dialect: CsvDialect, lines: list[str], first: int):
    """Each row behind the column names that is not empty, with its line number."""
    for number, line in enumerate(lines[first:], first + 1):
        if not line.strip(f" \t{dialect.delimiter}"):
            continue
        if line.startswith(("#", '"#')):
            problem = "a line with # stands behind the column names, it belongs before them"
            raise InputError.at(dialect.path, problem, row=number)
        yield number, dialect.cells(number, line)


def _check_names(path: Path, row: int, names: list[str], choices: list[Sequence[str]], optional: Sequence[str]) -> None:
    complete = any(set(required) <= set(names) <= {*required, *optional} for required in choices)
    if complete and len(set(names)) == len(names):
        return
    expected = " or ".join(_names(required) for required in choices)
    if optional:
        expected += f" (and, if wanted, {_names(optional)})"
    raise InputError.at(path, f"the columns are {_names(names)}, expected were {expected}", row=row)


def _names(names: Sequence[str]) -> str:
    text = ",".join(names)
    return repr(text if len(text) <= 120 else text[:117] + "...")
