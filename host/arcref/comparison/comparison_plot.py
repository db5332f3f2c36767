"""Plots of a dynamic comparison: what was read, and how it splits into an error of angle and a delay."""

import io

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from arcref.comparison.dynamic_error import DynamicError
from arcref.plot_style import STYLE

FORMATS = ("svg", "png", "pdf")


def comparison_plot(result: DynamicError, image_format: str = "svg") -> bytes:
    """Three plots below one another: differences as read over the angle, the error of angle with its k=2 band and that
    of each speed alone, and the mean difference of each speed with the line whose slope is the delay.
    """
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.5, 9.5), layout="constrained")
        read, angle, delay = figure.subplots(3, 1)
        _plot_read(read, result)
        _plot_angle(angle, result)
        _plot_delay(delay, result)
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
    axes.set(title="As read: encoder under test less reference", xlabel="angle in deg", ylabel="arcsec", xlim=(0, 360))
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
    axes.set(title="Error of angle, the delay taken off", xlabel="angle in deg", ylabel="arcsec", xlim=(0, 360))
    axes.legend(fontsize=7, ncols=2)


def _plot_delay(axes, result: DynamicError) -> None:
    speed = np.array([group.speed_rps for group in result.groups])
    mean = np.array([group.mean_arcsec for group in result.groups])
    axes.plot(speed, mean, "o", label="mean difference of each speed")
    if result.delay_s is None:
        axes.set_title("One speed alone cannot tell the delay")
    else:
        line = np.array([min(speed.min(), 0.0), max(speed.max(), 0.0)])
        per_rps = 1_296_000.0 * result.delay_s
        axes.plot(line, result.zero_arcsec - per_rps * line, label=f"{-per_rps:.4g} arcsec per r/s")
        axes.set_title(f"Delay {1e6 * result.delay_s:.4f} us, k = 2: {2e6 * result.u_delay_s:.4f} us")
    axes.set(xlabel="speed in r/s", ylabel="arcsec")
    axes.legend(loc="upper right", fontsize=7)
