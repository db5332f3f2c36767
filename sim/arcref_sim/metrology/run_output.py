"""Writing a simulated run: the run file, the truth beside it, and a line for the person at the terminal."""

import json
from pathlib import Path

import click
import numpy as np

from arcref import __version__
from arcref.atomic_file import write_files
from arcref.input_error import InputError
from arcref.output_files import check_outputs
from arcref_sim.metrology.run_file_text import run_file_text

FORMAT, VERSION = "arcref-simulated-truth", 1


def truth_path(output: Path, truth: Path | None) -> Path:
    """Where the truth goes: as told, or beside the run file."""
    return truth or output.with_name(output.name.removesuffix(".csv") + ".truth.json")


def check_run_outputs(output: Path, truth: Path | None, inputs: list[Path | None]) -> None:
    """Raises `InputError` before anything is computed when a file cannot be the one to write."""
    if output.suffix.lower() != ".csv":
        raise InputError(f"{output}: the name of a run file must end in .csv")
    check_outputs([output, truth_path(output, truth)], [path for path in inputs if path])


def simulated_by(verb: str, run: str, seed: int) -> dict[str, str]:
    """The metadata that begin every simulated run: its encoder, what it is, and how to make it again."""
    return {
        "encoder_serial": f"SIM-{seed}",
        "encoder_model": "simulated encoder",
        "run": run,
        "source": f"arcref simulate {verb}, version {__version__}, seed {seed}",
    }


def write_run(
    output: Path, truth: Path | None, metadata: dict, columns: dict[str, np.ndarray], known: dict, kind: str, seed: int
) -> None:
    """Write both files, whole or not at all, and say so."""
    beside = truth_path(output, truth)
    head = {"format": FORMAT, "version": VERSION, "kind": kind, "seed": seed, "run_file": output.name}
    write_files(
        {
            output: run_file_text(metadata, columns).encode(),
            beside: (json.dumps(head | known, indent=2) + "\n").encode(),
        }
    )
    rows = len(next(iter(columns.values())))
    click.echo(f"{output}: {rows} readings, seed {seed}; what is true stands in {beside}")
