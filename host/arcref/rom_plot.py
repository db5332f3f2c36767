"""Plot of a calibration: the errors at the faces, the fitted curve, and what the table of the ROM holds."""

import io
from pathlib import Path

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.correction_rom import FRACTION_BITS, CorrectionRom
from arcref.input_error import InputError
from arcref.rom_provenance import line_middles_deg

KINDS = (".svg", ".png", ".pdf")


def rom_plot(fit: FittedCurve, rom: CorrectionRom, path) -> bytes:
    """The plot as the content of a file; the ending of `path` (svg, png or pdf) says which kind.

    The same calibration gives the same bytes. Raises `InputError` for another ending.
    """
    kind = Path(path).suffix.lower()
    if kind not in KINDS:
        raise InputError(f"{path}: a plot's name must end in {', '.join(KINDS)}")
    # Imported here: it takes half a second, and most runs draw nothing.
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context({"svg.hashsalt": "arcref", "font.size": 9}):
        figure = Figure(figsize=(9, 6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        _draw_curve(above, fit, rom)
        _draw_difference(below, fit, rom)
        where, of = ("turn", "faces") if fit.curve.arc_deg is None else ("arc", "places")
        figure.suptitle(
            f"Error of the encoder over the {where}, {len(fit.curve.angle_deg)} {of}, CRC 0x{rom.crc32:08X}"
        )
        content = io.BytesIO()
        # No date in the file: the clock would make two runs differ.
        metadata = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(kind[1:])
        figure.savefig(content, format=kind[1:], metadata=metadata)
    return content.getvalue()


def _table_arcsec(rom: CorrectionRom) -> np.ndarray:
    return rom.line_table * (ARCSEC_PER_COUNT / (1 << FRACTION_BITS))


def _span_deg(fit: FittedCurve) -> tuple[float, float]:
    """What is shown: the turn, or the arc with a twentieth of it on either side, where the table is 0."""
    if fit.curve.arc_deg is None:
        return 0.0, 360.0
    first, last = fit.curve.arc_deg
    margin = min((last - first) / 20, (360 - last + first) / 2)
    return first - margin, last + margin


def _line_order(fit: FittedCurve) -> tuple[np.ndarray, np.ndarray]:
    """The grating lines from the left of the plot to its right, and their middles in degrees."""
    start = _span_deg(fit)[0]
    along = np.mod(line_middles_deg() - start, 360.0)
    order = np.argsort(along)
    return order, start + along[order]


def _draw_curve(axes, fit: FittedCurve, rom: CorrectionRom) -> None:
    order, line_deg = _line_order(fit)
    axes.plot(line_deg, _table_arcsec(rom)[order], color="0.75", linewidth=5, label="ROM, one entry a grating line")
    start, end = _span_deg(fit)
    angle_deg = np.linspace(start, end, 1441)
    value = np.where(fit.covers(angle_deg), fit.evaluate(angle_deg), np.nan)
    axes.plot(angle_deg, value, color="C0", label=_label(fit))
    curve = fit.curve
    if curve.u_arcsec is not None:
        u = np.hypot(fit.u_arcsec(angle_deg), fit.interpolation_u_arcsec(angle_deg))
        axes.fill_between(angle_deg, value - 2 * u, value + 2 * u, color="C0", alpha=0.15, linewidth=0)
    expanded = None if curve.u_arcsec is None else 2 * curve.u_arcsec
    label = "reading" if expanded is None else "reading with expanded uncertainty (k=2)"
    reading_deg = start + np.mod(curve.angle_deg - start, 360.0)
    axes.errorbar(reading_deg, curve.error_arcsec, expanded, fmt="o", color="C3", label=label)
    axes.set_ylabel("error / arcsec")
    axes.grid(alpha=0.3)
    axes.legend(loc="best")


def _label(fit: FittedCurve) -> str:
    spread = f", spread {fit.parameters['spread_deg']:.4g} deg" if "spread_deg" in fit.parameters else ""
    return fit.title + spread


def _draw_difference(axes, fit: FittedCurve, rom: CorrectionRom) -> None:
    order, line_deg = _line_order(fit)
    difference = np.where(fit.covers(line_deg), _table_arcsec(rom)[order] - fit.evaluate(line_deg), np.nan)
    axes.plot(line_deg, difference * 1000, linewidth=0.5, color="C0")
    axes.set_ylabel("ROM - fit\n/ 0.001 arcsec")
    axes.set_xlabel("angle / deg")
    axes.set_xlim(*_span_deg(fit))
    if fit.curve.arc_deg is None:
        axes.set_xticks(range(0, 361, 30))
    axes.grid(alpha=0.3)
