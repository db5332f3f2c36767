"""`arcref calibrate polygon`: the encoder's error from a polygon and an autocollimator."""

from dataclasses import replace
from pathlib import Path

import click

from arcref.calibration.calibration_output import OutputOptions, calibration_options, finish_calibration
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.fit_options import FitOptions, second_curve
from arcref.calibration.monte_carlo import FEWEST_RUNS
from arcref.calibration.polygon_mistakes import suspected_mistake
from arcref.calibration.polygon_reduction import PolygonReduction, reduce_polygon
from arcref.calibration.polygon_result import PolygonOptions, polygon_result
from arcref.calibration.polygon_run import X, read_polygon_run
from arcref.error_curve import ErrorCurve
from arcref.input_file import read_input_file

SIGNS = {"+1": 1, "-1": -1}


@click.command()
@calibration_options
@click.option(
    "--sign",
    type=click.Choice(list(SIGNS)),
    help="Sign of the autocollimator's x, in place of the run file's autocollimator_sign.",
)
@click.option(
    "--tilt-correction/--no-tilt-correction",
    default=True,
    help="Take tower tilt and roll off x when there are y readings.  [default: do]",
)
@click.option(
    "--monte-carlo",
    "monte_carlo_runs",
    type=click.IntRange(FEWEST_RUNS, 1_000_000),
    metavar="N",
    help=f"Repeat the whole reduction N times with every input drawn anew ({FEWEST_RUNS} or more).",
)
@click.option(
    "--accept-suspect", is_flag=True, help="Go on with a run that looks like an operator's mistake, and say so."
)
def polygon(
    run, output, report, json_path, csv_path, as_left, verify, fit, compare,
    sign, tilt_correction, monte_carlo_runs, accept_suspect,
):  # fmt: skip
    """Calibrate against a polygon and an autocollimator.

    RUN.csv has a row for each reading: position_deg or count, face_deviation_arcsec (from the certificate; may be left
    out), autocollimator_x_arcsec, autocollimator_y_arcsec (may be left out), and if wanted round and direction. The
    line "# faces: 24" before the column names tells the number of faces. A run that looks like an operator's mistake
    is refused with the reason, never repaired. Ends with status 1 when a check fails, a round that does not close for
    instance; the files are written even so.
    """
    files = OutputOptions(run, output, report, json_path, csv_path, as_left, verify, fit, compare)
    files.check()
    chosen_sign = None if sign is None else SIGNS[sign]

    def reduced(path: Path) -> tuple[PolygonReduction, str | None]:
        return reduced_run(path, chosen_sign, tilt_correction, accept_suspect)

    def calibrated(path: Path, options: PolygonOptions) -> CalibrationResult:
        reduction, suspicion = reduced(path)
        return polygon_result(reduction, replace(options, suspicion=suspicion))

    second = second_curve(verify, X, lambda path: reduced_curve(reduced(path)[0]))
    options = PolygonOptions(FitOptions(fit, compare, second, report is not None), monte_carlo_runs or 0, progress=True)
    result = calibrated(run, options)
    if verify is not None:
        result.provenance["verified_with"] = read_input_file(verify).record
    left = None
    if as_left is not None:
        left = calibrated(as_left, replace(options, fit=replace(options.fit, second=None)))
    finish_calibration(result, files, left)


def reduced_run(
    path: Path, sign: int | None, tilt_correction: bool, accept_suspect: bool
) -> tuple[PolygonReduction, str | None]:
    """The run at `path` reduced, and what was suspected of it if that is accepted.

    Raises `InputError` for a run that cannot be read, or that looks like a mistake which is not accepted.
    """
    run = read_polygon_run(path, sign)
    suspicion = suspected_mistake(run)
    if suspicion is not None and not accept_suspect:
        raise suspicion.error(run)
    told = None if suspicion is None else f"row {run.run.rows[suspicion.reading]}: {suspicion.problem}"
    return reduce_polygon(run, tilt_correction), told


def reduced_curve(reduction: PolygonReduction) -> ErrorCurve:
    """The errors alone, for a run that only verifies."""
    return ErrorCurve(reduction.angle_deg, reduction.error_arcsec)
