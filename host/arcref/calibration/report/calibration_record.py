"""Everything a calibration's report says, as one dictionary that JSON can hold; the page takes each number from it."""

import numpy as np

from arcref import __version__
from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN, arcsec_to_counts, counts_to_deg, deg_to_counts, format_dms
from arcref.calibration.aliasing import aliases
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.harmonics import harmonics
from arcref.calibration.metadata_key import CONDITIONS, IDENTIFICATION
from arcref.calibration.metadata_keys import KEYS_BY_NAME, METADATA_KEYS
from arcref.calibration.report.characteristics import characteristics
from arcref.calibration.report.findings_record import findings_record, finite
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR

FORMAT = "arcref-calibration-report"
VERSION = 1

ASKED_FOR = ("encoder_serial", "date", "operator", "laboratory", "polygon_serial", "autocollimator_serial")
ASKED_FOR += ("theodolite_serial", "temperature_c")
"""What a report must identify: named as not stated when the run file does not state it."""


def calibration_record(result: CalibrationResult, as_left: CalibrationResult | None = None) -> dict:
    """The record of one calibration, or of the encoder as found (`result`) and as left.

    Lengths and angles carry their units in the keys; uncertainties are standard ones (k=1) unless called expanded;
    what is not known is null.
    """
    runs = [("as found", result), ("as left", as_left)] if as_left else [("calibration", result)]
    content = [_run(label, run) for label, run in runs]
    return {
        "format": FORMAT,
        "version": VERSION,
        "arcref_version": __version__,
        "resolution_arcsec": ARCSEC_PER_COUNT,
        "counts_per_turn": COUNTS_PER_TURN,
        "passed": all(run.passed for _, run in runs),
        "runs": content,
        "change_arcsec": _change(*content) if as_left else None,
    }


def corrected_by_rom_counts(fitted, angle_deg) -> np.ndarray:
    """What the ROM of `fitted` subtracts at these angles, whole counts: nearest to the error at the line's middle."""
    line = np.floor(np.mod(angle_deg, 360.0) * (COUNTS_PER_TURN / 360.0) / 2048.0)
    return np.floor(arcsec_to_counts(fitted.evaluate(counts_to_deg(line * 2048 + 1024))) + 0.5)


def _run(label: str, result: CalibrationResult) -> dict:
    curve, rows = result.curve, _rows(result)
    after = [row["after_arcsec"] for row in rows if row["after_arcsec"] is not None]
    return {
        "label": label,
        "kind": result.kind,
        "passed": result.passed,
        "file": result.run.path.name,
        "identification": stated_metadata(result, IDENTIFICATION),
        "conditions": stated_metadata(result, CONDITIONS),
        "other_metadata": [
            {"key": key, "label": key, "value": value}
            for key, value in result.run.metadata.items()
            if key not in KEYS_BY_NAME
        ],
        "statistics": {
            "angles": len(rows),
            "series": None if result.series is None else len(result.series.direction),
            "mean_arcsec": float(curve.error_arcsec.mean()),
            "sigma_arcsec": curve.statistics().sigma_arcsec,
            "peak_to_valley_arcsec": float(np.ptp(curve.error_arcsec)),
            "after_peak_to_valley_arcsec": float(np.ptp(after)) if after else None,
            "after_rms_arcsec": float(np.std(after)) if after else None,
        },
        "arc_deg": None if curve.arc_deg is None else list(curve.arc_deg),
        "characteristics": [
            {"key": each.key, "name": each.name, "value_arcsec": each.value_arcsec, "how": each.how}
            for each in characteristics(result)
        ],
        "table": rows,
        "series": _series(result),
        "fit": _fit(result.fitted),
        "harmonics": _harmonics(result),
        "aliases": _aliases(result),
        **findings_record(result),
    }


def _change(found: dict, left: dict) -> list[float] | None:
    """Error as left minus as found at each angle, None when the two runs were not read at the same angles."""
    if [row["angle_dms"] for row in found["table"]] != [row["angle_dms"] for row in left["table"]]:
        return None
    both = zip(found["table"], left["table"], strict=True)
    return [after["error_arcsec"] - before["error_arcsec"] for before, after in both]


def stated_metadata(result: CalibrationResult, group: str) -> list[dict]:
    """The metadata of a group in the order of the list of keys, with what was asked for and not stated."""
    rows = []
    for key in METADATA_KEYS:
        if key.group != group or result.kind not in key.kinds:
            continue
        value = result.run.metadata.get(key.name)
        if value or key.name in ASKED_FOR:
            rows.append({"key": key.name, "label": key.label, "value": value or None})
    return rows


def _rows(result: CalibrationResult) -> list[dict]:
    """The table of results, one row for each angle of the curve."""
    curve, fitted = result.curve, result.fitted
    nothing = [None] * curve.angle_deg.size
    u = nothing if curve.u_arcsec is None else curve.u_arcsec
    correction, residual, left_out = nothing, nothing, nothing
    if fitted is not None:
        correction = corrected_by_rom_counts(fitted, curve.angle_deg)
        residual, left_out = fitted.residual_arcsec, fitted.leave_one_out_arcsec
    return [
        {
            "angle_deg": float(angle),
            "angle_dms": format_dms(float(angle)),
            "count": int(deg_to_counts(angle)),
            "error_arcsec": float(error),
            "error_counts": float(arcsec_to_counts(error)),
            "true_angle_dms": format_dms(float(angle - error / 3600.0)),
            "u_arcsec": _number(own_u),
            "expanded_arcsec": None if own_u is None else COVERAGE_FACTOR * float(own_u),
            "correction_counts": None if counts is None else int(counts),
            "after_arcsec": None if counts is None else float(error - counts * ARCSEC_PER_COUNT),
            "fit_residual_arcsec": _number(remains),
            "leave_one_out_arcsec": _number(out),
        }
        for angle, error, own_u, counts, remains, out in zip(
            curve.angle_deg, curve.error_arcsec, u, correction, residual, left_out, strict=True
        )
    ]


def _series(result: CalibrationResult) -> list[dict]:
    series = result.series
    if series is None:
        return []
    closing = series.closing_error_arcsec
    return [
        {
            "direction": int(direction),
            "closing_error_arcsec": None if closing is None else _number(closing[index]),
            "error_arcsec": [_number(error) for error in series.error_arcsec[index]],
        }
        for index, direction in enumerate(series.direction)
    ]


def _fit(fitted) -> dict | None:
    if fitted is None:
        return None
    return {
        "name": fitted.name,
        "title": fitted.title,
        "parameters": fitted.parameters,
        "residual_rms_arcsec": float(np.sqrt(np.mean(fitted.residual_arcsec**2))),
        "leave_one_out_rms_arcsec": fitted.leave_one_out_rms_arcsec,
    }


def _harmonics(result: CalibrationResult) -> list[dict]:
    found = harmonics(result.curve)
    u = found.u_amplitude_arcsec
    fast = aliases(result.curve, found=found)
    return [
        {
            "order": int(order),
            "amplitude_arcsec": float(found.amplitude_arcsec[index]),
            "u_amplitude_arcsec": None if u is None else float(u[index]),
            "phase_deg": float(found.phase_deg[index]),
            "share": float(found.share[index]),
            "looks_like_orders": [each.order for each in fast if each.seen_order == order],
        }
        for index, order in enumerate(found.order)
    ]


def _aliases(result: CalibrationResult) -> list[dict]:
    return [
        {
            "order": each.order,
            "seen_order": each.seen_order,
            "amplitude_arcsec": each.amplitude_arcsec,
            "u_amplitude_arcsec": each.u_amplitude_arcsec,
            "share": each.share,
        }
        for each in aliases(result.curve)
    ]


def _number(value) -> float | None:
    """A number for JSON, which knows no NaN."""
    return None if value is None else finite(float(value))
