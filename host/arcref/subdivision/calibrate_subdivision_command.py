"""`arcref calibrate subdivision`: the error within a grating line, from signals, edge times or a fine scan."""

from pathlib import Path

import click

from arcref.calibration.calibration_output import OutputOptions, finish_calibration
from arcref.input_error import InputError
from arcref.subdivision.identification.identification import USUAL_ORDERS
from arcref.subdivision.identification.identification_names import DEFAULT_METHOD, METHODS
from arcref.subdivision.subdivision_run import SAMPLES, SubdivisionOptions, read_subdivision_run

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("run", type=FILE, metavar="RUN.csv")
@click.option("-o", "--output", type=FILE, required=True, metavar="CAL.json", help="Calibration to write.")
@click.option("--report", type=FILE, metavar="R.html", help="Write the report, one page to read and print.")
@click.option("--json", "json_path", type=FILE, metavar="FILE.json", help="Write everything that was found.")
@click.option("--csv", "csv_path", type=FILE, metavar="FILE.csv", help="Write the error curve as a table.")
@click.option(
    "--method",
    type=click.Choice(tuple(METHODS)),
    help=f"How the signals' parameters are identified (samples).  [default: {DEFAULT_METHOD}]",
)
@click.option("--orders", metavar="1,3,5", help="Harmonics of the signal model (samples).  [default: 1,3,5]")
@click.option("--compare", is_flag=True, help="Identify by every method and compare what they find (samples).")
@click.option("--seed", type=click.IntRange(min=0), help="Of the particle swarm's random numbers.  [default: 1]")
def subdivision(run, output, report, json_path, csv_path, method, orders, compare, seed):
    """Calibrate the error within a grating line, for the second table of the ROM.

    RUN.csv holds samples of the signals (sample or time_s, sine_v, cosine_v), or where there are only counts, edge
    times at constant speed (count, time_s) or a scan of one face (count, autocollimator_x_arcsec).
    """
    options = OutputOptions(run, output, report, json_path, csv_path)
    options.check()
    given = {"method": method, "orders": orders and read_orders(orders), "compare": compare or None, "seed": seed}
    given = {name: value for name, value in given.items() if value is not None}
    kind, run_file = read_subdivision_run(run)
    if given and kind is not SAMPLES:
        raise InputError(f"--{next(iter(given))} belongs to samples of the signals, {run} holds a run of {kind.name}")
    finish_calibration(kind.reduce(run_file, SubdivisionOptions(**given, plots=report is not None)), options)


HIGHEST_ORDER = 31


def read_orders(text: str) -> tuple[int, ...]:
    """Orders written as `1,3,5`, increasing. Raises `InputError` for anything else, or without order 1."""
    cells = [cell.strip() for cell in text.split(",")]
    if not all(cell.isascii() and cell.isdigit() and len(cell) < 4 for cell in cells):
        raise InputError(f"--orders {text}: whole numbers with commas between them were expected, as in 1,3,5")
    orders = tuple(sorted(set(map(int, cells))))
    if len(orders) != len(cells) or orders[0] != USUAL_ORDERS[0] or orders[-1] > HIGHEST_ORDER:
        raise InputError(f"--orders {text}: each once, 1 among them, none above {HIGHEST_ORDER} were expected")
    return orders
