"""The compare output against its golden model: every line of the grid, once, with one delay."""

import random

import numpy as np
import pytest
from amaranth_bench import Bench

from arcref_gateware.golden.compare import compare_pulses
from arcref_gateware.link.compare_output import COMPARE_CLOCKS, LEAST_PERIOD, SETTLE_CLOCKS, CompareOutput

BENCH = None
PORTS = ["position", "homed", "period", "start", "restart", "width"]
TURN = 1 << 23


def pulses(position, period, start, width=0):
    global BENCH
    BENCH = BENCH or Bench(CompareOutput(), PORTS, ["pulse", "count"])
    tail = np.full(COMPARE_CLOCKS + 20, position[-1])
    shown = np.concatenate([position, tail])
    return BENCH.run(len(shown), position=shown, homed=1, period=period, start=start, width=width)


def motion(seed, words, speed, first):
    """Positions of a shaft at `speed` counts a word that never turns back, with jitter."""
    rng = np.random.default_rng(seed)
    exact = first + np.cumsum(np.full(words, speed)) + rng.uniform(-0.5, 0.5, words)
    onward = np.maximum.accumulate if speed > 0 else np.minimum.accumulate
    return onward(np.floor(exact)).astype(np.int64)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("speed", [0.42, -0.42, 2.5, -2.5, 4.0, -4.0])
@pytest.mark.parametrize("period", [LEAST_PERIOD, 100, 4096])
def test_every_line_gives_one_pulse_with_the_same_delay(seed, speed, period):
    start = random.Random(seed).randrange(TURN)
    first = start + TURN * random.Random(seed).randrange(-3, 3) - np.sign(speed) * 200
    position = motion(seed, 1500, speed, first)
    expected = compare_pulses(position, period, start)
    got = np.flatnonzero(pulses(position, period, start)["pulse"]) - COMPARE_CLOCKS
    assert len(expected) >= (2 if period < 4096 else 1)
    assert np.array_equal(got, expected)


@pytest.mark.parametrize("seed", range(4))
def test_reversals_away_from_the_lines_lose_and_add_nothing(seed):
    rng = np.random.default_rng(seed)
    steps = np.repeat(rng.integers(-4, 5, 100), rng.integers(10, 60, 100))
    position = 5000 + np.cumsum(steps)
    expected = compare_pulses(position, 256, 5000)
    output = pulses(position, 256, 5000)
    got = np.flatnonzero(output["pulse"]) - COMPARE_CLOCKS
    # A line passed again while the lines are still being moved has its pulse up to ten words late.
    assert len(got) == len(expected)
    assert np.all((got - expected >= 0) & (got - expected <= 10))
    assert output["count"][-1] == len(expected) % 128


def test_the_grid_goes_over_the_end_of_a_turn_and_of_the_numbers():
    for first in (TURN - 300, -(1 << 24) - 300, (1 << 25) - 300):
        position = first + np.arange(1000)
        start = (first + 50) % TURN
        got = np.flatnonzero(pulses(position, 100, start)["pulse"]) - COMPARE_CLOCKS
        assert np.array_equal(got, compare_pulses(position, 100, start))


def test_a_pulse_has_its_width_and_a_short_period_switches_the_output_off():
    position = 1000 + np.arange(1200)
    output = pulses(position, 300, 1100, width=25)
    ends = np.flatnonzero(np.diff(output["pulse"]))
    assert np.array_equal(np.diff(ends)[::2], [25] * len(ends[::2]))
    assert not pulses(position, LEAST_PERIOD - 1, 1100)["pulse"].any()


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("by", ["restart", "homed"])
def test_a_new_grid_begins_at_the_next_passage_of_its_start(seed, by):
    """At random instants another K and start are set, or the position is lost and found; no pulse but on a line."""
    rng = np.random.default_rng(seed)
    words, length = 6000, 600
    speed = rng.choice([-3.9, -1.5, 1.2, 3.3])
    position = motion(seed, words, speed, rng.integers(0, TURN))
    begins = np.arange(0, words, length) + rng.integers(0, 200, words // length)
    period, start, other = np.zeros((3, words), dtype=np.int64)
    expected = []
    for k, first in enumerate(begins):
        end = begins[k + 1] if k + 1 < len(begins) else words
        period[first:end] = rng.integers(LEAST_PERIOD, 200) if by == "restart" or k == 0 else period[first - 1]
        # Ahead, and the one before it behind the position, which so lies between them.
        start[first:end] = (position[first] + int(speed * rng.integers(60, 150))) % TURN
        other[first : first + (1 if by == "restart" else 5)] = 1
        settled = first + SETTLE_CLOCKS + 8
        expected.append(settled + compare_pulses(position[settled:end], int(period[first]), int(start[first])))
    ports = {"restart": other} if by == "restart" else {"homed": 1 - other}
    bench = Bench(CompareOutput(), PORTS, ["pulse"])
    got = np.flatnonzero(
        bench.run(words, position=position, period=period, start=start, **{"homed": 1, **ports})["pulse"]
    )
    got = got - COMPARE_CLOCKS
    # What passes as the grid is changed is neither asked for nor forbidden.
    changing = np.concatenate([np.arange(first - COMPARE_CLOCKS, first + SETTLE_CLOCKS + 16) for first in begins])
    expected = np.concatenate(expected)
    expected, got = (np.setdiff1d(pulses_at, changing) for pulses_at in (expected, got))
    assert np.array_equal(got, expected[expected < words - COMPARE_CLOCKS])
    assert len(got) > 5
