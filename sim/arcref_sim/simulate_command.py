"""`arcref simulate`: tests on the simulated instrument."""

import json
import sys
from pathlib import Path

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from arcref.atomic_file import write_files
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.radial_basis_network import RadialBasisNetwork
from arcref.rom_image import load_rom
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_sim.zero_return import WORD_CLOCK_HZ, ZeroReturnPlan
from arcref_sim.zero_return_figures import figures, figures_by_name
from arcref_sim.zero_return_page import zero_return_page
from arcref_sim.zero_return_run import run_zero_return

FILE = click.Path(path_type=Path)

SLOWEST_RPS = 0.1
FASTEST_RPS = 500.0


@click.group()
def simulate():
    """Run tests on the simulated instrument."""


@simulate.command("zero-return")
@click.option("--speed", type=float, default=10.0, show_default=True, metavar="RPS", help="Turns a second.")
@click.option("--revolutions", type=click.IntRange(1, 1000), default=10, show_default=True, help="Turns each way.")
@click.option(
    "--samples",
    type=click.Choice([str(samples) for samples in SAMPLES_PER_WORD]),
    default="4",
    show_default=True,
    help=f"Samples a word, at {WORD_CLOCK_HZ // 1_000_000} M words a second.",
)
@click.option("--rom", "rom_path", type=FILE, required=True, metavar="X.rom.json", help="ROM image of the correction.")
@click.option("--curve", type=FILE, required=True, metavar="POLYGON.csv", help="The error that the encoder truly has.")
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the figures as JSON, too.")
@click.option("--page", type=FILE, metavar="FILE.html", help="Write a page with figures and plots.")
def zero_return(speed, revolutions, samples, rom_path, curve, json_path, page):
    """Turn forward and back and account for every count.

    Ends with status 0 for PASS and 1 for FAIL.
    """
    if not SLOWEST_RPS <= speed <= FASTEST_RPS:
        raise InputError(f"--speed is {speed:g} r/s, it must lie in {SLOWEST_RPS:g} .. {FASTEST_RPS:g}")
    network = RadialBasisNetwork.fit(ErrorCurve.from_polygon_csv(curve))
    plan = ZeroReturnPlan(load_rom(rom_path), network.evaluate, speed, revolutions, int(samples))
    result = _run(plan)
    files = {}
    if json_path:
        files[json_path] = (json.dumps(figures_by_name(result), indent=2) + "\n").encode()
    if page:
        files[page] = zero_return_page(result).encode()
    write_files(files)
    _print(result, page)
    sys.exit(0 if result.passed else 1)


def _run(plan: ZeroReturnPlan):
    console = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.percentage:>3.0f} %"))
    with Progress(*columns, TimeRemainingColumn(), console=console, transient=True) as progress:
        task = progress.add_task("building the core", total=None)

        def advance(part: float):
            progress.update(task, description="turning", total=1.0, completed=part)

        return run_zero_return(plan, advance)


def _print(result, page: Path | None) -> None:
    table = Table(box=None, show_header=False, pad_edge=False, padding=(0, 2, 0, 0))
    for name, value in figures(result):
        table.add_row(name, value)
    console = Console(width=100, highlight=False)
    console.print(table)
    for sentence, passed in result.checks.items():
        if not passed:
            console.print(f"FAILED: {sentence}", style="red", markup=False)
    if result.first_difference:
        console.print(f"first difference: {result.first_difference}", markup=False)
    if page:
        console.print(f"page: {page}", markup=False)
    console.print("PASS" if result.passed else "FAIL", style="bold green" if result.passed else "bold red")
