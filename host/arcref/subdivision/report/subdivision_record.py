"""Everything the report of a subdivision calibration says, as one dictionary that JSON can hold."""

import csv
import io

import numpy as np

from arcref import __version__
from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE, arcsec_to_counts
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.metadata_key import CONDITIONS, IDENTIFICATION
from arcref.calibration.metadata_keys import KEYS_BY_NAME
from arcref.calibration.report.calibration_record import FORMAT, VERSION, stated_metadata
from arcref.calibration.report.findings_record import findings_record
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR
from arcref.correction_rom import CorrectionRom

COLUMNS = ("line_deg", "count", "error_arcsec", "error_counts", "u_arcsec", "expanded_k2_arcsec", "table_entry_counts")
"""Columns of the CSV table, which are the keys of a row in the record."""


def subdivision_record(result: CalibrationResult) -> dict:
    """The record. Units stand in the keys; uncertainties are standard ones (k=1) unless called expanded."""
    curve = result.curve
    return {
        "format": FORMAT,
        "version": VERSION,
        "kind": result.kind,
        "arcref_version": __version__,
        "resolution_arcsec": ARCSEC_PER_COUNT,
        "counts_per_line": COUNTS_PER_LINE,
        "passed": result.passed,
        "file": result.run.path.name,
        "identification": stated_metadata(result, IDENTIFICATION),
        "conditions": stated_metadata(result, CONDITIONS),
        "other_metadata": [
            {"label": key, "value": value} for key, value in result.run.metadata.items() if key not in KEYS_BY_NAME
        ],
        "error_peak_to_peak_arcsec": float(np.ptp(curve.error_arcsec)),
        "error_rms_arcsec": float(np.std(curve.error_arcsec)),
        "left_by_table_rms_arcsec": float(np.std(left_by_table(curve, _fine_deg()))),
        "table": _rows(result),
        **findings_record(result),
    }


def subdivision_csv(result: CalibrationResult) -> str:
    """The curve as CSV, `COLUMNS` under metadata lines; lines end in CRLF."""
    text = io.StringIO()
    name = " ".join(result.run.path.name.splitlines())
    text.write(f"# file: {name}\r\n# kind: {result.kind}\r\n")
    text.write(f"# expanded_corrected_angle_arcsec: {result.budget.expanded_arcsec:.6g}\r\n")
    for missing in result.budget.missing:
        text.write(f"# not_in_the_budget: {missing.name}\r\n")
    writer = csv.writer(text)
    writer.writerow(COLUMNS)
    for row in _rows(result):
        writer.writerow(["" if row[key] is None else row[key] for key in COLUMNS])
    return text.getvalue()


def line_table_of(curve) -> CorrectionRom:
    """The ROM with this curve in its second table and nothing in the first."""
    return CorrectionRom.from_fit(np.zeros_like, curve.evaluate, source="the curve")


def left_by_table(curve, line_deg: np.ndarray) -> np.ndarray:
    """What the second table, in whole counts, leaves of the curve at these phases, arcsec."""
    count = np.floor(np.mod(line_deg, 360.0) * (COUNTS_PER_LINE / 360.0)).astype(int)
    return curve.evaluate(line_deg) - line_table_of(curve).correction(count) * ARCSEC_PER_COUNT


def _fine_deg() -> np.ndarray:
    return (np.arange(COUNTS_PER_LINE) + 0.5) * (360.0 / COUNTS_PER_LINE)


def _rows(result: CalibrationResult) -> list[dict]:
    """One row for each point of the curve."""
    curve, table = result.curve, line_table_of(result.curve).subdivision_table
    u = [None] * curve.line_deg.size if curve.u_arcsec is None else [float(each) for each in curve.u_arcsec]
    count = np.mod(curve.line_deg, 360.0) * (COUNTS_PER_LINE / 360.0)
    return [
        {
            "line_deg": float(phase),
            "count": float(at),
            "error_arcsec": float(error),
            "error_counts": float(arcsec_to_counts(error)),
            "u_arcsec": own,
            "expanded_k2_arcsec": None if own is None else COVERAGE_FACTOR * own,
            "table_entry_counts": float(table[int(at) // 4]) / 16,
        }
        for phase, at, error, own in zip(curve.line_deg, count, curve.error_arcsec, u, strict=True)
    ]
