"""`arcref rom`: from a calibration, or a published error curve, to the ROM image of the correction."""

import json
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE, COUNTS_PER_TURN, arcsec_to_counts, counts_to_deg
from arcref.atomic_file import write_files
from arcref.correction_rom import ENTRY_LIMIT_ARCSEC, FRACTION_BITS, CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.radial_basis_network import USABLE_SPREADS, RadialBasisNetwork
from arcref.rom_image import load_rom, rom_files
from arcref.rom_plot import rom_plot
from arcref.rom_provenance import rom_provenance
from arcref.subdivision_curve import SubdivisionCurve

FILE = click.Path(path_type=Path)

RESOLUTION_IS_NOT_ACCURACY = (
    f"Resolution is not accuracy: one count is {ARCSEC_PER_COUNT:.4f} arcsec; "
    "how true the angle is, only the calibration's uncertainty says."
)


@click.command()
@click.argument("calibration", type=FILE, metavar="CAL.json|POLYGON.csv")
@click.option("--subdivision", type=FILE, metavar="CAL.json", help="Calibration of the error within a grating line.")
@click.option("-o", "--output", type=FILE, required=True, metavar="X.rom.json", help="ROM image to write.")
@click.option("--spread", type=float, metavar="DEG", help="Spread c of the RBF network.  [default: the face spacing]")
@click.option("--ridge", type=float, default=0.0, metavar="LAMBDA", help="Smooth instead of meeting each face exactly.")
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the figures as JSON, too.")
@click.option("--plot", type=FILE, metavar="FILE.svg", help="Plot the curve, the fit and the table (svg, png or pdf).")
def rom(calibration, subdivision, output, spread, ridge, json_path, plot):
    """Fit a calibration and write the ROM image of the correction.

    CAL.json is a calibration of kind polygon, closure or theodolite; POLYGON.csv a reduced curve with the columns
    position_deg,error_arcsec. Three .mem files for Verilog's $readmemh are written beside the image.
    """
    if output.suffix != ".json":
        raise InputError(f"{output}: the name of a ROM image must end in .rom.json")
    curve = read_curve(calibration)
    within_line = SubdivisionCurve.from_calibration_json(subdivision) if subdivision else None
    _refuse_large_errors(calibration, curve)
    network = RadialBasisNetwork.fit(curve, spread, ridge)
    image = CorrectionRom.from_fit(
        network.evaluate,
        within_line.evaluate if within_line else None,
        rom_provenance(curve, network, within_line),
        source=f"{calibration}" + (f" with {subdivision}" if subdivision else ""),
    )
    figures = rom_figures(curve, network, image)
    files = rom_files(image, output)
    if plot:
        files[plot] = rom_plot(curve, network, image, plot)
    if json_path:
        files[json_path] = (json.dumps(figures | {"provenance": image.provenance}, indent=2) + "\n").encode()
    _refuse_overwriting([calibration, subdivision], list(rom_files(image, output)) + [plot, json_path])
    write_files(files)
    if load_rom(output) != image:
        click.echo(f"arcref: {output} does not read back as it was written", err=True)
        raise click.exceptions.Exit(1)
    click.echo(_report(calibration, curve, figures, image, files), nl=False)


def rom_figures(curve: ErrorCurve, network: RadialBasisNetwork, image: CorrectionRom) -> dict:
    """The figures that `arcref rom` prints, by name; units stand in the names."""
    statistics = curve.statistics()
    counts = image.line_table / (1 << FRACTION_BITS)
    # The fit changes little within a line, so the ends and the middle of each cell show the largest difference.
    cell = np.arange(0, COUNTS_PER_TURN, COUNTS_PER_LINE)[:, np.newaxis]
    position = (cell + [0, COUNTS_PER_LINE // 2, COUNTS_PER_LINE - 1]).ravel()
    fit_counts = arcsec_to_counts(network.evaluate(counts_to_deg(position)))
    whole_line = CorrectionRom(image.line_table)  # the table of subdivision is no part of the fit
    return {
        "faces": statistics.n,
        "face_spacing_deg": curve.spacing_deg,
        "largest_gap_deg": float(curve.gaps_deg.max()),
        "closure_difference_arcsec": curve.closure_row and curve.closure_row[1] - float(curve.error_arcsec[0]),
        "error_mean_arcsec": statistics.mean_arcsec,
        "error_sigma_arcsec": statistics.sigma_arcsec,
        "error_peak_to_peak_arcsec": statistics.peak_to_peak_arcsec,
        "error_rms_arcsec": float(np.sqrt(np.mean(curve.error_arcsec**2))),
        "spread_deg": network.spread_deg,
        "ridge": network.ridge,
        "condition_number": network.condition_number,
        "residual_at_faces_max_arcsec": float(np.abs(network.residual_arcsec).max()),
        "leave_one_out_rms_arcsec": network.leave_one_out_rms_arcsec,
        "table_min_counts": float(counts.min()),
        "table_max_counts": float(counts.max()),
        "table_min_arcsec": float(counts.min() * ARCSEC_PER_COUNT),
        "table_max_arcsec": float(counts.max() * ARCSEC_PER_COUNT),
        "rounding_max_counts": float(np.abs(whole_line.correction(position) - fit_counts).max()),
        "crc32": image.crc32,
    }


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


def _refuse_overwriting(inputs: list, outputs: list) -> None:
    """No output may take the place of an input, nor of another output."""
    taken = {path.resolve() for path in inputs if path}
    for path in filter(None, outputs):
        if path.resolve() in taken:
            raise InputError(f"{path}: this name is given to two files of this run")
        taken.add(path.resolve())


def _report(calibration: Path, curve: ErrorCurve, figures: dict, image: CorrectionRom, files: dict) -> str:
    """What a person reads at the end."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in _lines(curve, figures, image, files):
        table.add_row(name, Text(value))
    console = Console(highlight=False, soft_wrap=False)
    with console.capture() as capture:
        console.print(Text(f"Correction ROM from {calibration}", "bold"))
        console.print(table)
        for note in _notes(curve, figures, image):
            console.print(Text(note))
    return "".join(f"{line.rstrip()}\n" for line in capture.get().splitlines())


def _lines(curve: ErrorCurve, figures: dict, image: CorrectionRom, files: dict):
    f = figures
    yield "faces", f"{f['faces']}, {f['face_spacing_deg']:g} deg apart"
    if curve.closure_row:
        yield "closure row", f"{f['closure_difference_arcsec']:+.2f} arcsec from the first row"
    yield "errors", f"sigma {f['error_sigma_arcsec']:.3f}, peak to peak {f['error_peak_to_peak_arcsec']:.2f} arcsec"
    yield "spread c", f"{f['spread_deg']:g} deg, condition number {f['condition_number']:.3g}"
    yield "ridge", f"{f['ridge']:g}" if f["ridge"] else "0, exact interpolation"
    yield "residual at the faces", f"{f['residual_at_faces_max_arcsec']:.2g} arcsec at most"
    yield (
        "leave-one-out rms",
        (f"{f['leave_one_out_rms_arcsec']:.3f} arcsec (no correction: {f['error_rms_arcsec']:.3f} arcsec)"),
    )
    yield (
        "table",
        (
            f"{f['table_min_counts']:+.2f} .. {f['table_max_counts']:+.2f} counts, "
            f"{f['table_min_arcsec']:+.3f} .. {f['table_max_arcsec']:+.3f} arcsec"
        ),
    )
    rounding = f["rounding_max_counts"]
    yield "rounding", f"{rounding:.3f} counts ({rounding * ARCSEC_PER_COUNT:.3f} arcsec) from the fit at most"
    expanded = image.provenance["expanded_uncertainty_arcsec"]
    basis = image.provenance.get("expanded_uncertainty_basis") or image.provenance["expanded_uncertainty_reason"]
    shown = "not stated" if expanded is None else f"{expanded:g} arcsec"
    yield "expanded uncertainty", f"{shown}: {basis}" if expanded is None else f"{shown} (k=2), {basis}"
    yield "CRC-32", f"0x{image.crc32:08X}, read back and right"
    yield "written", "\n".join(str(path) for path in files)


def _notes(curve: ErrorCurve, figures: dict, image: CorrectionRom):
    if figures["leave_one_out_rms_arcsec"] > figures["error_rms_arcsec"]:
        yield "Caution: left out, a face is foretold worse by this fit than by no correction. Choose another spread."
    if figures["spread_deg"] < USABLE_SPREADS[0] * figures["face_spacing_deg"] * (1 - 1e-9):
        yield "Caution: with so small a spread the correction falls back to zero between the faces."
    if figures["largest_gap_deg"] > 2 * figures["face_spacing_deg"]:
        start = int(np.argmax(curve.gaps_deg))
        yield (
            f"Caution: nothing was measured in the {figures['largest_gap_deg']:g} deg behind "
            f"{curve.angle_deg[start]:g} deg; the correction falls back to zero there."
        )
    if curve.u_arcsec is None:
        yield "No uncertainty was stated with this curve, so none is given for the corrected angle."
    yield RESOLUTION_IS_NOT_ACCURACY
