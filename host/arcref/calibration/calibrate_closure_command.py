"""`arcref calibrate closure`: encoder and polygon calibrated together, and the plan of such a run."""

from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.calibration.calibration_output import OutputOptions, calibration_options, finish_calibration
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.closure_plan import ClosurePlan, plan_sentences
from arcref.calibration.closure_result import closure_result
from arcref.calibration.closure_run import SETTING, read_closure_run
from arcref.calibration.fit_options import FitOptions, second_curve
from arcref.input_error import InputError
from arcref.input_file import read_input_file

_BAR = 30


def _show_plan(context: click.Context, _parameter, value) -> None:
    """Print the plan and end, before RUN.csv and CAL.json are asked for."""
    if value is None or context.resilient_parsing:
        return
    faces, settings, step_deg = value
    print_plan(ClosurePlan.of(faces, _settings(settings), step_deg))
    context.exit()


@click.command()
@calibration_options
@click.option(
    "--sign", type=click.Choice(["+1", "-1"]), help="Sign of x, whatever the run file's autocollimator_sign says."
)
@click.option(
    "--plan",
    type=(int, str, float),
    metavar="FACES SETTINGS STEP_DEG",
    is_eager=True,
    expose_value=False,
    callback=_show_plan,
    help="Say what a run would separate, before it is taken; SETTINGS is how many, or 1,2,5 for their numbers.",
)
def closure(run, output, report, json_path, csv_path, as_left, verify, fit, compare, sign):
    """Calibrate encoder and polygon together, without a certificate.

    The polygon is set at several positions on the encoder; RUN.csv has the columns
    setting,face,position_deg,autocollimator_x_arcsec and, if wanted, round. The face deviations come with the encoder's
    errors.
    """
    options = OutputOptions(run, output, report, json_path, csv_path, as_left, verify, fit, compare)
    options.check()
    wanted = None if sign is None else int(sign)

    def calibrated(path: Path, fit_options: FitOptions) -> CalibrationResult:
        return closure_result(read_closure_run(path, wanted), fit_options)

    second = second_curve(verify, SETTING, lambda path: calibrated(path, FitOptions(fit)).curve)
    result = calibrated(run, FitOptions(fit, compare, second, report is not None))
    if verify is not None:
        result.provenance["verified_with"] = read_input_file(verify).record
    left = None if as_left is None else calibrated(as_left, FitOptions(fit, compare, None, report is not None))
    finish_calibration(result, options, left)


def print_plan(plan: ClosurePlan) -> None:
    """What the plan separates, and which settings would do better."""
    design = plan.design
    console = Console(highlight=False)
    title = f"Closure of {plan.faces} faces at {len(plan.settings)} settings, {plan.step_deg:g} deg apart"
    console.print(Text(title, "bold"))
    table = Table(show_header=False, box=None, pad_edge=False)
    for row in (
        ("readings", f"{design.readings} for {design.rank} unknowns, {design.degrees_of_freedom} left over"),
        ("positions", f"{len(design.position_deg)} of the encoder"),
        ("u of the encoder's error", f"{plan.u_per_reading:.3f} times that of one reading, about its mean"),
    ):
        table.add_row(*row)
    console.print(table)
    for sentence in plan_sentences(design):
        console.print(Text(sentence), soft_wrap=True)
    if design.degrees_of_freedom < 1:
        text = "No reading is left over: the run cannot show its own repeatability, nor a reading that is wrong."
        console.print(Text(text), soft_wrap=True)
    console.print(_orders_table(plan))
    better = plan.better()
    if better is not None:
        factor = better.largest_factor
        numbers = ",".join(map(str, better.settings))
        text = f"Better with as many settings: {numbers}, {better.step_deg:g} deg apart"
        text += (
            f", no order with more than {factor:.2f} times the noise of a whole set." if np.isfinite(factor) else "."
        )
        console.print(Text(f"{text}.", "green"), soft_wrap=True)


def _orders_table(plan: ClosurePlan) -> Table:
    design = plan.design
    top = max(2.0, float(np.nan_to_num(design.noise_factor).max()))
    table = Table(box=None, pad_edge=False)
    table.add_column("order", justify="right")
    table.add_column("noise", justify="right")
    table.add_column("(1: a whole set)")
    for order, factor in zip(design.orders, design.noise_factor, strict=True):
        lost = np.isnan(factor)
        bar = Text("cannot be told apart", "red") if lost else Text("=" * max(1, round(_BAR * factor / top)))
        table.add_row(str(order), "lost" if lost else f"{factor:.2f}", bar)
    return table


def _settings(text: str) -> tuple[int, ...]:
    """`5` is settings 1 .. 5, `1,2,5` those alone."""
    try:
        numbers = tuple(int(part) for part in text.split(","))
    except ValueError:
        raise InputError(f"--plan: {text!r} is neither how many settings nor their numbers, as in 1,2,5") from None
    if len(numbers) > 1:
        return numbers
    if not 2 <= numbers[0] <= 1000:
        raise InputError(f"--plan: {numbers[0]} settings, 2 .. 1000 were expected")
    return tuple(range(1, numbers[0] + 1))
