"""The error for input that cannot be used."""


class InputError(Exception):
    """Bad input or use, told in one line that a person can act on.

    The command prints the line and ends with exit status 2.
    """

    @classmethod
    def at(cls, file, problem: str, *, row: int | None = None, column: str | None = None) -> "InputError":
        """The error for a place in a file.

        `row` is the line number in the file, counted from 1; `column` is the column's name or the key's path.
        `problem` says what stands there and what was expected.
        """
        place = str(file)
        if row is not None:
            place += f", row {row}"
        if column is not None:
            place += f", column {column}"
        return cls(f"{place}: {problem}")
