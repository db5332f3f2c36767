"""Plots of a dynamic comparison: what was read, and how it splits into an error of angle and a delay."""

import io

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from arcref.angle import ARCSEC_PER_TURN
from arcref.comparison.dynamic_error import DynamicError
from arcref.plot_style import STYLE

FORMATS = ("svg", "png", "pdf")


def comparison_plot(result: DynamicError, image_format: str = "svg") -> bytes:
    """Plots below one another: differences as read over the angle, the error of angle with its k=2 band and that of
    each speed alone, and, where the speeds tell a delay, the mean of each speed with the line whose slope it is.
    """
    tells_delay = result.delay_s is not None
    with matplotlib.rc_context(STYLE):
        rows = 3 if tells_delay else 2
        figure = Figure(figsize=(8.5, 3.2 * rows), layout="constrained")
        axes = figure.subplots(rows, 1)
        _plot_read(axes[0], result)
        _plot_angle(axes[1], result)
        if tells_delay:
            _plot_delay(axes[2], result)
        buffer = io.BytesIO()
        metadata = {"Date": None} if image_format == "svg" else None
        figure.savefig(buffer, format=image_format, metadata=metadata, dpi=120)
    return buffer.getvalue()


def _plot_read(axes, result: DynamicError) -> None:
    pairs = result.pairs
    for group in result.groups:
        axes.plot(
            pairs.angle_deg[group.indices],
            pairs.difference_arcsec[group.indices],
            ".",
            markersize=2,
            label=f"{group.speed_rps:+.4g} r/s",
        )
    axes.set_title("As read: encoder under test less reference")
    _angle_axis(axes, "difference / arcsec")
    axes.legend(loc="lower right", bbox_to_anchor=(1, 1), fontsize=7, markerscale=4, ncols=min(len(result.groups), 6))


def _plot_angle(axes, result: DynamicError) -> None:
    angle = np.linspace(0, 360, 1441)
    error, expanded = result.angle_error_arcsec(angle), 2 * result.u_angle_error_arcsec(angle)
    axes.fill_between(angle, error - expanded, error + expanded, alpha=0.25, color="gray", label="k = 2")
    for group in result.groups:
        own = result.angle_error_at_speed_arcsec(group, angle)
        if own is not None and len(result.groups) > 1:
            axes.plot(angle, own, linewidth=0.7, label=f"at {group.speed_rps:+.4g} r/s alone")
    axes.plot(angle, error, color="black", label="error of angle, all speeds")
    axes.axhline(0, color="black", linewidth=0.6)
    alone = "; one speed alone cannot tell the delay from the zero"
    axes.set_title(f"Error of angle{alone if result.delay_s is None else ', the delay taken off'}")
    _angle_axis(axes, "error / arcsec")
    axes.legend(fontsize=7, ncols=2)


def _plot_delay(axes, result: DynamicError) -> None:
    speed = np.array([group.speed_rps for group in result.groups])
    # Strobes that do not cover whole turns evenly bring a part of the error of angle into their mean.
    of_angle = [result.angle_error_arcsec(result.pairs.angle_deg[group.indices]).mean() for group in result.groups]
    mean = np.array([group.mean_arcsec for group in result.groups]) - of_angle
    axes.plot(speed, mean, "o", label="mean of each speed, less the error of angle")
    line = np.array([min(speed.min(), 0.0), max(speed.max(), 0.0)])
    per_rps = ARCSEC_PER_TURN * result.delay_s
    axes.plot(line, result.zero_arcsec - per_rps * line, label=f"{-per_rps:.4g} arcsec per r/s")
    axes.set_title(f"Delay {1e6 * result.delay_s:.4f} us, k = 2: {2e6 * result.u_delay_s:.4f} us")
    axes.set(xlabel="speed / (r/s)", ylabel="mean difference / arcsec")
    axes.legend(loc="upper right", fontsize=7)


def _angle_axis(axes, label: str) -> None:
    axes.set(xlabel="angle / deg", ylabel=label, xlim=(0, 360), xticks=range(0, 361, 45))
