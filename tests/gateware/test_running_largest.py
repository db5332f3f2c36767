"""Running largest: exact for numbers that come one a clock, and after a clear at any clock."""

import numpy as np
import pytest
from amaranth_bench import Bench, assert_rows

from arcref_gateware.running_largest import RunningLargest


def by_hand(number, valid, clear):
    """`largest` and `takes` after each number; a clear forgets those before its own."""
    largest, rows, takes = 0, [], []
    for one, there, cleared in zip(number, valid, clear, strict=True):
        forgotten = 0 if cleared else largest
        takes.append(bool(there and (one > forgotten or cleared)))
        largest = max(one, forgotten) if there else forgotten
        rows.append(largest)
    return np.array(rows), np.array(takes)


@pytest.mark.parametrize("clears", [0.0, 0.02, 0.3])
@pytest.mark.parametrize("density", [0.1, 0.6, 1.0])
def test_every_number_counts_and_every_clear_forgets_those_before(density, clears, rng):
    bench = Bench(RunningLargest(6), ["number", "valid", "clear"], ["largest", "takes"])
    for highest in (3, 64):
        number = rng.integers(1, highest, 600)
        valid, clear = rng.random(600) < density, rng.random(600) < clears
        rows = bench.run(602, number=np.where(valid, number, 0), valid=np.append(valid, 0), clear=np.append(clear, 0))
        largest, takes = by_hand(number.tolist(), valid, clear)
        assert_rows("largest", rows["largest"][2:], largest)
        got = rows["takes"][1:-1].astype(bool)
        assert_rows("largest that was taken", np.where(got, number, 0), np.where(takes, number, 0))


def test_numbers_that_rise_by_one_each_clock_are_all_taken():
    rows = Bench(RunningLargest(12), ["number", "valid"], ["largest"]).run(302, number=range(302), valid=1)
    assert_rows("largest", rows["largest"][2:], np.arange(300))
