"""Delay line: registers and block RAM do the same, also after a reset."""

from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.hdl import Elaboratable, Fragment
from amaranth_bench import Bench, assert_rows

from arcref_gateware.delay_line import LEAST_MEMORY_CLOCKS, DelayLine


class OnPlatform(Elaboratable):
    """A delay line as it is made for a platform."""

    def __init__(self, line, platform):
        self.line, self.platform = line, platform
        self.value, self.delayed = line.value, line.delayed

    def elaborate(self, _):
        return Fragment.get(self.line, self.platform)


@pytest.mark.parametrize("device", ["iCE40HX8K", "iCE40UP5K", "LFE5U-25F"])
@pytest.mark.parametrize("clocks", [1, 2, LEAST_MEMORY_CLOCKS, 4, 7, 8, 9, 20])
def test_a_value_comes_after_its_clocks_also_after_a_reset(clocks, device, rng):
    length = 300
    bench = Bench(OnPlatform(DelayLine(16, clocks), SimpleNamespace(device=device)), ["value", "rst"], ["delayed"])
    value = rng.integers(1, 1 << 16, length)
    for _ in range(3):
        reset = np.zeros(length, int)
        for start in rng.integers(0, length, 4):
            reset[start : start + rng.integers(1, 4)] = 1
        expected = np.zeros(length, int)
        told = np.zeros(length, bool)
        since_reset = clocks  # from power-up on it is 0
        line = [0] * clocks
        for clock in range(length):
            expected[clock], told[clock] = line[0], since_reset >= clocks
            line = [0] * clocks if reset[clock] else [*line[1:], int(value[clock])]
            since_reset = 0 if reset[clock] else since_reset + 1
        got = bench.run(length, value=value, rst=reset)["delayed"]
        assert told.sum() > length // 2
        assert_rows("delayed", got[told], expected[told])
