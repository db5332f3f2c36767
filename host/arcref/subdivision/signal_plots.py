"""The plots of a calibration from samples: signals, Lissajous figure, causes, harmonics, and the map over the turn."""

import numpy as np

from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, QUIET, STYLE, WIDTH_IN, svg
from arcref.subdivision.period_parameters import LineMap
from arcref.subdivision.signal_budget import Cause

_FINE = 721


def signals_plot(found) -> str:
    """Mean samples of both channels with the model through them, above; what the model leaves, below."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    mean, model = found.mean_samples, found.model
    theta = np.linspace(0, 2 * np.pi, _FINE)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 3.8), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        pairs = zip(("sine", "cosine"), (mean.sine_v, mean.cosine_v), (BEFORE_COLOUR, AFTER_COLOUR), strict=True)
        for place, (name, volts, colour) in enumerate(pairs):
            above.plot(np.degrees(theta), model.signals_v(theta)[place], color=colour, label=name)
            above.plot(np.degrees(mean.theta_rad), volts, ".", color=colour, markersize=3)
            residual = 1e3 * (volts - model.signals_v(mean.theta_rad)[place])
            below.plot(np.degrees(mean.theta_rad), residual, ".-", color=colour, linewidth=0.7, markersize=3)
        above.set_ylabel("signal / V")
        above.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
        _not_rounding(below, 1e-3)
        below.axhline(0, color=QUIET, linewidth=0.8)
        below.set_ylabel("samples less\nmodel / mV")
        _line_axis(below, "phase from the first sample / deg of a line")
        figure.align_ylabels()
        return svg(figure, "signals")


def lissajous_plot(found) -> str:
    """Sine against cosine with the circle of ideal signals, and how the radius departs from it along the line."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    mean, model = found.mean_samples, found.model
    theta = np.linspace(0, 2 * np.pi, _FINE)
    amplitudes = [channel.canonical.fundamental.amplitude_v for channel in (model.sine, model.cosine)]
    radius = float(np.mean(amplitudes))
    sine, cosine = model.signals_v(theta)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.9), layout="constrained")
        left, right = figure.subplots(1, 2, width_ratios=(2, 3))
        left.plot(radius * np.cos(theta), radius * np.sin(theta), "--", color=QUIET, linewidth=0.8)
        left.plot(cosine, sine, color=AFTER_COLOUR)
        left.plot(mean.cosine_v, mean.sine_v, ".", color=INK, markersize=3)
        left.plot([0], [0], "+", color=QUIET)
        left.set_aspect("equal")
        left.set_xlabel("cosine / V")
        left.set_ylabel("sine / V")
        left.set_title("dashed: circle without a fault")
        right.plot(np.degrees(theta), 100 * (np.hypot(sine, cosine) / radius - 1), color=AFTER_COLOUR)
        own = np.hypot(mean.sine_v, mean.cosine_v)
        right.plot(np.degrees(mean.theta_rad), 100 * (own / radius - 1), ".", color=INK, markersize=3)
        right.axhline(0, color=QUIET, linewidth=0.8)
        right.set_title("radius, departure from the circle")
        right.set_ylabel("%")
        _line_axis(right, "phase from the first sample / deg of a line")
        return svg(figure, "lissajous")


def causes_plot(causes: tuple[Cause, ...]) -> str:
    """Half of the peak to peak error by each cause alone, as bars; all of them together at the bottom."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 0.5 + 0.22 * len(causes)), layout="constrained")
        axes = figure.add_subplot()
        size = [cause.amplitude_arcsec for cause in causes]
        together = [cause.size_arcsec is None or "both" in cause.name for cause in causes]
        colour = [AFTER_COLOUR if both else BEFORE_COLOUR for both in together[:-1]] + [INK]
        axes.barh(range(len(size)), size, 0.68, color=colour)
        for place, value in enumerate(size):
            axes.annotate(f"{value:.3f}", (value, place), (4, 0), textcoords="offset points", va="center", fontsize=8)
        axes.set_yticks(range(len(size)), [cause.name for cause in causes])
        axes.tick_params(axis="y", length=0, labelcolor=INK)
        axes.invert_yaxis()
        axes.set_xlim(0, 1.12 * (max(size) or 1.0))
        axes.grid(axis="y", visible=False)
        axes.spines["left"].set_visible(False)
        axes.set_xlabel("error by this cause alone, half of peak to peak / arcsec (blue: both channels together)")
        return svg(figure, "causes")


def harmonics_plot(before_arcsec, after_arcsec) -> str:
    """Amplitudes of the error by waves a line, before and after correction."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    order = np.arange(1, len(before_arcsec) + 1)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.3), layout="constrained")
        axes = figure.add_subplot()
        axes.bar(order - 0.2, before_arcsec, 0.4, color=BEFORE_COLOUR, label="before correction")
        axes.bar(order + 0.2, after_arcsec, 0.4, color=AFTER_COLOUR, label="after, of the mean period")
        axes.set_xticks(order)
        axes.grid(axis="x", visible=False)
        axes.set_xlabel("order, waves a line")
        axes.set_ylabel("amplitude / arcsec")
        axes.legend(loc="upper right")
        return svg(figure, "line-harmonics")


def map_plot(lines: LineMap) -> str:
    """Line number by phase: the error of each block of lines, and how far it departs from the mean of all."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    error = lines.error_arcsec
    about = error - error.mean(axis=0)
    first, last = lines.first_line[0], lines.first_line[-1] + lines.lines
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 3.1), layout="constrained")
        axes = figure.subplots(1, 2, sharey=True)
        for each, values, title in (
            (axes[0], error, "error / arcsec"),
            (axes[1], about, "less the mean of all lines / arcsec"),
        ):
            top = max(float(np.abs(values).max()), 1e-6)
            image = each.imshow(
                values, "RdBu_r", aspect="auto", origin="lower", extent=(0, 360, first, last), vmin=-top, vmax=top,
                interpolation="nearest",
            )  # fmt: skip
            each.grid(visible=False)
            each.set_title(title)
            _line_axis(each, "phase / deg of a line")
            figure.colorbar(image, ax=each, shrink=0.9)
        axes[0].set_ylabel("grating line")
        return svg(figure, "line-map")


def _line_axis(axes, label: str) -> None:
    axes.set_xlim(0, 360)
    axes.set_xticks(np.arange(0, 361, 45 if axes.bbox.width > 250 else 90))
    axes.set_xlabel(label)


def _not_rounding(axes, least: float) -> None:
    """A scale of 1e-12 would look like a finding."""
    limit = max(1.1 * max(map(abs, axes.get_ylim())), least)
    axes.set_ylim(-limit, limit)
