"""Time: words since reset, whose segments step together."""

import numpy as np
import pytest
from amaranth.hdl import Signal
from amaranth_bench import Bench, assert_rows

import arcref_gateware.time_counter as time_counter
from arcref_gateware.register_stages import segment_bounds
from arcref_gateware.time_counter import TimeCounter


def run(clocks, start_clock):
    valid = np.arange(clocks) >= start_clock
    return Bench(TimeCounter(), ["valid"], ["words"]).run(clocks, valid=valid)["words"]


@pytest.mark.parametrize("start_clock", [0, 1, 9])
def test_the_first_valid_word_is_number_0_and_every_one_counts(start_clock):
    words = run(9000, start_clock)
    first = start_clock
    assert not words[:first].any()
    assert_rows("words", words[first:], np.arange(9000 - first))


@pytest.mark.parametrize("boundary", [1 << 12, 1 << 24, 1 << 36, 7 << 36, (1 << 36) + (1 << 24), 1 << 48])
def test_every_segment_boundary_is_crossed(boundary, monkeypatch):
    start = boundary - 20
    segments = {
        f"segment{place}": start >> low & (1 << high - low) - 1 for place, (low, high) in enumerate(segment_bounds(48))
    }

    def signal(*shape, name=None, **options):
        return Signal(*shape, name=name, **options | ({"init": segments[name]} if name in segments else {}))

    monkeypatch.setattr(time_counter, "Signal", signal)
    words = run(60, 0)
    assert_rows("words", words, (start + np.arange(len(words))) % (1 << 48))
