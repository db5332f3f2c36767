"""`arcref simulate zero-return`: full turns there and back on the simulated core, against the truth."""

from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from arcref.angle import LINES_PER_TURN
from arcref.input_error import InputError
from arcref.output_files import check_outputs
from arcref.rom_command import read_curve
from arcref.rom_image import load_rom
from arcref.rom_provenance import fit_from_provenance
from arcref.subdivision_at_faces import without_subdivision
from arcref.subdivision_curve import SubdivisionCurve
from arcref.zero_return.outputs import print_result, write_outputs
from arcref.zero_return.result import ZeroReturnResult
from arcref_sim.core_options import build_folder_option, samples_option
from arcref_sim.zero_return import run_zero_return

FILE = click.Path(path_type=Path)

TURN_KNOTS, WITHIN_LINE_KNOTS = 1 << 15, 1 << 18
"""Straight pieces of a turn that stand for the error: 8 or 64 a grating line."""

SLOWEST_RPS, FASTEST_RPS = 0.1, 500.0


@click.command("zero-return")
@click.option("--speed", type=float, default=10.0, show_default=True, metavar="RPS", help="Turns a second.")
@click.option("--revolutions", type=click.IntRange(0, 1000), default=10, show_default=True, help="Full turns each way.")
@samples_option
@click.option("--rom", "rom_path", type=FILE, required=True, metavar="X.rom.json", help="ROM image of the correction.")
@click.option(
    "--curve",
    type=FILE,
    required=True,
    metavar="CAL.json|POLYGON.csv",
    help="The encoder's true error: its fit is the truth.",
)
@click.option(
    "--subdivision",
    type=FILE,
    metavar="CAL.json",
    help="The true error within a line, for a ROM with a second table.",
)
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the result as JSON, too.")
@click.option("--page", type=FILE, metavar="FILE.html", help="Write the page with the plots.")
@build_folder_option
def zero_return(speed, revolutions, samples, rom_path, curve, subdivision, json_path, page, build_folder):
    """Turn forward and back, and hold every count against the truth.

    The encoder starts before its zero mark, homes, makes the turns at the speed given and returns. Ends with PASS
    (status 0) or FAIL (status 1).
    """
    if not SLOWEST_RPS <= speed <= FASTEST_RPS:
        raise InputError(f"--speed is {speed:g} r/s, it must lie in {SLOWEST_RPS:g} .. {FASTEST_RPS:g}")
    check_outputs([json_path, page], [path for path in (rom_path, curve, subdivision) if path])
    rom = load_rom(rom_path)
    if rom.subdivision_table.any() != (subdivision is not None):
        has = "a second table: --subdivision CAL.json" if subdivision is None else "no second table: no --subdivision"
        raise InputError(f"{rom_path} has {has} was expected")
    turn, within_line = read_curve(curve), None
    if subdivision:
        within_line = SubdivisionCurve.from_calibration_json(subdivision)
        turn = without_subdivision(turn, within_line).curve
    fit = fit_from_provenance(turn, rom.provenance)

    def truth(angle_deg):
        error_arcsec = fit.evaluate(angle_deg)
        if within_line is None:
            return error_arcsec
        # The table's curve stands over the reading.
        phase_deg = np.mod((angle_deg + error_arcsec / 3600.0) * LINES_PER_TURN, 360.0)
        return error_arcsec + within_line.evaluate(phase_deg)

    result = _run_with_bar(
        rom,
        truth,
        knots=WITHIN_LINE_KNOTS if within_line else TURN_KNOTS,
        speed_rps=speed,
        revolutions=revolutions,
        samples_per_word=int(samples),
        folder=build_folder,
    )
    write_outputs(result, page, json_path)
    print_result(result, page)
    if not result.passed:
        raise click.exceptions.Exit(1)


def _run_with_bar(rom, curve, **options) -> ZeroReturnResult:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:.0f} %"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("compiling the core", total=None)

        def done(part: float) -> None:
            progress.update(task, description="turning", total=1.0, completed=part)

        return run_zero_return(rom, curve, progress=done, **options)
