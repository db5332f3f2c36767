"""The figures of a correction ROM."""

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE, COUNTS_PER_TURN, arcsec_to_counts, counts_to_deg
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.correction_rom import FRACTION_BITS, CorrectionRom
from arcref.rom_provenance import corrected_lines, line_middles_deg


def rom_figures(fit: FittedCurve, image: CorrectionRom) -> dict:
    """The figures that `arcref rom` prints, by name; units stand in the names."""
    curve = fit.curve
    statistics = curve.statistics()
    counts = image.line_table / (1 << FRACTION_BITS)
    method = {"spread_deg": None, "ridge": None, "condition_number": None} | fit.parameters
    if fit.name == "rbf":
        method["condition_number"] = fit.condition_number
    return {
        "faces": statistics.n,
        "face_spacing_deg": curve.spacing_deg,
        "largest_gap_deg": float(curve.gaps_deg.max()),
        "closure_difference_arcsec": curve.closure_row and curve.closure_row[1] - float(curve.error_arcsec[0]),
        "error_mean_arcsec": statistics.mean_arcsec,
        "error_sigma_arcsec": statistics.sigma_arcsec,
        "error_peak_to_peak_arcsec": statistics.peak_to_peak_arcsec,
        "error_rms_arcsec": float(np.sqrt(np.mean(curve.error_arcsec**2))),
        "fit": fit.name,
        **method,
        "residual_at_faces_max_arcsec": float(np.abs(fit.residual_arcsec).max()),
        "leave_one_out_rms_arcsec": fit.leave_one_out_rms_arcsec,
        "table_min_counts": float(counts.min()),
        "table_max_counts": float(counts.max()),
        "table_min_arcsec": float(counts.min() * ARCSEC_PER_COUNT),
        "table_max_arcsec": float(counts.max() * ARCSEC_PER_COUNT),
        "rounding_max_counts": _rounding_counts(fit, image),
        **_arc_figures(fit, counts),
        "crc32": image.crc32,
    }


def _rounding_counts(fit: FittedCurve, image: CorrectionRom) -> float:
    """Largest difference of the correction from the fit, where there is a fit."""
    # The fit changes little within a line, so the ends and the middle of each cell show the largest difference.
    cell = np.arange(0, COUNTS_PER_TURN, COUNTS_PER_LINE)[fit.covers(line_middles_deg())]
    position = (cell[:, np.newaxis] + [0, COUNTS_PER_LINE // 2, COUNTS_PER_LINE - 1]).ravel()
    position = position[fit.covers(counts_to_deg(position))]
    fit_counts = arcsec_to_counts(fit.evaluate(counts_to_deg(position)))
    whole_line = CorrectionRom(image.line_table)  # the table of subdivision is no part of the fit
    return float(np.abs(whole_line.correction(position) - fit_counts).max())


def _arc_figures(fit: FittedCurve, counts: np.ndarray) -> dict:
    """Where the ROM of a limited arc corrects, and how far the position steps at the edges."""
    if fit.curve.arc_deg is None:
        return {}
    first, last = corrected_lines(fit)
    line_deg = counts_to_deg(COUNTS_PER_LINE)
    return {
        "arc_deg": list(fit.curve.arc_deg),
        "corrected_from_deg": first * line_deg,
        "corrected_to_deg": (last + 1) * line_deg,
        "corrected_lines": [first, last],
        "step_at_first_edge_arcsec": float(-counts[first] * ARCSEC_PER_COUNT),
        "step_at_last_edge_arcsec": float(counts[last] * ARCSEC_PER_COUNT),
    }
