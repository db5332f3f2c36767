"""The plot of the corrected angle's errors: over the turn and over the line, for each ROM."""

import numpy as np

from arcref.plot_style import BEFORE_COLOUR, INK, QUIET, RIVAL_COLOURS, STYLE, WIDTH_IN, svg
from arcref_sim.corrected_angle import CorrectedAngle

AFTER_COLOURS = tuple(colour for colour in RIVAL_COLOURS if colour != BEFORE_COLOUR)


def corrected_angle_plot(results: dict[str, CorrectedAngle]) -> bytes:
    """SVG: errors over the turn above, within the line below; `results` by the name of the ROM, three at most."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    first = next(iter(results.values()))
    turn_deg = (np.arange(first.turn_arcsec.size) + 0.5) * (360 / first.turn_arcsec.size)
    line_deg = (np.arange(first.line_arcsec.size) + 0.5) * (360 / first.line_arcsec.size)
    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 5.0), layout="constrained")
        over_turn, over_line = figure.subplots(2, 1)
        for axes, angle, raw, name in (
            (over_turn, turn_deg, first.raw_turn_arcsec, "turn_arcsec"),
            (over_line, line_deg, first.raw_line_arcsec, "line_arcsec"),
        ):
            axes.axhline(0, color=QUIET, linewidth=0.8)
            axes.plot(angle, raw, color=BEFORE_COLOUR, linewidth=3.5, alpha=0.4, label="not corrected")
            for colour, (label, result) in zip((INK, *AFTER_COLOURS), results.items(), strict=False):
                axes.plot(angle, getattr(result, name), color=colour, linewidth=1.1, label=label)
            axes.set_xlim(0, 360)
            axes.set_xticks(np.arange(0, 361, 45))
            axes.set_ylabel("error / arcsec")
            axes.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
            axes.margins(y=0.12)
        over_turn.set_xlabel("angle / deg")
        over_turn.set_title("Mean error in each half degree of the turn")
        over_line.set_xlabel("phase of the reading within a grating line / deg")
        over_line.set_title("Mean error by place within the line (2048 counts, 316.4 arcsec)")
        figure.legend(*over_turn.get_legend_handles_labels(), loc="outside lower center", ncols=4)
        return (svg(figure, "corrected") + "\n").encode()
