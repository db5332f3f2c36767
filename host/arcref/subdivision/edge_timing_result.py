"""`arcref calibrate subdivision` for edge times: the run's reduction, budget, limits and report."""

import math

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, ARCSEC_PER_TURN, LINES_PER_TURN
from arcref.calibration.calibration_result import CalibrationResult, ReportSection
from arcref.calibration.stated_values import stated_number
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget
from arcref.run_file import RunFile
from arcref.subdivision.count_plots import line_error_plot, ripple_plot
from arcref.subdivision.count_result import count_result, mean_u_arcsec, slope_arcsec_per_deg, wave_curve
from arcref.subdivision.edge_times_run import edge_times
from arcref.subdivision.edge_timing import EdgeTiming, edge_timing
from arcref.subdivision.ripple_limit import TOLERANCE_ARCSEC, RippleLimit, in_step, ripple_limits
from arcref.subdivision.samples_budget import table_contributions
from arcref.subdivision.subdivision_run import SubdivisionOptions

RIPPLE, RIPPLE_KEY = "speed ripple in step with the lines", "line_ripple_percent"

ARCSEC_PER_PERCENT = 0.01 * ARCSEC_PER_TURN / (2 * math.pi * LINES_PER_TURN)
"""Amplitude of the false error from 1 % of speed ripple that comes once a line: 0.504 arcsec."""


def edge_timing_result(run: RunFile, options: SubdivisionOptions) -> CalibrationResult:
    """The calibration. Raises `InputError` as `edge_times` does."""
    edges = edge_times(run)
    found = edge_timing(edges)
    limits = ripple_limits(found.solver)
    budget = _budget(run, found)
    ripple = [each.u_arcsec for each in budget.contributions if each.name == RIPPLE]
    curve = wave_curve(found.wave, math.hypot(*ripple))
    worst = in_step(limits)
    figures = [
        ("edges", f"{edges.time_s.size} in {edges.lines:.0f} lines, {'forward' if edges.direction > 0 else 'reverse'}"),
        ("speed", f"{abs(edges.speed_rps):.4g} r/s, ripple {100 * found.ripple:.3g} % rms, most {_order(found)}"),
        ("scatter", f"{found.noise_arcsec:.3f} arcsec an edge, {found.noise_arcsec / ARCSEC_PER_COUNT:.2f} counts"),
        (
            "limit",
            f"{worst.limit_percent:.3f} % of speed ripple once a line (order {LINES_PER_TURN} of the turn) would make "
            f"{TOLERANCE_ARCSEC:g} arcsec",
        ),
    ]
    sections = [_limit_section(limits)]
    if options.plots:
        error = found.residual_arcsec + found.wave.error_arcsec(edges.phase_rad)
        plot = line_error_plot(curve, edges.phase_rad, error, "edge-timing")
        sections.insert(0, ReportSection("Error within a line", plots=(plot,)))
        margin = (found.speed_rps.size - found.relative_speed.size) // 2
        plot = ripple_plot(found.angle_turns[margin:-margin], found.relative_speed, "speed-ripple")
        sections.append(ReportSection("Speed during the run", plots=(plot,)))
    return count_result(
        run,
        found.wave,
        curve,
        budget,
        method={"name": "edge timing", "orders": found.wave.orders, "knots": found.solver.motion.knots},
        paragraphs=(
            "The shaft turned at constant speed while the times of its counts were taken. At an edge the reading is "
            "known exactly; the true angle is where the shaft was at that time. What repeats with every grating line "
            "in their difference is the error within a line.",
            f"The motion is a cubic spline of time with {found.solver.motion.knots} knots, no closer than a line, "
            "which takes up slow ripple of the speed and the error over the turn; the error is a sum of "
            f"{found.wave.orders} orders. Both come from one least squares solution.",
            f"The uncertainty is that of the mean over {found.blocks} stretches of the run, from their own scatter.",
        ),
        figures=figures,
        results={
            "speed_rps": edges.speed_rps,
            "speed_ripple": found.ripple,
            "speed_ripple_order": found.ripple_order(),
            "noise_arcsec": found.noise_arcsec,
            "lines": edges.lines,
            "ripple_limits": [
                {
                    "order": each.order,
                    "false_arcsec_per_percent": each.false_arcsec,
                    "limit_percent": each.limit_percent,
                }
                for each in limits
            ],
        },
        warnings=_warnings(found),
        sections=sections,
        not_checked=(
            "Speed ripple in step with the lines: within one run nothing tells it from the error. A second run at "
            "another speed, or with the load's drive uncoupled, does; so does a fine scan.",
            "Whether the error within a line is the same all over the turn: the curve is the mean of the lines passed.",
        ),
    )


def _order(found: EdgeTiming) -> str:
    return f"at order {found.ripple_order():.3g} of the turn"


def _budget(run: RunFile, found: EdgeTiming) -> UncertaintyBudget:
    scatter = Contribution(
        "scatter of the run's stretches",
        "A",
        "normal",
        mean_u_arcsec(found.wave),
        "arcsec",
        1.0,
        f"{found.blocks} stretches of {found.edges.lines / found.blocks:.3g} lines",
        found.blocks - 1,
    )
    stretches = math.sqrt(found.blocks)
    change = Contribution(
        "change over the turn",
        "A",
        "normal",
        stretches * scatter.u,
        "arcsec",
        1.0,
        "scatter from stretch to stretch, the noise in it; one table serves all lines",
        found.blocks - 1,
    )
    measured = (scatter, change, *table_contributions(slope_arcsec_per_deg(found.wave)))
    percent = stated_number(run, RIPPLE_KEY)
    if percent is None:
        return UncertaintyBudget(measured, (MissingInput(RIPPLE, RIPPLE_KEY),))
    basis = f"stated amplitude {percent:g} %, 0.504 arcsec for each percent"
    ripple = Contribution(RIPPLE, "B", "arcsine", percent / math.sqrt(2), "%", ARCSEC_PER_PERCENT, basis)
    return UncertaintyBudget((*measured, ripple))


def _limit_section(limits: tuple[RippleLimit, ...]) -> ReportSection:
    return ReportSection(
        "Where edge timing fails",
        (
            "Ripple of the speed was put through the reduction of this very run: what 1 % of it (amplitude) adds to "
            f"the curve at most, and how much of it would make an error of {TOLERANCE_ARCSEC:g} arcsec. Slow ripple is "
            "taken up by the motion, ripple out of step with the lines averages out over them; ripple of order 4096, "
            "8192 ... of the turn is in step with them and goes into the curve whole.",
        ),
        ("ripples a turn", "from 1 % / arcsec", f"ripple for {TOLERANCE_ARCSEC:g} arcsec"),
        tuple((str(each.order), f"{each.false_arcsec:.5f}", _limit(each)) for each in limits),
    )


def _limit(limit: RippleLimit) -> str:
    return "beyond 100 %" if limit.limit_percent > 100 else f"{limit.limit_percent:.3f} %"


def _warnings(found: EdgeTiming) -> list[str]:
    warnings = []
    bunched = float(np.mean(np.diff(found.edges.time_s) == 0))
    if bunched > 0.05:
        warnings.append(
            f"{100 * bunched:.0f} % of the edges share their time with the edge before: the interpolator converts less "
            "often than the counts come. The curve holds if its conversions are not in step with the lines; turn "
            "slower to be sure."
        )
    if found.edges.lines < LINES_PER_TURN - 1:
        warnings.append(
            f"The run passes {found.edges.lines:.0f} of {LINES_PER_TURN} lines: the curve is theirs, and ripple close "
            "to order 4096 averages out only over longer runs."
        )
    return warnings
