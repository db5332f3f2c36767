"""What a ROM image says about where its tables come from, and the fit made again from that."""

import math

import numpy as np

from arcref import __version__
from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE, LINES_PER_TURN, counts_to_deg
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.fits.fit_names import DEFAULT_FIT, fit_curve
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR
from arcref.error_curve import ErrorCurve
from arcref.subdivision_at_faces import TakenOff
from arcref.subdivision_curve import SubdivisionCurve

NO_UNCERTAINTY = "the input is a reduced curve that states no uncertainty"

BUDGET_BASIS = "the calibration's uncertainty budget of a corrected angle"

UNCERTAINTY_BASIS = (
    "largest of all corrected angles: the curve's standard uncertainty carried through the fit, the fit between the "
    "curve's angles, and rounding to a count"
)


def rom_provenance(
    fit: FittedCurve, subdivision: SubdivisionCurve | None = None, taken_off: TakenOff | None = None
) -> dict:
    """The provenance of the ROM made from these: serial, date, method, inputs, uncertainty, version of arcref.

    It depends on the inputs alone, never on the clock, so that the same inputs give the same image. Computed figures
    are rounded, because their last digits differ from machine to machine. An expanded uncertainty (k=2) that the
    inputs do not state is null, with the reason beside it. The ROM of a limited arc says where it corrects: `arc_deg`,
    and `corrected_lines`, the first and the last grating line whose entry is not left at 0.
    """
    curve = fit.curve
    method = {"name": fit.title, "fit": fit.name, "faces": len(curve.angle_deg)} | fit.parameters
    if fit.name == "rbf":
        method["condition_number"] = float(f"{fit.condition_number:.3g}")
    method["leave_one_out_rms_arcsec"] = round(fit.leave_one_out_rms_arcsec, 3)
    if curve.arc_deg is not None:
        method["arc_deg"] = list(curve.arc_deg)
        method["corrected_lines"] = list(corrected_lines(fit))
        method["outside_the_arc"] = "not measured, the table is 0"
    if taken_off is not None:
        method["subdivision_taken_off"] = taken_off.to_json()
    return {
        "encoder_serial": curve.provenance.get("encoder_serial"),
        "date": curve.provenance.get("date"),
        "method": method,
        "inputs": curve.provenance.get("inputs", []) + (subdivision.provenance["inputs"] if subdivision else []),
        **(_with_second_table(fit, subdivision) if subdivision else expanded_uncertainty(fit)),
        "arcref_version": __version__,
    }


def fit_from_provenance(curve: ErrorCurve, provenance: dict) -> FittedCurve:
    """`curve` fitted as the provenance of a ROM names it, so that the same curve gives the ROM's own fit again.

    What the provenance does not name takes its default. Raises `InputError` as the fit does.
    """
    method = provenance.get("method")
    named = method if isinstance(method, dict) else {}
    name = named.get("fit", DEFAULT_FIT)
    keys = _PARAMETERS.get(name, ()) if isinstance(name, str) else ()
    given = {key: named[key] for key in keys if type(named.get(key)) in (int, float)}
    if "order" in given:
        given["order"] = int(given["order"])
    return fit_curve(curve, name, **given)


_PARAMETERS = {
    "rbf": ("spread_deg", "ridge"),
    "fourier": ("order",),
    "gaussian-process": ("half_distance_deg", "signal_arcsec", "noise_arcsec"),
}


def line_middles_deg() -> np.ndarray:
    """The angles, in degrees, at which the entries of the line table stand, float64[4096]."""
    return counts_to_deg(np.arange(LINES_PER_TURN) * COUNTS_PER_LINE + COUNTS_PER_LINE / 2)


def corrected_lines(fit: FittedCurve) -> tuple[int, int]:
    """First and last grating line whose entry the fit gives; last below first when the arc goes over the zero."""
    covered = fit.covers(line_middles_deg())
    if covered.all():
        return 0, LINES_PER_TURN - 1
    before = np.roll(covered, 1)
    return int(np.argmax(covered & ~before)), int((np.argmax(~covered & before) - 1) % LINES_PER_TURN)


def expanded_uncertainty(fit: FittedCurve, stated=None) -> dict:
    """The expanded uncertainty (k=2) of a corrected angle with its basis, or null with the reason.

    It is that of the calibration's budget (`stated`, by default as the curve has it) when this is the fit it was made
    for. For another fit it is never less.
    """
    stated = fit.curve.provenance.get("expanded_uncertainty_arcsec") if stated is None else stated
    is_stated = type(stated) in (int, float) and stated > 0
    own = _carried_through(fit)
    if is_stated and fit.curve.provenance.get("fit") == {"name": fit.name, "parameters": fit.parameters}:
        value, basis = stated, BUDGET_BASIS
    elif own is None and not is_stated:
        return {"expanded_uncertainty_arcsec": None, "expanded_uncertainty_reason": NO_UNCERTAINTY}
    elif own is None or (is_stated and stated > own):
        value, basis = stated, f"{BUDGET_BASIS}, made for another fit"
    else:
        value, basis = own, UNCERTAINTY_BASIS
    return {"expanded_uncertainty_arcsec": float(f"{value:.3g}"), "expanded_uncertainty_basis": basis}


def _with_second_table(fit: FittedCurve, subdivision: SubdivisionCurve) -> dict:
    """The expanded uncertainty when the error within a line is corrected, too: the second table's own in its place."""
    without = fit.curve.provenance.get("expanded_without_interpolation_arcsec")
    expanded = expanded_uncertainty(fit) if without is None else expanded_uncertainty(fit, without)
    value, basis = expanded["expanded_uncertainty_arcsec"], expanded.get("expanded_uncertainty_basis")
    if value is None:
        return expanded
    if subdivision.u_arcsec is None:
        return expanded | {"expanded_uncertainty_basis": f"{basis}; the second table states none of its own"}
    # Once in the second table, and once in the first, where it was taken off the faces.
    value = math.hypot(value, COVERAGE_FACTOR * math.sqrt(2) * float(subdivision.u_arcsec.max()))
    return {
        "expanded_uncertainty_arcsec": float(f"{value:.3g}"),
        "expanded_uncertainty_basis": f"{basis}, and the largest of the second table",
    }


def _carried_through(fit: FittedCurve) -> float | None:
    """Twice the largest standard uncertainty over the turn, None when the curve states none."""
    angle_deg = line_middles_deg()
    u = fit.u_arcsec(angle_deg)
    if u is None:
        return None
    anywhere = np.nanmax(np.hypot(u, fit.interpolation_u_arcsec(angle_deg)))
    at_faces = np.nanmax(fit.u_arcsec(fit.curve.angle_deg))
    return COVERAGE_FACTOR * math.hypot(max(anywhere, at_faces), ARCSEC_PER_COUNT / math.sqrt(12))
