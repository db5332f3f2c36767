"""Plots of fits: one with its band, and several side by side."""

import numpy as np

from arcref.calibration.fit_comparison import FitComparison
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR
from arcref.plot_style import QUIET, READING_COLOUR, RIVAL_COLOURS, STYLE, WIDTH_IN, svg


def fit_plot(fit: FittedCurve) -> str:
    """The faces with their expanded uncertainty, the fit with its band, and below what leaving out shows; SVG text."""
    # Imported here: it takes half a second.
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 4.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1.3))
        angle_deg = _plot_angles(fit)
        value, u = fit.evaluate(angle_deg), fit.interpolation_u_arcsec(angle_deg)
        if fit.curve.u_arcsec is not None:
            u = np.hypot(u, fit.u_arcsec(angle_deg))
        edges = value - COVERAGE_FACTOR * u, value + COVERAGE_FACTOR * u
        band = "uncertainty between the faces, k=2"
        above.fill_between(angle_deg, *edges, color=RIVAL_COLOURS[0], alpha=0.2, linewidth=0, label=band)
        above.plot(angle_deg, value, color=RIVAL_COLOURS[0], label=fit.title)
        _draw_faces(above, fit)
        above.set_ylabel("error / arcsec")
        above.legend(loc="upper right", ncols=3, fontsize=8)
        above.margins(y=0.2)
        faces = fit.curve.angle_deg
        below.axhline(0, color=QUIET, linewidth=0.8)
        below.vlines(faces, 0, fit.leave_one_out_arcsec, color=RIVAL_COLOURS[1], linewidth=1)
        below.plot(faces, fit.leave_one_out_arcsec, "o", color=RIVAL_COLOURS[1], markersize=3.5, label="left out")
        below.plot(faces, fit.residual_arcsec, "o", color=RIVAL_COLOURS[0], markersize=3, label="in the sample")
        below.set_ylabel("residual / arcsec")
        below.legend(loc="upper right", ncols=2, fontsize=8)
        below.margins(y=0.35)
        _finish(below, fit)
        return svg(figure, "fit")


def comparison_plot(comparison: FitComparison) -> str:
    """The fits, their differences from the chosen one, what they leave of faces left out and of a second run; SVG."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        rows = 4 if comparison.second is not None else 3
        figure = Figure(figsize=(WIDTH_IN, 2.0 + 1.5 * rows), layout="constrained")
        axes = figure.subplots(rows, 1, sharex=True, height_ratios=[2] + [1.3] * (rows - 1))
        chosen = comparison.chosen
        angle_deg = _plot_angles(chosen)
        there = chosen.evaluate(angle_deg)
        shift = chosen.curve.spacing_deg / 12
        ruled = [figures for figures in comparison.figures if figures.fit is not None]
        for number, one in enumerate(ruled):
            fit, colour = one.fit, RIVAL_COLOURS[number % len(RIVAL_COLOURS)]
            value = fit.evaluate(angle_deg)
            front = len(ruled) - number  # the chosen one is drawn over the others
            axes[0].plot(angle_deg, value, color=colour, label=fit.title, zorder=2 + front)
            axes[1].plot(angle_deg, value - there, color=colour, zorder=2 + front)
            aside = (number - (len(ruled) - 1) / 2) * shift
            _draw_stems(axes[2], fit.curve.angle_deg + aside, fit.leave_one_out_arcsec, colour)
            if one.verification is not None:
                _draw_stems(axes[3], one.verification.angle_deg + aside, one.verification.left_arcsec, colour)
        _draw_faces(axes[0], chosen)
        axes[0].set_ylabel("error / arcsec")
        axes[0].margins(y=0.3)
        axes[0].legend(loc="upper right", ncols=3, fontsize=8)
        axes[1].set_ylabel("less chosen\n/ arcsec")
        axes[2].set_ylabel("face left out\n/ arcsec")
        if rows == 4:
            axes[3].set_ylabel("second run\n/ arcsec")
        _finish(axes[-1], chosen)
        return svg(figure, "fits")


def _plot_angles(fit: FittedCurve) -> np.ndarray:
    """Where the curve is drawn: from the first face on, over the turn or the arc."""
    first, last = fit.curve.arc_deg or (fit.curve.angle_deg[0], fit.curve.angle_deg[0] + 360.0)
    return np.linspace(first, last, 1441)


def _draw_faces(axes, fit: FittedCurve) -> None:
    u = fit.curve.u_arcsec
    expanded = None if u is None else COVERAGE_FACTOR * u
    axes.errorbar(
        fit.curve.angle_deg,
        fit.curve.error_arcsec,
        expanded,
        fmt="o",
        color=READING_COLOUR,
        markersize=3.5,
        elinewidth=1,
        label="faces" if u is None else "faces, k=2",
        zorder=9,
    )


def _draw_stems(axes, angle_deg: np.ndarray, value_arcsec: np.ndarray, colour: str) -> None:
    axes.vlines(angle_deg, 0, value_arcsec, color=colour, linewidth=1)
    axes.plot(angle_deg, value_arcsec, "o", color=colour, markersize=2.5)


def _finish(axes, fit: FittedCurve) -> None:
    axes.set_xlabel("angle / deg")
    first, last = fit.curve.arc_deg or (fit.curve.angle_deg[0], fit.curve.angle_deg[0] + 360.0)
    margin = (last - first) / 60
    axes.set_xlim(first - margin, last + margin)
    if fit.curve.arc_deg is None:
        axes.set_xticks(np.arange(0, 13) * 30 + 30 * np.ceil(first / 30))
        axes.set_xlim(first - margin, last + margin)
