"""Closure check: what an index proves, and each fault alone in its flag.

With A and B whole, the gate state makes any slip that leaves no illegal step a multiple of 4 counts. The errors of one
count and the like are driven here at the block's own ports; at the core they need a count of A and B to be wrong.
"""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench, assert_rows

from arcref.angle import COUNTS_PER_TURN
from arcref_gateware.closure_check import CLOSURE_CLOCKS, ClosureCheck
from arcref_gateware.golden.closure import ClosureModel, is_near_whole_turn, nearest_turn_difference

FAULTS = ("closure_fault", "index_fault")
STATES = ("closure_error", "index_count", "largest_closure_error")
HOME = (0, 0)
"""A word with an index at position 0."""

FAR = 100_000


@cache
def bench() -> Bench:
    inputs = ["angle", "homed", "index", "home", "index_way_back", "clear"]
    return Bench(ClosureCheck(), inputs, [*FAULTS, *STATES])


def run(words, clear=0):
    """Rows for a list of words, each a position after it and the position of its index, or None. The first homes."""
    position = np.array([after for after, _ in words])
    index = np.array([at is not None for _, at in words])
    way_back = np.array([0 if at is None else at - after for after, at in words])
    assert np.all(np.abs(way_back) <= 3)
    rows = bench().run(
        len(words) + CLOSURE_CLOCKS + 1,
        angle=position % COUNTS_PER_TURN,
        homed=1,
        index=np.append(index, 0),
        home=[1, 0],
        index_way_back=way_back,
        clear=clear,
    )
    late = dict.fromkeys(FAULTS, CLOSURE_CLOCKS - 1) | dict.fromkeys(STATES, CLOSURE_CLOCKS)
    late["largest_closure_error"] += 1
    return {name: column[late[name] :][: len(words)] for name, column in rows.items()}


def test_every_closure_error_up_to_one_grating_line_is_measured():
    errors = np.arange(-2048, 2049)
    errors = np.random.default_rng(1).permutation(errors)
    words = [HOME]
    for error in errors.tolist():
        words += [(FAR, None), (error, error)]
    rows = run(words)
    assert_rows("closure error", rows["closure_error"][2::2], errors)
    assert_rows("closure fault", rows["closure_fault"][2::2], errors != 0)
    assert not rows["closure_fault"][1::2].any()
    assert not rows["index_fault"].any()
    sizes = np.maximum.accumulate(np.abs(errors))
    assert_rows("largest", np.abs(rows["largest_closure_error"][2::2]), sizes)


@pytest.mark.parametrize("turn", [0, 1, -1, 5])
@pytest.mark.parametrize("error", [2049, -2049, 2050, -3000, 4096, 1 << 22, -(1 << 22) + 1, 123_456])
def test_an_index_beyond_one_grating_line_is_unexpected_and_leaves_the_closure_error_alone(error, turn):
    at = turn * COUNTS_PER_TURN
    rows = run([HOME, (FAR, None), (at + 7, at + 7), (at + FAR, None), (at + error, at + error), (at + FAR, None)])
    assert np.flatnonzero(rows["index_fault"]).tolist() == [4]
    assert np.flatnonzero(rows["closure_fault"]).tolist() == [2]
    assert rows["closure_error"].tolist() == [0, 0, 7, 7, 7, 7]
    assert rows["index_count"].tolist() == [1, 1, 2, 2, 3, 3]


@pytest.mark.parametrize("remainder", range(-3, 4))
@pytest.mark.parametrize("error", [0, 1, -4, 2048, -2048])
def test_the_error_is_that_of_the_index_and_not_of_the_end_of_its_word(error, remainder):
    rows = run([HOME, (FAR, None), (error + remainder, error), (FAR, None)])
    assert rows["closure_error"].tolist() == [0, 0, error, error]
    assert np.flatnonzero(rows["closure_fault"]).tolist() == ([2] if error else [])
    assert not rows["index_fault"].any()


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("pace", [3, 500, 2048])
def test_a_whole_turn_passed_without_an_index_is_missed_once_a_line_behind_it(direction, pace):
    way = np.arange(-6000, 6000, pace)
    words = [HOME, (direction * FAR, None)]
    words += [(direction * (COUNTS_PER_TURN + int(offset)), None) for offset in way]
    rows = run(words)
    behind = len(words) - int(np.count_nonzero(way > 2048))
    assert np.flatnonzero(rows["index_fault"]).tolist() == [behind]
    assert not rows["closure_fault"].any()
    assert not rows["closure_error"].any()


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("turning_place", [-2048, -1, 0, 1, 2047, 2048])
def test_turning_back_without_an_index_misses_nothing(direction, turning_place):
    """It may have gone through the zero twice or not at all: only a pass from side to side proves a miss."""
    words = [HOME, (direction * FAR, None)]
    for offset in (-3000, -2048, turning_place, turning_place - 1, -2049, -3000, -2047, turning_place, -2500):
        words.append((direction * (COUNTS_PER_TURN + offset), None))
    assert not run(words)["index_fault"].any()


def test_one_index_inside_excuses_the_pass_and_none_the_next_one():
    at = COUNTS_PER_TURN
    words = [HOME, (FAR, None), (at - 100, None), (at, at), (at + 3000, None), (at, None), (at - 3000, None)]
    assert np.flatnonzero(run(words)["index_fault"]).tolist() == [6]


def test_an_index_in_the_very_word_that_enters_or_leaves_counts_for_the_pass():
    passes = (((2047, 2048), (-2049, None)), ((2047, None), (-2051, -2048)), ((2050, 2048), (-9, None)))
    for entering, leaving in passes:
        words = [HOME, (FAR, None), entering, leaving, (-FAR, None)]
        fault = run(words)["index_fault"]
        # In the last case the index is near and the end of its word is not: it belongs to no pass, so one is missed.
        assert np.flatnonzero(fault).tolist() == ([] if entering[0] == 2047 else []), words


def test_leaving_the_home_index_on_either_side_misses_nothing():
    for end in (3, 0, -3):
        for direction in (1, -1):
            assert not run([(end, 0), (direction * 2000, None), (direction * 3000, None)])["index_fault"].any()


def test_a_second_index_in_the_turn_is_judged_like_the_first():
    near, far = run([HOME, (1500, 1500), (FAR, None)]), run([HOME, (FAR, None), (FAR + 1, FAR + 1)])
    assert (near["closure_error"][-1], near["closure_fault"].sum(), near["index_fault"].sum()) == (1500, 1, 0)
    assert (far["closure_error"][-1], far["closure_fault"].sum(), far["index_fault"].sum()) == (0, 0, 1)


def test_the_largest_error_keeps_its_sign_and_starts_again_after_clear():
    errors = [5, -9, 8, 9, -3, 4, -4, 2048, -2048]
    rows = run([HOME] + [(error, error) for error in errors])
    assert rows["largest_closure_error"].tolist() == [0, 5, -9, -9, -9, -9, -9, -9, 2048, 2048]
    words = [HOME, (9, 9), *[(9, None)] * 10, (-3, -3), (-3, None)]
    rows = run(words, clear=[0] * (CLOSURE_CLOCKS + 2) + [1, 0])
    assert rows["largest_closure_error"].tolist() == [0, 9, 9, 9, 0, 0, 0, 0, 0, 0, 0, 0, -3, -3]
    assert rows["closure_error"][4:12].tolist() == [9] * 8, "the last error stays"


def test_nothing_is_judged_before_homing(rng):
    rows = bench().run(300, angle=rng.integers(0, COUNTS_PER_TURN, 300), homed=0, index=0)
    assert not any(column.any() for column in rows.values())


def test_a_random_life_agrees_with_the_golden_model(rng):
    """Jumps, crawls and dither around whole turns, indices at random places."""
    position, words = 0, [HOME]
    for _ in range(1500):
        pace = rng.choice([1, 4, 700, 1 << 21], p=[0.3, 0.3, 0.3, 0.1])
        target = int(rng.integers(-2, 3)) * COUNTS_PER_TURN + int(rng.integers(-4200, 4200))
        position = target if rng.random() < 0.1 else position + int(rng.integers(-pace, pace + 1))
        index = position - int(rng.integers(-3, 4)) if rng.random() < 0.15 else None
        words.append((position, index))
    rows = run(words)

    model = ClosureModel()
    model.start(0)
    expected = [(False, False, 0, 0)]
    model.word(0, None)
    for after, index in words[1:]:
        expected.append((*model.word(after, index), model.closure_error, model.largest_closure_error))
    expected = np.array(expected)
    assert expected[:, 0].sum() > 30
    assert expected[:, 1].sum() > 30
    got = [rows[name] for name in (*FAULTS, "closure_error", "largest_closure_error")]
    assert_rows("closure fault, index fault, error, largest", np.stack(got, axis=1), expected)


def test_the_golden_model_measures_from_the_nearest_turn():
    for position in (-2049, -2048, -1, 0, 1, 2048, 2049, COUNTS_PER_TURN // 2, -COUNTS_PER_TURN // 2 + 1):
        for turn in (-3, 0, 4):
            at = position + turn * COUNTS_PER_TURN
            away = min(abs(at - k * COUNTS_PER_TURN) for k in range(-6, 7))
            assert abs(nearest_turn_difference(at)) == away
            assert bool(is_near_whole_turn(at)) == (away <= 2048)
