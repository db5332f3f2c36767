"""`arcref simulate corrected`: what ROMs leave of the error of an encoder of known optics, in the Verilated core."""

import json
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from arcref.atomic_file import write_files
from arcref.input_error import InputError
from arcref.output_files import check_outputs
from arcref.rom_image import load_rom
from arcref_sim.core_options import build_folder_option
from arcref_sim.corrected_angle import CorrectedAngle, corrected_angle, run_core
from arcref_sim.corrected_angle_plot import corrected_angle_plot
from arcref_sim.metrology.quantity_option import Quantity
from arcref_sim.optics.optics_options import OPTION_NAMES, optical_encoder, optics_options

FILE = click.Path(path_type=Path)

MOST_ROMS = 3


@click.command()
@click.option("--rom", "roms", type=FILE, multiple=True, required=True, metavar="X.rom.json", help="Up to 3 of them.")
@click.option("--seed", type=Quantity("", 0, 2**63 - 1, whole=True), default=1, show_default=True, metavar="N")
@optics_options
@click.option("--speed", type=Quantity("r/s", 1, 60), default=20.0, show_default=True, metavar="RPS")
@click.option("--plot", type=FILE, metavar="FILE.svg", help="Plot the errors over the turn and within the line.")
@click.option("--json", "json_path", type=FILE, metavar="FILE.json", help="Write the figures and curves.")
@build_folder_option
def corrected(roms, seed, speed, plot, json_path, build_folder, **options):
    """Turn an encoder of known optics before the Verilated core, and show what each ROM leaves of its error.

    The optics options and the seed make the encoder, as in arcref simulate subdivision.
    """
    if len(roms) > MOST_ROMS or len(set(roms)) < len(roms):
        raise InputError(f"--rom: one to {MOST_ROMS} different images were expected")
    if plot and plot.suffix.lower() != ".svg":
        raise InputError(f"{plot}: the name of the plot must end in .svg")
    check_outputs([plot, json_path], list(roms))
    images = {path.name.removesuffix(".rom.json"): load_rom(path) for path in roms}
    encoder = optical_encoder(seed, **{name: options[name] for name in OPTION_NAMES})
    try:
        encoder.error_arcsec(np.arange(3600) / 10)
    except ValueError as error:
        raise InputError(f"--eccentricity is {options['eccentricity']:g} um: {error}") from None
    results = {}
    with Progress(console=Console(stderr=True), transient=True) as bar:
        for name, image in images.items():
            task = bar.add_task(f"turning, {name}", total=1.0)

            def done(part: float, task=task) -> None:
                bar.update(task, completed=part)

            positions = run_core(encoder, image, speed_rps=speed, folder=build_folder, progress=done)
            results[name] = corrected_angle(positions)
    files = {}
    if plot:
        files[plot] = corrected_angle_plot(results)
    if json_path:
        content = {name: result.to_json() for name, result in results.items()}
        files[json_path] = (json.dumps(content, indent=2) + "\n").encode()
    write_files(files)
    _print(results, list(files))


def _print(results: dict[str, CorrectedAngle], written: list[Path]) -> None:
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), title="Error of the angle / arcsec")
    for column in ("ROM", "rms", "at most", "within a line, peak to peak"):
        table.add_column(column, justify="left" if column == "ROM" else "right")
    first = next(iter(results.values()))
    table.add_row("none", f"{first.raw_rms_arcsec:.3f}", "", f"{np.ptp(first.raw_line_arcsec):.3f}")
    for name, result in results.items():
        table.add_row(
            name, f"{result.rms_arcsec:.3f}", f"{result.largest_arcsec:.3f}", f"{result.within_line_arcsec:.3f}"
        )
    console = Console(highlight=False)
    console.print(table)
    for path in written:
        console.print(f"written {path}", soft_wrap=True)
