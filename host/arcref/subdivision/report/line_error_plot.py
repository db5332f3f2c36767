"""The plot that every calibration within a line has: the error over the line, before and after correction."""

import numpy as np

from arcref.angle import COUNTS_PER_LINE
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR
from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, STYLE, WIDTH_IN, svg
from arcref.subdivision.report.subdivision_record import left_by_table

_MOST_MARKS = 128


def line_error_plot(result: CalibrationResult) -> str:
    """Above the error with the band of its uncertainty, below what the table in whole counts leaves of it."""
    import matplotlib
    from matplotlib.figure import Figure

    curve = result.curve
    phase = (np.arange(COUNTS_PER_LINE) + 0.5) * (360.0 / COUNTS_PER_LINE)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 4.5), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        if curve.u_arcsec is not None:
            half = COVERAGE_FACTOR * curve.u_arcsec
            low, high = curve.error_arcsec - half, curve.error_arcsec + half
            name = "expanded uncertainty (k=2)"
            above.fill_between(curve.line_deg, low, high, color=BEFORE_COLOUR, alpha=0.2, linewidth=0, label=name)
        mark = "." if curve.line_deg.size <= _MOST_MARKS else ""
        above.plot(curve.line_deg, curve.error_arcsec, marker=mark, color=BEFORE_COLOUR, label="error as measured")
        above.axhline(0, color=INK, linewidth=0.7)
        above.set_ylabel("error / arcsec")
        above.set_title("before correction", pad=6)
        above.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
        expanded = result.budget.expanded_arcsec
        name = "expanded uncertainty, corrected (k=2)"
        below.axhspan(-expanded, expanded, color=AFTER_COLOUR, alpha=0.14, linewidth=0, label=name)
        left = left_by_table(curve, phase)
        below.plot(phase, left, color=AFTER_COLOUR, linewidth=0.6, label="curve less table, whole counts")
        below.axhline(0, color=INK, linewidth=0.7)
        limit = 1.2 * max(expanded, float(np.abs(left).max()))
        below.set_ylim(-limit, limit)
        below.set_ylabel("error / arcsec")
        below.set_title("after correction", pad=6)
        below.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2)
        below.set_xlim(0, 360)
        below.set_xticks(np.arange(0, 361, 45))
        below.set_xlabel("phase of the reading / deg of a line (0: the count is a multiple of a line)")
        figure.align_ylabels()
        return svg(figure, "line-error")
