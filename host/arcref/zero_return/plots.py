"""The plots of the zero-return page, each as SVG text to stand inside it."""

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from arcref.angle import COUNTS_PER_TURN
from arcref.plot_style import AFTER_COLOUR, BEFORE_COLOUR, INK, QUIET, STYLE, svg
from arcref.zero_return.result import ZeroReturnResult
from arcref.zero_return.truth_parts import ErrorOverTurn, Waveform

FORWARD_COLOUR, REVERSE_COLOUR = AFTER_COLOUR, BEFORE_COLOUR

MOST_TICKS = 30
"""Zero marks that are named below the plot, at the most."""


def closure_plot(result: ZeroReturnResult) -> str:
    """Closure error at each index in the order the zero marks came."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 2.4), layout="constrained")
        axes = figure.add_subplot()
        passes = list(enumerate(result.index_passes))
        for direction, colour, marker, label in (
            (1, FORWARD_COLOUR, "^", "forward"),
            (-1, REVERSE_COLOUR, "v", "reverse"),
        ):
            chosen = [
                (place, index.closure_error_counts)
                for place, index in passes
                if index.direction == direction and index.closure_error_counts is not None
            ]
            if chosen:
                axes.plot(*zip(*chosen, strict=True), marker, color=colour, markersize=7, label=label)
        axes.axhline(0, color=QUIET, linewidth=0.8)
        size = max([1, *(abs(error or 0) for error in result.closure_errors_counts)])
        axes.set_ylim(-1.4 * size, 1.4 * size)
        axes.yaxis.get_major_locator().set_params(integer=True)
        named = passes[:: -(-len(passes) // MOST_TICKS) or 1]
        axes.set_xticks([place for place, _ in named], [str(index.turn) for _, index in named])
        axes.set_xlabel("zero mark of turn")
        axes.set_ylabel("closure error / counts")
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper right", ncols=2)
        return svg(figure, "closure")


def error_plot(turn: ErrorOverTurn) -> str:
    """Error before and after the correction over the turn: each a band from the lowest to the highest that occurred."""
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 3.2), layout="constrained")
        axes = figure.add_subplot()
        for low, high, colour, label in (
            (turn.before_low, turn.before_high, BEFORE_COLOUR, "before correction"),
            (turn.after_low, turn.after_high, AFTER_COLOUR, "after correction"),
        ):
            axes.fill_between(turn.angle_deg, low, high, color=colour, linewidth=0.6, label=label)
        axes.set_xlim(0, 360)
        axes.set_xticks(range(0, 361, 45))
        axes.set_xlabel("angle / deg")
        axes.set_ylabel("error / arcsec")
        axes.legend(loc="upper right", ncols=2)
        return svg(figure, "error")


def waveform_plot(result: ZeroReturnResult) -> str:
    """A, B and Z around the zero mark as the core sampled them, the latched count shaded, forward above reverse."""
    waves = sorted({wave.direction: wave for wave in result.waveforms}.values(), key=lambda wave: -wave.direction)
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 1.9 * max(len(waves), 1)), layout="constrained")
        sample_ns = 1e9 / result.sample_rate_hz
        rows = figure.subplots(max(len(waves), 1), 1, squeeze=False)[:, 0]
        for axes, wave in zip(rows, waves, strict=False):
            _draw_wave(axes, wave, sample_ns)
            axes.set_title("forward" if wave.direction > 0 else "reverse", loc="left", fontsize=9, color=QUIET)
        rows[-1].set_xlabel("time from the latched index / ns")
        return svg(figure, "waveform")


def way_plot(result: ZeroReturnResult) -> str:
    """The shaft's way as the instrument was read: turns over time, and below it the speed between readings."""
    parts = result.instrument
    turns = parts.raw_position_counts / COUNTS_PER_TURN
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(7.4, 3.6), layout="constrained")
        way, speed = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        marks = range(result.first_turn, result.first_turn + result.revolutions + 1)
        for mark in marks if len(marks) <= MOST_TICKS else ():
            way.axhline(mark, color="#e8d3a2", linewidth=0.8)
        way.plot(parts.time_s, turns, color=FORWARD_COLOUR, linewidth=1.2)
        way.set_ylabel("position / turns")
        way.grid(axis="y", visible=False)
        elapsed = np.diff(parts.time_s)
        known = elapsed > 0
        middle = (parts.time_s[1:] + parts.time_s[:-1]) / 2
        between = np.diff(turns)[known] / elapsed[known]
        speed.axhline(0, color=QUIET, linewidth=0.8)
        speed.plot(middle[known], between, color=REVERSE_COLOUR, linewidth=1.0)
        speed.set_ylabel("speed / r/s")
        speed.set_xlabel("time / s")
        return svg(figure, "way")


def _draw_wave(axes, wave: Waveform, sample_ns: float) -> None:
    times = np.append(wave.time, wave.end) * sample_ns
    latched = int(np.searchsorted(wave.time, 0, side="right")) - 1
    if 0 <= latched < len(wave.time):
        axes.axvspan(times[latched], times[latched + 1], color="#f3d9a4", linewidth=0)
        middle = (times[latched] + times[latched + 1]) / 2
        axes.annotate("0", (middle, 4.25), ha="center", va="bottom", color="#7a5a10", annotation_clip=False)
    for base, bit in ((3.0, 0), (1.5, 1), (0.0, 2)):
        level = (wave.state >> bit & 1).astype(float)
        axes.step(times, base + np.append(level, level[-1]), where="post", color=INK, linewidth=1.1)
    axes.set_yticks([0.5, 2.0, 3.5], ["Z", "B", "A"])
    axes.set_ylim(-0.3, 4.9)
    axes.set_xlim(times[0], times[-1])
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="y", visible=False)
    axes.spines["left"].set_visible(False)
