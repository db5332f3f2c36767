"""What is refused about the files that a simulation is told to write."""

from pathlib import Path

from arcref.input_error import InputError


def check_outputs(outputs: list[Path | None], inputs: list[Path]) -> None:
    """Raises `InputError` when a file to be written is an input, is named twice, or has no folder."""
    taken = {path.resolve() for path in inputs}
    for path in filter(None, outputs):
        if path.resolve() in taken:
            raise InputError(f"{path}: this name is given to two files of this run")
        if not path.resolve().parent.is_dir():
            raise InputError(f"{path}: its folder does not exist")
        taken.add(path.resolve())
