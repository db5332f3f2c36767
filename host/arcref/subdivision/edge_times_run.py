"""A run of edge times: when each count began, the shaft turning at a speed as even as the drive can hold."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN
from arcref.subdivision.line_wave import FEWEST_ORDERS, orders_told_apart, phase_rad
from arcref.subdivision.whole_counts import check_line_count, whole_counts

COUNT, TIME = "count", "time_s"

FEWEST_LINES = 8
"""Grating lines that a run must pass: what is not of the lines is told from what is by comparing them."""

FEWEST_EDGES = 256

LARGEST_SPEED_CHANGE = 0.2
"""Of a few lines against the whole run. More is no constant speed, or edges were lost."""

_LINES_TOGETHER = 4


@dataclass(frozen=True, eq=False)
class EdgeTimes:
    """Edges in the order of time: `reading_counts` float64[n], the reading at each edge; `time_s` float64[n].

    Forward, count c begins at reading c; in reverse (`direction` -1) it begins at reading c + 1.
    """

    reading_counts: np.ndarray
    time_s: np.ndarray
    direction: int

    @property
    def lines(self) -> float:
        """Grating lines passed."""
        return float(np.ptp(self.reading_counts)) / COUNTS_PER_LINE

    @property
    def phase_rad(self) -> np.ndarray:
        """Phase of each edge within its line."""
        return phase_rad(self.reading_counts)

    @property
    def speed_rps(self) -> float:
        """Mean speed, turns a second, negative in reverse."""
        passed = (self.reading_counts[-1] - self.reading_counts[0]) / COUNTS_PER_TURN
        return float(passed / (self.time_s[-1] - self.time_s[0]))


def edge_times(run) -> EdgeTimes:
    """The edges of a `RunFile` with columns `count,time_s`.

    Raises `InputError`, with the row, for counts that are not whole, repeat, or go both ways; times that go back; fewer
    than `FEWEST_LINES` lines or `FEWEST_EDGES` edges; a speed that is not constant, as when edges were lost; edges at
    too few phases of the line; and a stated `line_count` other than the encoder's.
    """
    check_line_count(run)
    count, time = whole_counts(run, COUNT), run[TIME]
    if count.size < FEWEST_EDGES:
        raise run.error(f"{count.size} edges, at least {FEWEST_EDGES} were expected")
    step = np.diff(count)
    direction = 1 if step.sum() > 0 else -1
    wrong = np.flatnonzero(step * direction <= 0)
    if wrong.size:
        _refuse_step(run, count, int(wrong[0]) + 1, direction)
    back = np.flatnonzero(np.diff(time) < 0)
    if back.size:
        index = int(back[0]) + 1
        problem = f"{time[index]:.12g} s follows {time[index - 1]:.12g} s, times in their order were expected"
        raise run.error(problem, reading=index, column=TIME)
    edges = EdgeTimes(count + (direction < 0), time - time[0], direction)
    if edges.lines < FEWEST_LINES:
        few = "fewer than one grating line" if edges.lines < 1 else f"{edges.lines:.3g} grating lines"
        raise run.error(f"the edges pass {few}, at least {FEWEST_LINES} were expected", column=COUNT)
    _refuse_uneven_speed(run, edges)
    if orders_told_apart(edges.phase_rad) < FEWEST_ORDERS:
        problem = (
            f"the edges stand at {np.unique(edges.phase_rad).size} phases of the line and leave a gap: at least "
            f"{2 * FEWEST_ORDERS + 1} phases at even distances were expected (take every 61st count, not every 64th)"
        )
        raise run.error(problem, column=COUNT)
    return edges


def _refuse_step(run, count: np.ndarray, index: int, direction: int) -> None:
    now, before = int(count[index]), int(count[index - 1])
    if now == before:
        problem = f"{now} is given twice, each count was expected once"
    else:
        way = "back" if direction > 0 else "forward"
        problem = f"{now} follows {before}: the shaft turns {way} here, one direction of rotation was expected"
    raise run.error(problem, reading=index, column=COUNT)


def _refuse_uneven_speed(run, edges: EdgeTimes) -> None:
    """Where some lines take a fifth more or less time than they should at the speed of the whole run."""
    passed = np.abs(edges.reading_counts - edges.reading_counts[0])
    first = np.flatnonzero(np.diff(np.floor(passed / (_LINES_TOGETHER * COUNTS_PER_LINE)), prepend=-1))
    if first.size < 2:
        return
    counts, seconds = np.diff(passed[first]), np.diff(edges.time_s[first])
    usual = float(np.median(counts) / max(float(np.median(seconds)), 1e-300))
    off = np.abs(counts - usual * seconds) > LARGEST_SPEED_CHANGE * np.maximum(counts, usual * seconds)
    if not off.any():
        return
    place = int(np.argmax(off))
    here = slice(first[place], first[place + 1] + 1)
    step, expected = np.diff(passed[here]), usual * np.diff(edges.time_s[here])
    worst = int(np.argmax(np.abs(step - expected)))
    problem = (
        f"{step[worst]:.0f} counts since the row before, {expected[worst]:.0f} were expected at the run's "
        f"{usual / COUNTS_PER_TURN:.4g} r/s: edges were lost, or the speed is not constant"
    )
    raise run.error(problem, reading=int(here.start) + worst + 1, column=COUNT)
