"""What is refused about the files that a verb is told to write."""

from collections.abc import Iterable
from pathlib import Path

from arcref.input_error import InputError


def check_outputs(outputs: Iterable[Path | None], inputs: Iterable[Path | None]) -> None:
    """Raises `InputError` when a file to be written is an input, is named twice, or has no folder."""
    taken = {path.resolve() for path in filter(None, inputs)}
    for path in filter(None, outputs):
        if path.resolve() in taken:
            raise InputError(f"{path}: this name is given to two files of this run")
        if not path.resolve().parent.is_dir():
            raise InputError(f"{path}: its folder does not exist")
        taken.add(path.resolve())
