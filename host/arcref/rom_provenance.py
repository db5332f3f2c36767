"""What a ROM image says about where its tables come from."""

from arcref import __version__
from arcref.error_curve import ErrorCurve
from arcref.radial_basis_network import RadialBasisNetwork
from arcref.subdivision_curve import SubdivisionCurve

NO_UNCERTAINTY = "the input is a reduced curve that states no uncertainty"

UNCERTAINTY_BASIS = "twice the largest standard uncertainty of the curve at its faces; between faces the fit adds to it"


def rom_provenance(curve: ErrorCurve, network: RadialBasisNetwork, subdivision: SubdivisionCurve | None = None) -> dict:
    """The provenance of the ROM made from these: serial, date, method, inputs, uncertainty, version of arcref.

    It depends on the inputs alone, never on the clock, so that the same inputs give the same image. Computed figures
    are rounded, because their last digits differ from machine to machine. An expanded uncertainty (k=2) that the
    inputs do not state is null, with the reason beside it.
    """
    method = {
        "name": "wrapped RBF network" if network.wrapped else "plain RBF network",
        "faces": len(curve.angle_deg),
        "spread_deg": network.spread_deg,
        "ridge": network.ridge,
        "condition_number": float(f"{network.condition_number:.3g}"),
        "leave_one_out_rms_arcsec": round(network.leave_one_out_rms_arcsec, 3),
    }
    return {
        "encoder_serial": curve.provenance.get("encoder_serial"),
        "date": curve.provenance.get("date"),
        "method": method,
        "inputs": curve.provenance.get("inputs", []) + (subdivision.provenance["inputs"] if subdivision else []),
        **expanded_uncertainty(curve),
        "arcref_version": __version__,
    }


def expanded_uncertainty(curve: ErrorCurve) -> dict:
    """The expanded uncertainty (k=2) that `curve` states, with its basis, or null with the reason."""
    if curve.u_arcsec is None:
        return {"expanded_uncertainty_arcsec": None, "expanded_uncertainty_reason": NO_UNCERTAINTY}
    return {
        "expanded_uncertainty_arcsec": float(f"{2 * curve.u_arcsec.max():.6g}"),
        "expanded_uncertainty_basis": UNCERTAINTY_BASIS,
    }
