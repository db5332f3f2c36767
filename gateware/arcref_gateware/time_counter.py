"""A word counter as wide as a position, whose carries are known before they are due."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref_gateware.register_stages import segment_bounds


class TimeCounter(wiring.Component):
    """Number of the present word since reset, at the pipeline stage that `valid` comes from.

    Times in sample periods put the sample's place in its word below this count; 48 bits of samples last four days at
    800 M samples/s.
    """

    valid: In(1)
    """1 from the first word after reset on."""
    words: Out(POSITION_BITS)
    """Words before this one, modulo 2^48."""

    def elaborate(self, platform):
        m = Module()
        segments = [
            Signal(high - low, name=f"segment{place}")
            for place, (low, high) in enumerate(segment_bounds(POSITION_BITS))
        ]
        m.d.comb += self.words.eq(Cat(*segments))
        lowest, *others = segments
        m.d.sync += lowest.eq(lowest + self.valid)
        # The others stand still for as long as the lowest takes to run over, so there is time to see whether all below
        # one of them are full, and every segment steps in the same clock.
        near_end = Signal()
        m.d.sync += near_end.eq(lowest == (1 << len(lowest)) - 3)
        full_below = near_end
        for place, segment in enumerate(others):
            steps = Signal(name=f"steps{place}")
            m.d.sync += [steps.eq(full_below), segment.eq(segment + steps)]
            full = Signal(name=f"full{place}")
            m.d.sync += full.eq(segment.all())
            full_below = full_below & full
        return m
