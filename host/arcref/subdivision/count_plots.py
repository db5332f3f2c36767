"""Plots of the error within a line as counts alone gave it."""

import numpy as np

from arcref.plot_style import AFTER_COLOUR, QUIET, READING_COLOUR, STYLE, WIDTH_IN, svg
from arcref.subdivision_curve import SubdivisionCurve

_MOST_POINTS = 2000
_BINS = 64


def line_error_plot(curve: SubdivisionCurve, phase_rad, error_arcsec, name: str) -> str:
    """The curve over the line with its band (k=2), and the readings: each one, or of very many the mean of each bin."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    phase_deg, error = np.degrees(phase_rad), np.asarray(error_arcsec)
    label = "readings"
    if phase_deg.size > _MOST_POINTS:
        place = np.minimum((phase_deg * (_BINS / 360.0)).astype(int), _BINS - 1)
        number = np.bincount(place, minlength=_BINS)
        used = number > 0
        error = np.bincount(place, error, _BINS)[used] / number[used]
        phase_deg = np.bincount(place, phase_deg, _BINS)[used] / number[used]
        label = "mean of the edges in 1/64 of a line"
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.9), layout="constrained")
        axes = figure.add_subplot()
        axes.axhline(0, color=QUIET, linewidth=0.8)
        axes.plot(phase_deg, error, ".", color=READING_COLOUR, markersize=3.5, label=label)
        axes.plot(curve.line_deg, curve.error_arcsec, color=AFTER_COLOUR, label="error within the line")
        if curve.u_arcsec is not None:
            band = 2 * curve.u_arcsec
            low, high = curve.error_arcsec - band, curve.error_arcsec + band
            axes.fill_between(curve.line_deg, low, high, color=AFTER_COLOUR, alpha=0.2, linewidth=0, label="k=2")
        axes.set_xlim(0, 360)
        axes.set_xticks(np.arange(0, 361, 45))
        axes.set_xlabel("phase of the reading within a grating line / deg (360 deg = 2048 counts = 316.4 arcsec)")
        axes.set_ylabel("error / arcsec")
        axes.legend(loc="upper right", ncols=3)
        axes.margins(y=0.2)
        return svg(figure, name)


def ripple_plot(angle_turns, relative_speed, name: str) -> str:
    """The speed over the run, relative to its mean, in percent."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    step = max(1, relative_speed.size // _MOST_POINTS)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.0), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(angle_turns[::step], 100 * relative_speed[::step], color=READING_COLOUR, linewidth=0.8)
        axes.set_xlabel("angle turned / turns")
        axes.set_ylabel("speed off its mean / %")
        return svg(figure, name)
