"""Zero marks joined with indices, on random ways and with readings at random instants."""

import random

import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.instrument.counting_state import CountingState
from arcref.instrument.zero_mark_passes import ZeroMarkPasses


def state(time_s, raw, index_count, closure_error=0):
    return CountingState(time_s, raw, raw, Flag(0), True, closure_error, 0, index_count % 65536, 9, 0)


def marks_on_the_way(start, end):
    """Turns of the marks from `start` to `end`, found one by one, and the direction."""
    step = 1 if end >= start else -1
    turn = start // COUNTS_PER_TURN + 1 if step > 0 else -(-start // COUNTS_PER_TURN) - 1
    turns = []
    while step * (end - turn * COUNTS_PER_TURN) >= 0:
        turns.append(turn)
        turn += step
    return turns, step


@pytest.mark.parametrize("seed", range(30))
def test_every_mark_of_a_way_is_told_once_and_in_order(seed):
    """Between readings the shaft goes one way; between the index count and the position of a reading it goes on."""
    rng = random.Random(seed)
    raw, count, time_s = rng.randrange(-9, 9) * COUNTS_PER_TURN + rng.randrange(1, COUNTS_PER_TURN), 65530, 0.0
    passes, truth = ZeroMarkPasses(state(0.0, raw, count), homes=False), []
    dark = rng.randrange(-3, 3) if seed % 2 else None
    for _ in range(200):
        way = rng.choice((1, -1)) * rng.randrange(3 * COUNTS_PER_TURN)
        counted = None
        end = raw + way
        for target in (raw + round(way * rng.random()), end):
            turns, step = marks_on_the_way(raw, target)
            for turn in turns:
                if turn != dark:
                    truth.append((turn, step))
                    count += 1
            raw, counted = target, count if counted is None else counted
        time_s += 0.02
        passes.take(state(time_s, raw, counted))
    passes.take(state(time_s + 0.02, raw, count))
    found = [(one.turn, one.direction) for one in passes.passes]
    assert passes.further == 0
    assert len(found) == len(truth)
    if dark is None:
        assert found == truth
        times = [one.time_s for one in passes.passes]
        assert times == sorted(times)


def test_an_error_is_given_to_the_mark_it_belongs_to_and_none_is_made_up():
    passes = ZeroMarkPasses(state(0.0, -10, 0), homes=False)
    passes.take(state(1.0, 10, 1, closure_error=5))
    passes.take(state(2.0, 3 * COUNTS_PER_TURN + 10, 4, closure_error=-2))
    assert [one.closure_error_counts for one in passes.finished(5)] == [5, None, None, -2]
    assert [one.closure_error_counts for one in passes.finished(0)] == [5, 0, 0, -2]


def test_standing_on_the_mark_counts_once():
    passes = ZeroMarkPasses(state(0.0, -10, 0), homes=False)
    for count, raw in enumerate((0, -10, 0, 10)):
        passes.take(state(1.0 + count, raw, (1, 1, 2, 2)[count]))
    assert [(one.turn, one.direction) for one in passes.passes] == [(0, 1), (0, 1)]
    assert passes.further == 0
