"""`arcref rom`: from a calibration, or a published error curve, to the ROM image of the correction."""

import json
from pathlib import Path

import click

from arcref.atomic_file import write_files
from arcref.calibration.fits.fit_names import DEFAULT_FIT, FIT_NAMES, fit_curve
from arcref.correction_rom import ENTRY_LIMIT_ARCSEC, CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.output_files import check_outputs
from arcref.rom_figures import rom_figures
from arcref.rom_image import load_rom, rom_files
from arcref.rom_plot import rom_plot
from arcref.rom_provenance import rom_provenance
from arcref.rom_report import rom_report
from arcref.subdivision_at_faces import without_subdivision
from arcref.subdivision_curve import SubdivisionCurve

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("calibration", type=FILE, metavar="CAL.json|POLYGON.csv")
@click.option("--subdivision", type=FILE, metavar="CAL.json", help="Calibration of the error within a grating line.")
@click.option("-o", "--output", type=FILE, required=True, metavar="X.rom.json", help="ROM image to write.")
@click.option(
    "--fit",
    "fit_name",
    type=click.Choice(FIT_NAMES),
    default=DEFAULT_FIT,
    show_default=True,
    help="Curve through the errors.",
)
@click.option("--spread", type=float, metavar="DEG", help="Spread c of the RBF network.  [default: the face spacing]")
@click.option("--ridge", type=float, metavar="LAMBDA", help="RBF network: smooth instead of meeting each face exactly.")
@click.option("--order", type=int, metavar="N", help="Order of the Fourier series.  [default: a third of the faces]")
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the figures as JSON, too.")
@click.option("--plot", type=FILE, metavar="FILE.svg", help="Plot the curve, the fit and the table (svg, png or pdf).")
def rom(calibration, subdivision, output, fit_name, spread, ridge, order, json_path, plot):
    """Fit a calibration and write the ROM image of the correction.

    CAL.json is a calibration of kind polygon, closure or theodolite; POLYGON.csv a reduced curve with the columns
    position_deg,error_arcsec. Three .mem files for Verilog's $readmemh are written beside the image. Outside of a
    limited arc nothing is corrected. With --subdivision the error within a line goes into the second table, and what
    it put into the readings of CAL.json is taken off them before the fit.
    """
    if output.suffix != ".json":
        raise InputError(f"{output}: the name of a ROM image must end in .rom.json")
    parameters = _parameters(fit_name, {"spread_deg": spread, "ridge": ridge, "order": order})
    curve = read_curve(calibration)
    within_line = SubdivisionCurve.from_calibration_json(subdivision) if subdivision else None
    _refuse_large_errors(calibration, curve)
    taken_off = without_subdivision(curve, within_line) if within_line else None
    fit = fit_curve(taken_off.curve if taken_off else curve, fit_name, **parameters)
    image = CorrectionRom.from_fit(
        fit.evaluate,
        within_line.evaluate if within_line else None,
        rom_provenance(fit, within_line, taken_off),
        source=f"{calibration}" + (f" with {subdivision}" if subdivision else ""),
    )
    figures = rom_figures(fit, image) | {"taken_off_arcsec": taken_off and taken_off.largest_arcsec}
    files = rom_files(image, output)
    check_outputs([*files, plot, json_path], [calibration, subdivision])
    if plot:
        files[plot] = rom_plot(fit, image, plot)
    if json_path:
        files[json_path] = (json.dumps(figures | {"provenance": image.provenance}, indent=2) + "\n").encode()
    write_files(files)
    if load_rom(output) != image:
        click.echo(f"arcref: {output} does not read back as it was written", err=True)
        raise click.exceptions.Exit(1)
    click.echo(rom_report(calibration, fit, figures, image, files, taken_off), nl=False)


_FIT_OF_OPTION = {"spread_deg": ("--spread", "rbf"), "ridge": ("--ridge", "rbf"), "order": ("--order", "fourier")}


def _parameters(fit_name: str, options: dict) -> dict:
    """The options that were given, as parameters of the fit. Raises `InputError` for one of another fit."""
    given = {key: value for key, value in options.items() if value is not None}
    for key in given:
        option, belongs_to = _FIT_OF_OPTION[key]
        if belongs_to != fit_name:
            raise InputError(f"{option} belongs to --fit {belongs_to}, --fit {fit_name} was chosen")
    return given


def read_curve(path: Path) -> ErrorCurve:
    """A calibration over the turn, or a reduced curve. Raises `InputError` when the file cannot be used."""
    if path.suffix.lower() == ".json":
        return ErrorCurve.from_calibration_json(path)
    return ErrorCurve.from_polygon_csv(path)


def _refuse_large_errors(path: Path, curve: ErrorCurve) -> None:
    """Name the row of an error that no table entry can hold, before a fit spreads it over its neighbours."""
    for error, place in zip(curve.error_arcsec, curve.places, strict=True):
        if abs(error) > ENTRY_LIMIT_ARCSEC:
            problem = f"{error:g} arcsec, a table entry holds up to +-{ENTRY_LIMIT_ARCSEC:.1f} arcsec (+-2047.9 counts)"
            raise InputError.at(path, problem, **place)
