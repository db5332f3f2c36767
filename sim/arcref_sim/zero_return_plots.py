"""The plots of the zero-return page, as SVG text."""

import io

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, Z_BIT
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion
from arcref_sim.zero_return import ZeroReturnPlan, ZeroReturnResult

WIDTH_INCH = 9.0
BEFORE_COLOUR, AFTER_COLOUR, MARK_COLOUR = "#b4552d", "#1f6f8b", "#7a3b8f"
PLOTTED_POINTS = 6000
"""Points of the error plot: enough to show every cell of the scatter, few enough for a small page."""


def closure_plot(result: ZeroReturnResult) -> str:
    """Closure error at each index, in the order they were passed."""
    figure, axes = _figure(2.4)
    errors = [error for _, _, error in result.closure]
    places = np.arange(len(errors))
    for direction, marker, name in ((1, ">", "forward"), (-1, "<", "reverse")):
        chosen = [i for i, mark in enumerate(result.closure) if mark[1] == direction]
        axes.plot(places[chosen], np.array(errors)[chosen], marker, color=AFTER_COLOUR if direction > 0 else BEFORE_COLOUR,
                  label=name)  # fmt: skip
    axes.set_xticks(places, [str(turn) for turn, _, _ in result.closure])
    limit = max(4, 1.2 * max((abs(error) for error in errors), default=0))
    axes.set_ylim(-limit, limit)
    axes.set_xlabel("zero mark (turn), in the order passed")
    axes.set_ylabel("closure error (counts)")
    axes.legend(loc="upper right", ncols=2)
    return _svg(figure)


def error_plot(result: ZeroReturnResult) -> str:
    """Error against the true angle over the turn, before and after the correction."""
    figure, axes = _figure(3.4)
    stride = max(1, len(result.angle_deg) // PLOTTED_POINTS)
    angle = result.angle_deg[::stride]
    axes.plot(angle, result.before_arcsec[::stride], ".", ms=2, color=BEFORE_COLOUR, label="before", rasterized=True)
    axes.plot(angle, result.after_arcsec[::stride], ".", ms=2, color=AFTER_COLOUR, label="after", rasterized=True)
    axes.set_xlim(0, 360)
    axes.set_xticks(range(0, 361, 45))
    axes.set_xlabel("angle (deg)")
    axes.set_ylabel("reading - true angle (arcsec)")
    counts = axes.secondary_yaxis(
        "right", functions=(lambda arcsec: arcsec / ARCSEC_PER_COUNT, lambda counts: counts * ARCSEC_PER_COUNT)
    )
    counts.set_ylabel("counts")
    axes.legend(loc="upper right", markerscale=5)
    return _svg(figure)


def waveform_plot(plan: ZeroReturnPlan, counts_each_side: int = 6) -> str:
    """Sampled A, B and Z around the zero mark, forward, with the place at which the index is latched."""
    motion = Motion(-counts_each_side - 0.5).constant_speed(
        plan.speed_rps, turns=(2 * counts_each_side + 1) / COUNTS_PER_TURN
    )
    encoder = SyntheticEncoder(motion, plan.sample_rate_hz)
    samples = encoder.whole().changes.to_samples()
    time_ns = np.arange(len(samples)) / plan.sample_rate_hz * 1e9
    figure, axes = _figure(2.6)
    for row, (name, bit) in enumerate((("Z", Z_BIT), ("B", B_BIT), ("A", A_BIT))):
        level = (samples >> bit & 1) * 0.7 + row
        axes.step(time_ns, level, where="post", color="#333333", lw=1.2)
        axes.plot(time_ns, level, ".", ms=3, color=AFTER_COLOUR)
        axes.text(-0.015, (row + 0.35) / 3, name, transform=axes.transAxes, ha="right", va="center")
    gate = (samples & 7) == 7
    if gate.any():
        latched = time_ns[int(np.argmax(gate))]
        axes.axvline(latched, color=MARK_COLOUR, lw=1)
        axes.text(latched, 3.05, " index latched, position 0", color=MARK_COLOUR, va="bottom")
    axes.set_ylim(-0.2, 3)
    axes.set_yticks([])
    axes.set_xlabel(f"time (ns); dots are samples, {plan.samples_per_count:.2f} for each count")
    return _svg(figure)


def _figure(height_inch: float):
    figure = Figure(figsize=(WIDTH_INCH, height_inch), layout="constrained")
    axes = figure.subplots()
    axes.grid(alpha=0.25)
    axes.spines[["top", "right"]].set_visible(False)
    return figure, axes


def _svg(figure: Figure) -> str:
    # Text stays text, and a fixed salt makes the same result give the same bytes.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "arcref"}):
        file = io.StringIO()
        figure.savefig(file, format="svg", metadata={"Date": None}, dpi=150)
    text = file.getvalue()
    return text[text.index("<svg") :]
