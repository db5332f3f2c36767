"""A 32-bit counter in two halves, so that its carry does not limit the word clock."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

WIDE_COUNTER_BITS = 32
WIDE_COUNTER_CLOCKS = 2
"""Clocks from a count to `total`."""

_HALF = WIDE_COUNTER_BITS // 2


class WideCounter(wiring.Component):
    """Counts modulo 2^32."""

    count: In(1)
    """1 with each thing to count."""
    clear: In(1)
    """1 for one clock: start from 0."""
    total: Out(WIDE_COUNTER_BITS)
    """How many there were, `WIDE_COUNTER_CLOCKS` clocks later."""

    def elaborate(self, platform):
        m = Module()
        low, high, aligned_low, carry = Signal(_HALF), Signal(_HALF), Signal(_HALF), Signal()
        m.d.comb += self.total.eq(Cat(aligned_low, high))
        m.d.sync += [
            low.eq(low + self.count),
            carry.eq(self.count & (low == (1 << _HALF) - 1)),
            aligned_low.eq(low),
            high.eq(high + carry),
        ]
        with m.If(self.clear):
            m.d.sync += [low.eq(0), carry.eq(0), aligned_low.eq(0), high.eq(0)]
        return m
