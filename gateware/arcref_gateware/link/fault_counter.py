"""Counts the words in which a fault's cause was there; stays at 65535."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

FAULT_COUNT_CLOCKS = 3
"""Clocks from `cause` to `count`."""

_HALF = 8


class FaultCounter(wiring.Component):
    """A 16-bit counter in two halves, so that its carry does not limit the word clock."""

    cause: In(1)
    """1 with each word that has the fault."""
    count: Out(16)
    """How many there were, `FAULT_COUNT_CLOCKS` clocks later."""

    def elaborate(self, platform):
        m = Module()
        low, high, shown_low = Signal(_HALF), Signal(_HALF), Signal(_HALF)
        cause, carry, full = Signal(), Signal(), Signal()
        # `full` is known two counts early and then holds the last ones back one by one.
        last_high = Signal()
        m.d.sync += [
            cause.eq(self.cause),
            last_high.eq(high == (1 << _HALF) - 1),
            carry.eq(0),
            shown_low.eq(low),
            self.count.eq((high << _HALF) | shown_low),
        ]
        m.d.comb += full.eq(last_high & (low == (1 << _HALF) - 1))
        with m.If(cause & ~full):
            m.d.sync += [low.eq(low + 1), carry.eq(low == (1 << _HALF) - 1)]
        with m.If(carry):
            m.d.sync += high.eq(high + 1)
        return m
