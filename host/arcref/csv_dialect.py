"""How a CSV file separates its cells and writes its numbers: with commas and points, or as Excel does in Europe.

Semicolons between the cells free the comma for the decimals, so such a file is read where it leaves no doubt. One that
has both decimal commas and decimal points is refused, as is a comma in a number where commas separate the cells.
"""

import csv
import math
import re
from dataclasses import dataclass, field
from pathlib import Path

from arcref.input_error import InputError

# Python's float() also takes "1_000", "nan" and digits of other scripts: none is a reading.
_NUMBER = re.compile(r"[+-]?(\d+[.,]?\d*|[.,]\d+)([eE][+-]?\d+)?", re.ASCII)

_SEPARATOR_LINE = re.compile(r"sep=(.)", re.IGNORECASE)

COMMA, SEMICOLON, TAB = ",", ";", "\t"


@dataclass
class CsvDialect:
    """The way of one file: its `path`, for messages, and its `delimiter`.

    `decimal_row`: for the mark of the decimals, "," or ".", the row in which it was first seen.
    """

    path: Path
    delimiter: str = COMMA
    decimal_row: dict[str, int] = field(default_factory=dict)

    @classmethod
    def of_header(cls, path: Path, row: int, header: str, announced: str | None = None) -> "CsvDialect":
        """The dialect that the line of column names shows, or that Excel's `sep=;` line before it `announced`."""
        if announced is not None:
            if announced not in (COMMA, SEMICOLON):
                raise InputError.at(path, f"sep={announced}: commas or semicolons between the cells were expected")
            return cls(path, announced)
        if TAB in header and COMMA not in header:
            problem = "tabs stand between the column names, commas were expected (or semicolons)"
            raise InputError.at(path, problem, row=row)
        return cls(path, SEMICOLON if SEMICOLON in header and COMMA not in header else COMMA)

    def cells(self, row: int, line: str) -> list[str]:
        """The cells of one line. Raises `InputError` for an open quotation mark and the like."""
        # One line at a time, so that a quotation mark left open cannot swallow the rows behind it.
        try:
            (cells,) = csv.reader([line], strict=True, delimiter=self.delimiter)
        except csv.Error as error:
            raise InputError.at(self.path, f"not a CSV row: {error}", row=row) from None
        return cells

    def number(self, row: int, column: str, cell: str) -> float:
        """The number in a cell. Raises `InputError` when it is none, is not finite, or its comma leaves a doubt."""
        text = cell.strip()
        if not text:
            raise InputError.at(self.path, "the cell is empty, a number was expected", row=row, column=column)
        shown = text if len(text) <= 40 else text[:37] + "..."
        if not _NUMBER.fullmatch(text) or not math.isfinite(float(text.replace(COMMA, "."))):
            raise InputError.at(self.path, f"{shown!r} is not a finite number", row=row, column=column)
        mark = next((mark for mark in (COMMA, ".") if mark in text), None)
        if mark is not None:
            self._check_mark(row, column, shown, mark)
        return float(text.replace(COMMA, "."))

    def metadata_number(self, text: str) -> str:
        """A number of the metadata with a point for its decimals, as `float` expects it; other text as it stands."""
        if self.delimiter == SEMICOLON and _NUMBER.fullmatch(text):
            return text.replace(COMMA, ".")
        return text

    def _check_mark(self, row: int, column: str, shown: str, mark: str) -> None:
        if self.delimiter == COMMA and mark == COMMA:
            problem = f"{shown!r} has a comma; a decimal point was expected, or semicolons between the columns"
            raise InputError.at(self.path, problem, row=row, column=column)
        self.decimal_row.setdefault(mark, row)
        if len(self.decimal_row) > 1:
            (other,) = {COMMA, "."} - {mark}
            words = {COMMA: "a decimal comma", ".": "a decimal point"}
            problem = f"{shown!r} has {words[mark]}, row {self.decimal_row[other]} has {words[other]}: one was expected"
            raise InputError.at(self.path, problem, row=row, column=column)


def announced_delimiter(line: str) -> str | None:
    """The delimiter that Excel's first line `sep=;` announces, None for any other line."""
    found = _SEPARATOR_LINE.fullmatch(line.strip())
    return found and found[1]
