"""What the error within a grating line put into a calibration over the turn, taken off before the fit.

Each reading of a calibration holds the error within the line at its own phase. The 24 faces of a polygon meet a disc
of 4096 lines at three phases that return every 45 deg, so that a fit takes the error for one of order 8 of the turn.
When the second table corrects it, the first must not hold it, too.
"""

from dataclasses import dataclass, replace

import numpy as np

from arcref.angle import COUNTS_PER_TURN, LINES_PER_TURN
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.subdivision_curve import SubdivisionCurve

CORRECTED_KEY = "subdivision_corrected"
"""Metadata key of a run whose readings had already gone through the second table: yes or no."""


@dataclass(frozen=True, eq=False)
class TakenOff:
    """`curve`: the calibration without the error within the line; `part_arcsec`: float64[n], what was taken off.

    `basis`: at which phases, in words; `at_curve_angles`: the single readings are not known. The first angle's error
    is kept, as it is the datum of the others.
    """

    curve: ErrorCurve
    part_arcsec: np.ndarray
    basis: str
    at_curve_angles: bool = False

    @property
    def largest_arcsec(self) -> float:
        """The largest part, up or down."""
        return float(np.abs(self.part_arcsec).max())

    def to_json(self) -> dict:
        """For the provenance of a ROM."""
        return {"basis": self.basis, "part_arcsec": np.round(self.part_arcsec, 6).tolist()}


def without_subdivision(curve: ErrorCurve, within_line: SubdivisionCurve) -> TakenOff:
    """Take the error within the line off a calibration, at the phases of its readings.

    Where the curve does not know its single readings, its own angles stand for them. Nothing is taken off when the
    readings were corrected by the second table already. Raises `InputError` when a run states neither yes nor no.
    """
    if _already_corrected(curve):
        return TakenOff(curve, np.zeros(curve.angle_deg.size), "nothing: the readings were corrected already")
    if curve.readings_deg is None:
        readings, weight = curve.angle_deg[:, np.newaxis], np.ones(1)
        basis = "at the angles of the curve, its single readings are not known"
    else:
        # A count stands for its middle.
        readings, weight = curve.readings_deg + 180.0 / COUNTS_PER_TURN, curve.reading_weight
        basis = "at the phase of each reading"
    known = np.isfinite(readings)
    phase_deg = np.mod(np.where(known, readings, 0.0) * LINES_PER_TURN, 360.0)
    share = known * weight
    share = share / share.sum(axis=1, keepdims=True)
    mean = (share * within_line.evaluate(phase_deg)).sum(axis=1)
    part = mean - mean[0]
    u = curve.u_arcsec
    if u is not None and within_line.u_arcsec is not None:
        own = np.interp(phase_deg, within_line.line_deg, within_line.u_arcsec, period=360.0)
        u = np.hypot(u, (share * own).sum(axis=1))
    return TakenOff(
        replace(curve, error_arcsec=curve.error_arcsec - part, u_arcsec=u), part, basis, curve.readings_deg is None
    )


def _already_corrected(curve: ErrorCurve) -> bool:
    """What the run files behind the curve say of their readings."""
    for record in curve.provenance.get("inputs", []):
        provenance = record.get("provenance")
        runs = provenance.get("inputs") if isinstance(provenance, dict) else None
        for run in [record, *(runs if isinstance(runs, list) else [])]:
            metadata = run.get("metadata") if isinstance(run, dict) else None
            stated = metadata.get(CORRECTED_KEY, "no") if isinstance(metadata, dict) else "no"
            if stated not in ("yes", "no"):
                raise InputError(f"metadata {CORRECTED_KEY}: {stated!r}, yes or no was expected")
            if stated == "yes":
                return True
    return False
