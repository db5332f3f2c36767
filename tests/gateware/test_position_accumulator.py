"""The 48-bit position: every carry and borrow arrives, and homing is exact in the word."""

import numpy as np
import pytest
from amaranth.hdl import Signal
from amaranth_bench import Bench, assert_rows

import arcref_gateware.register_stages as register_stages
from arcref_gateware.position import (
    ANGLE_CLOCKS,
    POSITION_CLOCKS,
    POSITION_SEGMENTS,
    PositionAccumulator,
)

INPUTS = ["advance", "home", "event_way_back"]
OUTPUTS = ["angle", "event_angle", "position"]
SETTLED = POSITION_CLOCKS + len(POSITION_SEGMENTS)


def straightened(column, first_clock, words):
    """Positions after each word, from segments that come a clock apart."""
    position = np.zeros(words, dtype=np.int64)
    for place, (low, high) in enumerate(POSITION_SEGMENTS):
        part = column[first_clock + place :][:words] >> low & (1 << high - low) - 1
        position |= part << low
    return (position ^ 1 << 47) - (1 << 47)


def run(totals, home=0, event_way_back=0):
    """Position, position at the event, and the angles of both, after each word."""
    words = len(totals)
    after = np.insert(np.atleast_1d(event_way_back), 0, 0)
    rows = Bench(PositionAccumulator(), INPUTS, OUTPUTS).run(
        words + SETTLED + 1, advance=totals, home=home, event_way_back=after
    )
    return (
        straightened(rows["position"], POSITION_CLOCKS, words),
        rows["angle"][ANGLE_CLOCKS:][:words],
        rows["event_angle"][ANGLE_CLOCKS + 1 :][:words],
    )


@pytest.fixture
def start_at(monkeypatch):
    """Makes the accumulator start from a position that a simulation would never reach by counting."""

    def set_start(position):
        start = {
            f"segment{place}": position >> low & (1 << high - low) - 1
            for place, (low, high) in enumerate(POSITION_SEGMENTS)
        }

        def signal(*shape, name=None, **options):
            # Only the four registers of the sum; those of the events carry other names.
            return Signal(*shape, name=name, **options | ({"init": start[name]} if name in start else {}))

        monkeypatch.setattr(register_stages, "Signal", signal)

    return set_start


def assert_position(rows, position, way_back=0):
    got, angle, event_angle = rows
    assert_rows("position", got, position)
    assert_rows("angle", angle, position & (1 << 23) - 1)
    assert_rows("angle at the event", event_angle, (position + way_back) & (1 << 23) - 1)


def test_random_steps_add_up(rng):
    totals = rng.integers(-4, 5, 1500)
    way_back = rng.integers(-3, 4, 1500)
    assert_position(run(totals, event_way_back=way_back), np.cumsum(totals), way_back)


def test_zero_and_minus_one_borrow_and_carry_through_all_48_bits(rng):
    """Around zero every segment changes at once, time after time, with the next carry right behind."""
    totals = np.concatenate((np.tile([-1, 1], 20), np.tile([-4, 4, 0, 3, -3], 20), rng.integers(-4, 5, 400)))
    position = np.cumsum(totals)
    position -= np.round(position / 6).astype(int) * 6
    totals = np.diff(position, prepend=0).clip(-4, 4)
    position = np.cumsum(totals)
    assert np.count_nonzero(np.diff(position < 0)) > 100
    way_back = rng.integers(-3, 4, len(totals))
    assert_position(run(totals, event_way_back=way_back), position, way_back)


@pytest.mark.parametrize("direction", [1, -1])
def test_a_fast_run_carries_out_of_the_lowest_segment(direction):
    totals = np.repeat([4 * direction, -3 * direction], [1100, 1500])
    assert_position(run(totals), np.cumsum(totals))


@pytest.mark.parametrize("boundary", [1 << 12, 1 << 23, 1 << 24, 1 << 36, 3 << 36, -(1 << 24), -(1 << 36), 5 << 40])
def test_every_segment_boundary_is_crossed_both_ways(boundary, start_at, rng):
    start = boundary - 9
    start_at(start)
    totals = np.concatenate((np.repeat([0, 4, -4, 1, -1], [6, 5, 5, 20, 20]), rng.integers(-3, 4, 150)))
    way_back = rng.integers(-3, 4, len(totals))
    position = start + np.cumsum(totals)
    assert np.count_nonzero(np.diff(position >= boundary)) >= 4
    rows = run(totals, event_way_back=way_back)
    settled = slice(SETTLED, None)  # before that the registers of the event still hold their reset value
    assert_position([column[settled] for column in rows], position[settled], way_back[settled])


@pytest.mark.parametrize("direction", [1, -1])
def test_the_position_wraps_at_48_bits_and_keeps_its_sign(direction, start_at):
    most = (1 << 47) - 1
    start_at(most - 4 if direction > 0 else -(1 << 47) + 4)
    totals = np.repeat([0, direction], [6, 12])
    got = run(totals)[0]
    start = most - 4 if direction > 0 else -(1 << 47) + 4
    expected = start + np.cumsum(totals)
    expected = (expected + (1 << 47)) % (1 << 48) - (1 << 47)
    assert_rows("position", got[SETTLED:], expected[SETTLED:])


@pytest.mark.parametrize("home_remainder", range(-3, 4))
@pytest.mark.parametrize("before", [-1500, -1, 0, 1, 1500])
def test_homing_sets_the_zero_on_the_index_and_forgets_what_was_before(before, home_remainder, rng):
    sign = 1 if before >= 0 else -1
    way = np.repeat([4 * sign, sign], [abs(before) // 4, abs(before) % 4])
    totals = np.concatenate((way, rng.integers(-4, 5, 60)))
    at = len(totals) - 50
    home = np.arange(len(totals)) == at
    way_back = rng.integers(-3, 4, len(totals))
    position = np.cumsum(totals)
    position[at:] += home_remainder - position[at]
    rows = run(np.where(home, home_remainder, totals), home, way_back)
    assert_position(rows, position, way_back)
