"""`arcref calibrate theodolite`: the encoder's error over an arc, from a mirror and an autocollimating theodolite."""

import math
from pathlib import Path

import click

from arcref.calibration.calibration_output import OutputOptions, calibration_options, finish_calibration
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.fit_options import FitOptions, second_curve
from arcref.calibration.theodolite_result import theodolite_result
from arcref.calibration.theodolite_run import ZENITH, read_theodolite_run
from arcref.input_error import InputError
from arcref.input_file import read_input_file


@click.command()
@calibration_options
@click.option(
    "--require",
    type=click.FloatRange(min=0, min_open=True),
    metavar="ARCSEC",
    help="Refuse an arc that leaves the error less certain than this anywhere (expanded, k=2).",
)
def theodolite(run, output, report, json_path, csv_path, as_left, verify, fit, compare, require):
    """Calibrate over an arc with a plane mirror and an autocollimating theodolite.

    RUN.csv has the columns reading_deg,azimuth_deg,zenith_deg and, if wanted, round. The elevations tell where axis and
    mirror stand, and the azimuths then the true angle. Outside the arc nothing will be corrected.
    """
    options = OutputOptions(run, output, report, json_path, csv_path, as_left, verify, fit, compare)
    options.check()
    if require is not None and not math.isfinite(require):
        raise InputError(f"--require: {require:g} is not a finite number")

    def calibrated(path: Path, fit_options: FitOptions) -> CalibrationResult:
        return theodolite_result(read_theodolite_run(path), fit_options, require)

    second = second_curve(verify, ZENITH, lambda path: calibrated(path, FitOptions(fit)).curve)
    result = calibrated(run, FitOptions(fit, compare, second, report is not None))
    if verify is not None:
        result.provenance["verified_with"] = read_input_file(verify).record
    left = None if as_left is None else calibrated(as_left, FitOptions(fit, compare, None, report is not None))
    finish_calibration(result, options, left)
