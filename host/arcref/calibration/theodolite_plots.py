"""The plots of a limited-angle calibration: what the tilted axis does, elevations, and the length of the arc."""

import numpy as np

from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, QUIET, READING_COLOUR, STYLE, WIDTH_IN, svg


def tilt_effect_plot(angle_deg, uncorrected_arcsec, error_arcsec, u_arcsec) -> str:
    """What the azimuths alone would say of the encoder, above; the error once axis and mirror are known, below."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 4.0), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True)
        above.plot(angle_deg, uncorrected_arcsec, ".-", color=BEFORE_COLOUR)
        above.set_ylabel("reading - azimuth\n/ arcsec")
        above.set_title("Axis and mirror not taken into account")
        if u_arcsec is not None:
            low, high = error_arcsec - 2 * u_arcsec, error_arcsec + 2 * u_arcsec
            below.fill_between(angle_deg, low, high, color=AFTER_COLOUR, alpha=0.18, linewidth=0)
        below.plot(angle_deg, error_arcsec, ".-", color=AFTER_COLOUR)
        below.axhline(0, color=QUIET, linewidth=0.8)
        below.set_ylabel("error / arcsec")
        band = "" if u_arcsec is None else ", band: expanded uncertainty (k=2)"
        below.set_title(f"Error of the encoder, about its mean over the arc{band}")
        below.set_xlabel("encoder reading / deg")
        return svg(figure, "arc-error")


def elevations_plot(reading_deg, elevation_deg, fitted_deg, residual_arcsec, outlier) -> str:
    """Elevations of the mirror's normal with the fitted axis, and what it leaves of them."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    order = np.argsort(reading_deg)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 3.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        above.plot(reading_deg[order], fitted_deg[order], color=AFTER_COLOUR, label="axis and mirror fitted")
        above.plot(reading_deg, elevation_deg, ".", color=READING_COLOUR, label="zenith reading - 90 deg")
        above.set_ylabel("elevation / deg")
        above.legend(loc="best")
        below.plot(reading_deg, residual_arcsec, ".", color=READING_COLOUR)
        below.plot(reading_deg[outlier], residual_arcsec[outlier], "o", mfc="none", mec=BEFORE_COLOUR, ms=9)
        below.axhline(0, color=QUIET, linewidth=0.8)
        below.set_ylabel("residual / arcsec")
        below.set_xlabel("encoder reading / deg")
        return svg(figure, "arc-elevations")


def arc_length_plot(arcs_deg, expanded_arcsec, own_arc_deg: float, own_arcsec: float) -> str:
    """Expanded uncertainty at the worst place of the arc, for arcs of other lengths with as many places."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 2.4), layout="constrained")
        axes = figure.add_subplot()
        axes.loglog(arcs_deg, expanded_arcsec, color=AFTER_COLOUR)
        axes.plot([own_arc_deg], [own_arcsec], "o", color=READING_COLOUR, label="this run")
        axes.set_xlabel("arc / deg")
        axes.set_ylabel("U (k=2), worst place\n/ arcsec")
        axes.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.yaxis.set_major_formatter(lambda value, _: f"{value:g}")
        axes.legend(loc="best")
        return svg(figure, "arc-length")
