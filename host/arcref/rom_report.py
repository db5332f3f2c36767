"""What `arcref rom` prints at the end."""

from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table
from rich.text import Text

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.correction_rom import FRACTION_BITS, CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.radial_basis_network import USABLE_SPREADS
from arcref.subdivision_at_faces import TakenOff

RESOLUTION_IS_NOT_ACCURACY = (
    f"Resolution is not accuracy: one count is {ARCSEC_PER_COUNT:.4f} arcsec; "
    "how true the angle is, only the calibration's uncertainty says."
)

_PLACE_WORDS = {False: ("face", "faces"), True: ("place", "places")}
"""What an angle of the curve is called, by whether it is of an arc: a theodolite's arc has no faces."""


def rom_report(
    calibration: Path,
    fit: FittedCurve,
    figures: dict,
    image: CorrectionRom,
    files: dict,
    taken_off: TakenOff | None = None,
) -> str:
    """The figures of `rom_figures` and what to mind, as lines of text; `files`: what was written."""
    table = Table(show_header=False, box=None, pad_edge=False)
    table.add_column(no_wrap=True)
    table.add_column(overflow="fold")
    for name, value in _lines(fit, figures, image, files, taken_off):
        table.add_row(name, Text(value))
    console = Console(highlight=False, soft_wrap=False)
    with console.capture() as capture:
        console.print(Text(f"Correction ROM from {calibration}", "bold"))
        console.print(table)
        for note in _notes(fit.curve, figures):
            console.print(Text(note))
        if taken_off and taken_off.at_curve_angles:
            console.print(
                Text(
                    "Caution: the error within a line was taken off at the angles of the curve. That is right only if "
                    "they count from the encoder's zero mark and the readings were taken within a few arcsec of them."
                )
            )
    return "".join(f"{line.rstrip()}\n" for line in capture.get().splitlines())


def _lines(fit: FittedCurve, figures: dict, image: CorrectionRom, files: dict, taken_off: TakenOff | None):
    f = figures
    _, places = _PLACE_WORDS["arc_deg" in f]
    yield places, f"{f['faces']}, {f['face_spacing_deg']:g} deg apart"
    if fit.curve.closure_row:
        yield "closure row", f"{f['closure_difference_arcsec']:+.2f} arcsec from the first row"
    if "arc_deg" in f:
        yield "arc", "{:g} .. {:g} deg, the table is 0 outside".format(*f["arc_deg"])
        yield (
            "corrected",
            "{:.4f} .. {:.4f} deg, grating lines {} .. {}".format(
                f["corrected_from_deg"], f["corrected_to_deg"], *f["corrected_lines"]
            ),
        )
    if taken_off:
        yield "taken off", f"error within a line, {taken_off.largest_arcsec:.3f} arcsec at most, {taken_off.basis}"
    yield "errors", f"sigma {f['error_sigma_arcsec']:.3f}, peak to peak {f['error_peak_to_peak_arcsec']:.2f} arcsec"
    yield "fit", fit.title
    if fit.name == "rbf":
        yield "spread c", f"{f['spread_deg']:g} deg, condition number {f['condition_number']:.3g}"
        yield "ridge", f"{f['ridge']:g}" if f["ridge"] else "0, exact interpolation"
    if fit.name == "gaussian-process":
        yield "kernel", f"one half at {f['half_distance_deg']:.3g} deg, {f['signal_arcsec']:.3g} arcsec"
    yield f"residual at the {places}", f"{f['residual_at_faces_max_arcsec']:.2g} arcsec at most"
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
    if taken_off:
        within_line = image.subdivision_table / (1 << FRACTION_BITS)
        low, high = within_line.min(), within_line.max()
        yield (
            "second table",
            f"{low:+.2f} .. {high:+.2f} counts, {low * ARCSEC_PER_COUNT:+.3f} .. {high * ARCSEC_PER_COUNT:+.3f} arcsec",
        )
    rounding = f["rounding_max_counts"]
    yield "rounding", f"{rounding:.3f} counts ({rounding * ARCSEC_PER_COUNT:.3f} arcsec) from the fit at most"
    expanded = image.provenance["expanded_uncertainty_arcsec"]
    basis = image.provenance.get("expanded_uncertainty_basis") or image.provenance["expanded_uncertainty_reason"]
    shown = "not stated" if expanded is None else f"{expanded:g} arcsec"
    yield "expanded uncertainty", f"{shown}: {basis}" if expanded is None else f"{shown} (k=2), {basis}"
    yield "CRC-32", f"0x{image.crc32:08X}, read back and right"
    yield "written", "\n".join(str(path) for path in files)


def _notes(curve: ErrorCurve, figures: dict):
    f = figures
    place, places = _PLACE_WORDS["arc_deg" in f]
    if f["leave_one_out_rms_arcsec"] > f["error_rms_arcsec"]:
        what = "another spread" if f["fit"] == "rbf" else "another fit"
        yield f"Caution: left out, a {place} is foretold worse by this fit than by no correction. Choose {what}."
    if f["fit"] == "rbf" and f["spread_deg"] < USABLE_SPREADS[0] * f["face_spacing_deg"] * (1 - 1e-9):
        yield f"Caution: with so small a spread the correction falls back to zero between the {places}."
    if "arc_deg" in f:
        start, end = (f"{f[key]:.4f} deg" for key in ("corrected_from_deg", "corrected_to_deg"))
        yield (
            "Caution: only {:g} .. {:g} deg was measured. Elsewhere nothing is corrected, and at the edges the "
            "corrected angle steps: by {:+.3f} arcsec at {} and {:+.3f} arcsec at {}, going forward."
        ).format(*f["arc_deg"], f["step_at_first_edge_arcsec"], start, f["step_at_last_edge_arcsec"], end)
    elif f["largest_gap_deg"] > 2 * f["face_spacing_deg"]:
        start = int(np.argmax(curve.gaps_deg))
        falls = (
            "; the correction falls back to zero there" if f["fit"] == "rbf" else "; the correction is a guess there"
        )
        yield (
            f"Caution: nothing was measured in the {f['largest_gap_deg']:g} deg behind "
            f"{curve.angle_deg[start]:g} deg{falls}."
        )
    if curve.u_arcsec is None:
        yield "No uncertainty was stated with this curve, so none is given for the corrected angle."
    yield RESOLUTION_IS_NOT_ACCURACY
