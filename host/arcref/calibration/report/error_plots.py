"""Plots of the error over the turn: before and after correction, around the circle, and the scatter of the readings."""

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.report.calibration_record import corrected_by_rom_counts
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR
from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, QUIET, READING_COLOUR, STYLE, WIDTH_IN, svg

_POINTS = 1441

_MARK = {"markersize": 3.5, "markeredgecolor": INK, "markeredgewidth": 0.5, "clip_on": False, "zorder": 3}


def error_plot(result: CalibrationResult, as_left: CalibrationResult | None = None) -> str:
    """Above the error as measured with the fit and its band, below what the correction leaves.

    With `as_left` the errors of both runs, each with its band: what was reached is then measured.
    """
    import matplotlib
    from matplotlib.figure import Figure

    has_fit = result.fitted is not None and as_left is None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 4.4 if has_fit else 2.8), layout="constrained")
        axes = figure.subplots(1 + has_fit, 1, sharex=True, squeeze=False, height_ratios=(3, 2)[: 1 + has_fit])[:, 0]
        if as_left:
            _draw_measured(axes[0], result, BEFORE_COLOUR, "as found")
            _draw_measured(axes[0], as_left, AFTER_COLOUR, "as left")
        else:
            _draw_measured(axes[0], result, BEFORE_COLOUR, "")
        axes[0].set_title("" if as_left else "before correction")
        _legend_above(axes[0])
        if has_fit:
            _draw_after(axes[1], result)
        axes[-1].set_xlabel("angle / deg")
        _angle_axis(axes[-1], as_left or result)
        figure.align_ylabels()
        return svg(figure, "error")


def polar_plot(result: CalibrationResult, as_left: CalibrationResult | None = None) -> str | None:
    """The error around the circle: outside the dashed circle it is positive. None for an arc, which has no circle."""
    if result.curve.arc_deg is not None:
        return None
    import matplotlib
    from matplotlib.figure import Figure

    runs = [(result, BEFORE_COLOUR, "as found" if as_left else "as measured")]
    if as_left:
        runs.append((as_left, AFTER_COLOUR, "as left"))
    elif result.fitted is not None:
        runs.append((None, AFTER_COLOUR, "after correction"))
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(3.6, 3.6), layout="constrained")
        axes = figure.add_subplot(projection="polar")
        shown = np.concatenate([each.curve.error_arcsec for each, _, _ in runs if each is not None] + [[0.0]])
        low, high = float(shown.min()), float(shown.max())
        span = high - low or 1.0
        for each, colour, label in runs:
            angle, error, marks = _around(each or result)
            if each is None:
                error = _after_at(result, angle)
            axes.plot(np.radians(angle), error, color=colour, label=label, linewidth=1.2)
            if each is not None:
                axes.plot(*marks, "o", color=colour, markersize=3)
        turn = np.linspace(0, 2 * np.pi, 361)
        axes.plot(turn, np.zeros_like(turn), "--", color=INK, linewidth=0.7)
        axes.set_rlim(low - 0.9 * span, high + 0.08 * span)
        ticks = matplotlib.ticker.MaxNLocator(4).tick_values(low, high)
        axes.set_rticks([tick for tick in ticks if low - 0.2 * span <= tick <= high + 0.05 * span])
        axes.set_rlabel_position(15)
        axes.tick_params(labelsize=7.5)
        axes.spines["polar"].set_visible(False)
        axes.set_theta_zero_location("N")
        axes.set_theta_direction(-1)
        axes.set_title("error / arcsec")
        figure.legend(loc="outside lower center", ncols=2)
        return svg(figure, "polar")


def residual_plot(result: CalibrationResult) -> str | None:
    """Each series less the mean of all, and what the fit leaves at each angle; None when there is neither."""
    import matplotlib
    from matplotlib.figure import Figure

    series, fitted = result.series, result.fitted
    several = series is not None and len(series.direction) > 1
    if not several and fitted is None:
        return None
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.4), layout="constrained")
        axes = figure.add_subplot()
        if several:
            error = series.error_arcsec - np.nanmean(series.error_arcsec, axis=1, keepdims=True)
            scatter = error - np.nanmean(error, axis=0)
            for way, marker, label in ((1, "^", "series forward"), (-1, "v", "series backward")):
                own = scatter[np.array(series.direction) == way]
                if own.size:
                    angle = np.broadcast_to(series.angle_deg, own.shape)
                    style = {"color": READING_COLOUR, "alpha": 0.55, "markersize": 3.5, "markeredgewidth": 0}
                    label = f"{label}, less the mean"
                    axes.plot(angle.ravel(), own.ravel(), marker, clip_on=False, label=label, **style)
        if fitted is not None:
            style = {"color": AFTER_COLOUR, "markersize": 2.5, "linewidth": 0.9}
            axes.plot(result.curve.angle_deg, fitted.residual_arcsec, "o-", label="mean less the fit", **style)
        axes.axhline(0, color=INK, linewidth=0.7)
        # An exact fit leaves rounding alone: a scale of 1e-15 would look like a finding.
        limit = max(1.1 * max(map(abs, axes.get_ylim())), ARCSEC_PER_COUNT / 2)
        axes.set_ylim(-limit, limit)
        axes.set_ylabel("residual / arcsec")
        axes.set_xlabel("angle / deg")
        _angle_axis(axes, result)
        _legend_above(axes)
        return svg(figure, "residual")


def _draw_measured(axes, result: CalibrationResult, colour: str, label: str) -> None:
    """The readings with the fit and its band. With a `label`, for two runs, the legend says no more than it must."""
    curve, fitted = result.curve, result.fitted
    if fitted is not None:
        angle = _fine_angles(result)
        error, u = fitted.evaluate(angle), fitted.u_arcsec(angle)
        if u is not None:
            half = COVERAGE_FACTOR * np.hypot(u, fitted.interpolation_u_arcsec(angle))
            name = f"{label}, k=2" if label else "expanded uncertainty of the curve (k=2)"
            axes.fill_between(angle, error - half, error + half, color=colour, alpha=0.2, linewidth=0, label=name)
        axes.plot(angle, error, color=colour, label=None if label else fitted.title)
    bars = None if fitted is not None or curve.u_arcsec is None else COVERAGE_FACTOR * curve.u_arcsec
    name = f"{label}, measured" if label else "measured" if bars is None else "measured, k=2"
    axes.errorbar(curve.angle_deg, curve.error_arcsec, bars, fmt="o", color=colour, elinewidth=1, label=name, **_MARK)
    axes.axhline(0, color=INK, linewidth=0.7)
    axes.set_ylabel("error / arcsec")


def _draw_after(axes, result: CalibrationResult) -> None:
    expanded = result.budget.expanded_arcsec
    name = "expanded uncertainty of a corrected angle (k=2)"
    axes.axhspan(-expanded, expanded, color=AFTER_COLOUR, alpha=0.14, linewidth=0, label=name)
    angle = _fine_angles(result)
    axes.plot(angle, _after_at(result, angle), color=AFTER_COLOUR, linewidth=0.5, alpha=0.7, label="fit less ROM")
    curve = result.curve
    after = curve.error_arcsec - corrected_by_rom_counts(result.fitted, curve.angle_deg) * ARCSEC_PER_COUNT
    axes.plot(curve.angle_deg, after, "o", color=AFTER_COLOUR, label="same readings less ROM", **_MARK)
    axes.axhline(0, color=INK, linewidth=0.7)
    limit = 1.5 * max(expanded, float(np.abs(after).max()), ARCSEC_PER_COUNT)
    axes.set_ylim(-limit, limit)
    axes.set_ylabel("error / arcsec")
    axes.set_title("after correction")
    _legend_above(axes)


def _after_at(result: CalibrationResult, angle_deg: np.ndarray) -> np.ndarray:
    fitted = result.fitted
    return fitted.evaluate(angle_deg) - corrected_by_rom_counts(fitted, angle_deg) * ARCSEC_PER_COUNT


def _fine_angles(result: CalibrationResult) -> np.ndarray:
    first, last = result.curve.arc_deg or (result.curve.angle_deg[0], result.curve.angle_deg[0] + 360.0)
    return np.linspace(first, last, _POINTS)


def _around(result: CalibrationResult):
    """Angles and errors of the line around the circle, and the measured points."""
    marks = (np.radians(result.curve.angle_deg), result.curve.error_arcsec)
    if result.fitted is None:
        angle, error = result.curve.angle_deg, result.curve.error_arcsec
        if result.curve.arc_deg is None:
            angle, error = np.append(angle, angle[0] + 360.0), np.append(error, error[0])
        return angle, error, marks
    angle = _fine_angles(result)
    return angle, result.fitted.evaluate(angle), marks


def _angle_axis(axes, result: CalibrationResult) -> None:
    angle = _fine_angles(result)
    margin = 0.0 if result.curve.arc_deg is None else 0.01 * (angle[-1] - angle[0])
    axes.set_xlim(angle[0] - margin, angle[-1] + margin)
    if result.curve.arc_deg is None:
        # A first angle a hair before zero begins at zero all the same.
        first = float(np.ceil(angle[0] / 30.0 - 0.1) * 30.0)
        axes.set_xticks(np.arange(first, angle[-1] + 3.0, 30.0))
        axes.set_xlim(min(first, angle[0]), max(angle[-1], axes.get_xticks()[-1]))


def _legend_above(axes) -> None:
    """The legend over the axes at the right, where it hides no reading."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, fontsize=7.5, labelcolor=QUIET,
                borderaxespad=0.2, columnspacing=1.2, handlelength=1.6)  # fmt: skip
