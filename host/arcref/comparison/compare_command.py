"""`arcref compare`: an encoder under test against the reference, at speed."""

import json
from pathlib import Path

import click
import numpy as np
from rich.console import Console
from rich.table import Table

from arcref import __version__
from arcref.atomic_file import write_files
from arcref.comparison.comparison_plot import FORMATS, comparison_plot
from arcref.comparison.dynamic_error import DEFAULT_HIGHEST_ORDER, DynamicError, dynamic_error
from arcref.comparison.paired_readings import join_pairs, read_pairs
from arcref.input_error import InputError
from arcref.output_files import check_outputs

FILE = click.Path(path_type=Path)


@click.command()
@click.argument("files", nargs=-1, required=True, type=FILE, metavar="CAPTURE DUT.csv [CAPTURE DUT.csv]...")
@click.option(
    "--orders",
    type=click.IntRange(1, 180),
    default=DEFAULT_HIGHEST_ORDER,
    show_default=True,
    help="Highest harmonic of the error of angle.",
)
@click.option("--plot", type=FILE, metavar="FILE.svg", help="Plot it (svg, png or pdf).")
@click.option("--json", "json_path", type=FILE, metavar="FILE", help="Write the figures as JSON.")
@click.option("--csv", "csv_path", type=FILE, metavar="FILE", help="Write the error of angle as a table.")
def compare(files, orders, plot, json_path, csv_path):
    """Compare an encoder under test with the reference, strobe by strobe.

    CAPTURE is a file of `arcref capture`; DUT.csv has the column reading_deg, one row for each strobe, and perhaps
    strobe. Name a pair for each speed, or capture several speeds into one. From two speeds on, the delay of the
    encoder under test is told from its error of angle.
    """
    if len(files) % 2:
        raise InputError(
            f"{len(files)} files were named; a capture file and a file of readings each time were expected"
        )
    if plot and plot.suffix.lower().lstrip(".") not in FORMATS:
        raise InputError(f"{plot}: the name of a plot must end in .{', .'.join(FORMATS)}")
    check_outputs([plot, json_path, csv_path], files)
    pairs = join_pairs([read_pairs(*files[i : i + 2]) for i in range(0, len(files), 2)])
    result = dynamic_error(pairs, orders)
    written = {}
    if plot:
        written[plot] = comparison_plot(result, plot.suffix.lower().lstrip("."))
    if json_path:
        written[json_path] = (json.dumps(comparison_figures(result), indent=2) + "\n").encode()
    if csv_path:
        written[csv_path] = _csv(result).encode()
    write_files(written)
    _print(result, list(written))


def comparison_figures(result: DynamicError) -> dict:
    """The figures of a comparison by name; standard uncertainties unless the name says expanded."""
    angle, degrees = np.arange(0.0, 360.0, 0.25), np.arange(0.0, 360.0)
    error = result.angle_error_arcsec(angle)
    return {
        "strobes": len(result.pairs),
        "delay_us": None if result.delay_s is None else 1e6 * result.delay_s,
        "u_delay_us": None if result.u_delay_s is None else 1e6 * result.u_delay_s,
        "angle_error_rms_arcsec": float(np.sqrt(np.mean(error**2))),
        "angle_error_peak_to_peak_arcsec": float(np.ptp(error)),
        "u_angle_error_arcsec": float(result.u_angle_error_arcsec(angle).max()),
        "noise_arcsec": result.noise_arcsec,
        "reference_expanded_uncertainty_arcsec": result.pairs.reference_expanded_arcsec,
        "speeds": [
            {
                "speed_rps": group.speed_rps,
                "strobes": group.strobes,
                "mean_arcsec": group.mean_arcsec,
                "rms_arcsec": group.rms_arcsec,
                "residual_rms_arcsec": group.residual_rms_arcsec,
                "apart_from_common_arcsec": group.apart_arcsec,
                "angle_error_arcsec": _rounded(result.angle_error_at_speed_arcsec(group, degrees)),
            }
            for group in result.groups
        ],
        "angle_deg": degrees.tolist(),
        "angle_error_arcsec": _rounded(result.angle_error_arcsec(degrees)),
        "cautions": list(result.cautions),
        "harmonics": [
            {
                "order": int(order),
                "amplitude_arcsec": float(np.hypot(c, s)),
                "phase_deg": float(np.degrees(np.arctan2(s, c))),
            }
            for order, c, s in zip(result.orders, result.cosine_arcsec, result.sine_arcsec, strict=True)
        ],
        "provenance": result.pairs.provenance | {"arcref_version": __version__},
    }


def _rounded(values: np.ndarray | None) -> list[float] | None:
    return None if values is None else [round(float(value), 4) for value in values]


def _csv(result: DynamicError) -> str:
    """The error of angle by all strobes, with its standard uncertainty, and by those of each speed alone."""
    angle = np.arange(0.0, 360.0)
    columns = {
        "error_arcsec": result.angle_error_arcsec(angle),
        "u_arcsec": result.u_angle_error_arcsec(angle),
    } | {
        f"error_at_{group.speed_rps:+.5g}_rps_arcsec": result.angle_error_at_speed_arcsec(group, angle)
        for group in result.groups
        if group.cosine_arcsec is not None
    }
    rows = zip(angle, *columns.values(), strict=True)
    lines = [f"{row[0]:g}," + ",".join(f"{value:.4f}" for value in row[1:]) for row in rows]
    return "\n".join([",".join(["position_deg", *columns]), *lines]) + "\n"


def _print(result: DynamicError, written: list[Path]) -> None:
    figures = comparison_figures(result)
    console = Console(highlight=False)
    table = Table(box=None, pad_edge=False)
    for head in ("speed r/s", "strobes", "mean arcsec", "rms about it", "rms left", "apart"):
        table.add_column(head, justify="right")
    for group in result.groups:
        table.add_row(
            f"{group.speed_rps:+.4f}",
            str(group.strobes),
            f"{group.mean_arcsec:+.3f}",
            f"{group.rms_arcsec:.3f}",
            f"{group.residual_rms_arcsec:.3f}",
            "-" if group.apart_arcsec is None else f"{group.apart_arcsec:.3f}",
        )
    console.print(table)
    if result.delay_s is None:
        console.print("delay                 not told from the zero: one speed alone was measured")
    else:
        console.print(
            f"delay                 {figures['delay_us']:.4f} us, U = {2 * figures['u_delay_us']:.4f} us (k=2)"
        )
    rms, peak_to_peak = figures["angle_error_rms_arcsec"], figures["angle_error_peak_to_peak_arcsec"]
    expanded = 2 * figures["u_angle_error_arcsec"]
    sizes = f"{rms:.3f} arcsec rms, {peak_to_peak:.3f} peak to peak"
    console.print(f"error of angle        {sizes}, U = {expanded:.3f} (k=2)")
    if any(group.apart_arcsec is not None for group in result.groups):
        console.print(
            "Apart: how far, rms over the turn, the error of angle at one speed is from that of all speeds together.",
            soft_wrap=True,
        )
    if result.delay_s is not None:
        console.print("The delay is that beside the reference, whose own the strobe delay takes off.", soft_wrap=True)
    if result.pairs.reference_expanded_arcsec is None:
        console.print("The reference's own uncertainty is not stated, so it is not in these figures.")
    for caution in result.cautions:
        console.print(f"Caution: {caution}.", soft_wrap=True, markup=False)
    for path in written:
        console.print(f"written               {path}", soft_wrap=True)
