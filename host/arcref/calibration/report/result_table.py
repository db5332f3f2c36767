"""The table of results as CSV."""

import csv
import io

from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.report.calibration_record import calibration_record

COLUMNS = {
    "angle_deg": "angle_deg",
    "angle_dms": "angle_dms",
    "count": "count",
    "error_arcsec": "error_arcsec",
    "error_counts": "error_counts",
    "true_angle_dms": "true_angle_dms",
    "u_arcsec": "u_arcsec",
    "expanded_arcsec": "expanded_k2_arcsec",
    "correction_counts": "rom_correction_counts",
    "after_arcsec": "after_correction_arcsec",
    "fit_residual_arcsec": "fit_residual_arcsec",
    "leave_one_out_arcsec": "leave_one_out_arcsec",
}
"""Keys of a row in the record, and the columns they make, units in their names."""


def result_csv(result: CalibrationResult, as_left: CalibrationResult | None = None) -> str:
    """The table of one calibration, or of both runs under each other, a column saying which; lines end in CRLF.

    Metadata lines before it say what it is and state the expanded uncertainty of a corrected angle.
    """
    record = calibration_record(result, as_left)
    text = io.StringIO()
    writer = csv.writer(text)
    for run in record["runs"]:
        budget = run["budget"]
        prefix = "" if as_left is None else f"{run['label'].replace(' ', '_')}_"
        text.write(f"# {prefix}file: {_one_line(run['file'])}\r\n# {prefix}kind: {run['kind']}\r\n")
        text.write(f"# {prefix}expanded_corrected_angle_arcsec: {budget['expanded_arcsec']:.6g}\r\n")
        text.write(f"# {prefix}coverage_factor: {budget['coverage_factor']:g}\r\n")
        for missing in budget["missing"]:
            text.write(f"# {prefix}not_in_the_budget: {missing['name']}\r\n")
    writer.writerow((["run"] if as_left else []) + list(COLUMNS.values()))
    for run in record["runs"]:
        for row in run["table"]:
            cells = ["" if row[key] is None else row[key] for key in COLUMNS]
            writer.writerow(([run["label"]] if as_left else []) + cells)
    return text.getvalue()


def _one_line(text: str) -> str:
    return " ".join(text.splitlines())
