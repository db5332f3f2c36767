"""Plot of a tower tilt: y readings with the model, what it adds to x, and a plan that shows which side to raise."""

import numpy as np

from arcref.calibration.polygon_reduction import PolygonReduction
from arcref.calibration.tilt_adjustment import AdjustingScrews, screw_turns
from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, QUIET, READING_COLOUR, STYLE, WIDTH_IN, svg


def tilt_plot(reduction: PolygonReduction, screws: AdjustingScrews | None = None) -> str:
    """The tilt of a reduced run as SVG text. Raises `ValueError` when the run has none."""
    tilt, theta_deg = reduction.tilt, reduction.run.series.theta_deg
    if tilt is None:
        raise ValueError("this run has no y readings, so there is no tilt to draw")
    # Imported here: it takes half a second.
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    with rc_context(STYLE):
        figure = Figure(figsize=(WIDTH_IN, 4.6), layout="constrained")
        left, right = figure.subfigures(1, 2, width_ratios=(1.25, 1))
        above, middle, below = left.subplots(3, 1, sharex=True, height_ratios=(1.5, 1, 1.2))
        fine_deg = np.linspace(0, 360, 721)
        vertical = tilt.vertical_arcsec(theta_deg)
        above.plot(fine_deg, tilt.vertical_arcsec(fine_deg), color=AFTER_COLOUR, label="model")
        above.plot(theta_deg, vertical + tilt.residual_arcsec, "o", color=READING_COLOUR, markersize=3.5, label="y")
        above.set_ylabel("y / arcsec")
        above.legend(loc="best", fontsize=8)
        middle.axhline(0, color=QUIET, linewidth=0.8)
        middle.vlines(theta_deg, 0, tilt.residual_arcsec, color=READING_COLOUR, linewidth=1)
        middle.plot(theta_deg, tilt.residual_arcsec, "o", color=READING_COLOUR, markersize=3)
        middle.set_ylabel("y - model\n/ arcsec")
        below.axhline(0, color=QUIET, linewidth=0.8)
        below.plot(fine_deg, tilt.horizontal_arcsec(fine_deg), color=BEFORE_COLOUR, label="tilt")
        if reduction.x_roll_arcsec.any():
            place = reduction.run.series.reading_of_face[0]
            roll = reduction.x_roll_arcsec[place] - reduction.x_roll_arcsec[place[0]]
            below.plot(theta_deg, roll, "s", color=INK, markersize=3, label="roll")
        below.set_ylabel("added to x\n/ arcsec")
        below.legend(loc="best", fontsize=8)
        below.set_xlabel("turn from face 1 / deg")
        below.set_xlim(0, 360)
        below.set_xticks(range(0, 361, 60))
        left.align_ylabels()
        _draw_plan(right.subplots(), reduction, screws)
        return svg(figure, f"tilt-{reduction.run.run.file.sha256[:8]}")


def _draw_plan(axes, reduction: PolygonReduction, screws: AdjustingScrews | None) -> None:
    """The polygon seen from above at the start, face 1 to the right, with the way to tip it."""
    tilt, faces = reduction.tilt, reduction.run.faces
    corner = np.radians((np.arange(faces + 1) - 0.5) * 360.0 / faces)
    axes.plot(np.cos(corner), np.sin(corner), color=INK, linewidth=1.2)
    every = max(1, faces // 12)
    for face in range(0, faces, every):
        angle = 2 * np.pi * face / faces
        axes.text(1.13 * np.cos(angle), 1.13 * np.sin(angle), f"{face + 1}", ha="center", va="center", color=QUIET)
    omega = np.radians(tilt.omega_deg)
    way = np.array([np.cos(omega), np.sin(omega)])
    axes.annotate("", 0.8 * way, (0, 0), arrowprops={"arrowstyle": "-|>", "color": AFTER_COLOUR, "linewidth": 2})
    axes.plot(0, 0, "o", color=AFTER_COLOUR, markersize=4)
    for number, turn in enumerate(screw_turns(tilt, screws) if screws else (), 1):
        angle = np.radians(turn.angle_deg)
        x, y = 0.62 * np.cos(angle), 0.62 * np.sin(angle)
        axes.plot(x, y, "o", markersize=9, markerfacecolor="white", markeredgecolor=BEFORE_COLOUR)
        text = f"{number}: {turn.rise_um:+.1f} um"
        if turn.turn_deg is not None:
            text += f"\n{turn.turn_deg:+.1f} deg"
        axes.text(x, y - 0.12, text, ha="center", va="top", fontsize=8, color=BEFORE_COLOUR)
    axes.set_aspect("equal")
    axes.set_xlim(-1.3, 1.3)
    axes.set_ylim(-1.3, 1.3)
    axes.axis("off")
    axes.set_title(
        f"From above, at the start. The encoder's axis leans\n{tilt.psi_arcsec:.1f} arcsec along the arrow: "
        "lower the polygon on that side,\nor raise the far one; + at a screw means raise."
    )
