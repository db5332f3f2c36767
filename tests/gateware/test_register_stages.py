"""Pipelined adders: the carry crosses every cut, both ways, for any width."""

import numpy as np
import pytest
from amaranth.hdl import Module, signed, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth_bench import Bench, assert_rows

from arcref_gateware.register_stages import SEGMENT_BITS, delayed, pipeline_clocks, pipelined_add, segment_bounds


class Add(wiring.Component):
    """`base + small`, or `base + small + carry_in`, on its own."""

    def __init__(self, base, small, segment_bits, has_carry_in):
        self.segment_bits, self.has_carry_in = segment_bits, has_carry_in
        super().__init__({"base": In(base), "small": In(small), "carry_in": In(1), "result": Out(base)})

    def elaborate(self, platform):
        m = Module()
        options = {"carry_in": self.carry_in} if self.has_carry_in else {}
        total = pipelined_add(m, self.base, self.small, name="total", segment_bits=self.segment_bits, **options)
        m.d.comb += self.result.eq(total)
        return m


class Delay(wiring.Component):
    """`delayed` on its own."""

    def __init__(self, clocks):
        self.clocks = clocks
        super().__init__({"value": In(signed(5)), "result": Out(signed(5))})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.result.eq(delayed(m, self.value, self.clocks, name="value"))
        return m


def hostile_bases(rng, width: int, segment_bits: int, count: int) -> np.ndarray:
    """Random numbers, half of them a step or so from where a carry runs through one or more segments."""
    bases = rng.integers(0, 1 << width, count)
    boundary = np.array([0, *(1 << high for _, high in segment_bounds(width, segment_bits))])
    multiple = rng.choice(boundary, count) * rng.integers(1, 4, count)
    close = multiple + rng.integers(-9000, 9000, count) // rng.choice([1, 1000, 4000], count)
    return np.where(rng.random(count) < 0.5, close, bases) & ((1 << width) - 1)


@pytest.mark.parametrize("has_carry_in", [False, True])
@pytest.mark.parametrize("segment_bits", [SEGMENT_BITS, 8, 16])
@pytest.mark.parametrize("small_bits", [3, 4, 12, 13, 14, 24, 48])
@pytest.mark.parametrize("shape", [signed(48), unsigned(48), unsigned(23), signed(24), signed(13)], ids=str)
def test_a_number_is_added_and_carries_through_every_segment(shape, small_bits, segment_bits, has_carry_in, rng):
    small_bits = min(small_bits, shape.width)
    count = 200
    clocks = pipeline_clocks(shape.width, segment_bits)
    base = hostile_bases(rng, shape.width, segment_bits, count)
    small = rng.integers(-(1 << small_bits - 1), 1 << small_bits - 1, count)
    carry_in = rng.integers(0, 1 + has_carry_in, count)
    sign = (1 << shape.width - 1) if shape.signed else 0
    base = (base ^ sign) - sign
    bench = Bench(Add(shape, signed(small_bits), segment_bits, has_carry_in), ["base", "small", "carry_in"], ["result"])
    rows = bench.run(count + clocks, base=base, small=small, carry_in=carry_in)

    wrapped = (((base + small + carry_in) & ((1 << shape.width) - 1)) ^ sign) - sign
    assert_rows("total", rows["result"][clocks:], wrapped)


@pytest.mark.parametrize("width", [1, 11, 12, 13, 24, 48])
def test_segments_cover_every_bit_once(width):
    bounds = segment_bounds(width)
    assert [bit for low, high in bounds for bit in range(low, high)] == list(range(width))
    assert all(high - low <= SEGMENT_BITS for low, high in bounds)


@pytest.mark.parametrize("clocks", [1, 2, 5])
def test_a_delay_takes_its_clocks_and_keeps_the_sign(clocks, rng):
    values = rng.integers(-16, 16, 40)
    rows = Bench(Delay(clocks), ["value"], ["result"]).run(40 + clocks, value=values)
    assert not rows["result"][:clocks].any()
    assert_rows("delayed", rows["result"][clocks:], values)
