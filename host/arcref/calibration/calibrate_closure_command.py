"""`arcref calibrate closure`: encoder and polygon calibrated together, and the plan of such a run."""

from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.calibration.calibration_output import OutputOptions, calibration_options, finish_calibration
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.closure_plan import ClosurePlan, plan_sentences, read_plan
from arcref.calibration.closure_result import closure_result
from arcref.calibration.closure_run import SETTING, read_closure_run
from arcref.calibration.fit_options import FitOptions, second_curve
from arcref.input_error import InputError
from arcref.input_file import read_input_file

_BAR = 30


@click.command()
@calibration_options
@click.option(
    "--sign", type=click.Choice(["+1", "-1"]), help="Sign of x, whatever the run file's autocollimator_sign says."
)
@click.option("--plan", is_flag=True, help="Say what a run would separate, before it is taken, and end.")
@click.option("--faces", type=int, metavar="N", help="For --plan: faces of the polygon.")
@click.option(
    "--settings", metavar="N|K,K,...", help="For --plan: how many settings, or their numbers.  [default: all]"
)
@click.option(
    "--setting-step", type=float, metavar="DEG", help="For --plan: from one to the next.  [default: face spacing]"
)
@click.pass_context
def closure(
    context, run, output, report, json_path, csv_path, as_left, verify, fit, compare,
    sign, plan, faces, settings, setting_step,
):  # fmt: skip
    """Calibrate encoder and polygon together, without a certificate.

    The polygon is set at several positions on the encoder; RUN.csv has the columns
    setting,face,position_deg,autocollimator_x_arcsec and, if wanted, round. The face deviations come with the encoder's
    errors. With --plan nothing is calibrated, and RUN.csv may hold setting and face alone, or be left out.
    """
    if plan:
        print_plan(read_plan(run) if run else plan_of_options(faces, settings, setting_step))
        return
    for parameter in context.command.params:
        if parameter.name in _NEEDED and context.params[parameter.name] is None:
            raise click.MissingParameter(ctx=context, param=parameter)
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


_NEEDED = ("run", "output")

# Needed by every run, but not by a plan.
for _parameter in closure.params:
    if _parameter.name in _NEEDED:
        _parameter.required = False


def plan_of_options(faces: int | None, settings: str | None, setting_step: float | None) -> ClosurePlan:
    """The plan that the options state. Raises `InputError` when they state none."""
    if faces is None:
        raise InputError("--plan needs --faces, or a run file that states them")
    if faces < 1:
        raise InputError(f"{faces} faces, 3 .. 360 were expected")
    numbers = _settings(settings) if settings is not None else tuple(range(1, faces + 1))
    return ClosurePlan.of(faces, numbers, 360.0 / faces if setting_step is None else setting_step)


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
        raise InputError(f"--settings: {text!r} is neither how many settings nor their numbers, as in 1,2,5") from None
    if len(numbers) > 1:
        return numbers
    if not 2 <= numbers[0] <= 1000:
        raise InputError(f"--settings: {numbers[0]} settings, 2 .. 1000 were expected")
    return tuple(range(1, numbers[0] + 1))
