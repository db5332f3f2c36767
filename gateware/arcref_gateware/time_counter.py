"""A word counter as wide as a position, its carries a clock apart."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref_gateware.register_stages import delayed, segment_bounds


class TimeCounter(wiring.Component):
    """Number of the present word since reset, at the pipeline stage that `valid` comes from.

    The count of a word is given `CLOCKS` clocks after the word's `valid`. Times in sample periods put the sample's
    place in its word below this count; 48 bits of samples last four days at 800 M samples/s.
    """

    CLOCKS = len(segment_bounds(POSITION_BITS))

    valid: In(1)
    """1 from the first word after reset on."""
    words: Out(POSITION_BITS)
    """Words before this one, modulo 2^48."""

    def elaborate(self, platform):
        m = Module()
        carry = self.valid
        parts = []
        bounds = segment_bounds(POSITION_BITS)
        for place, (low, high) in enumerate(bounds):
            # `following` is one ahead of the word's own number, which is what it held before.
            following = Signal(high - low, name=f"following{place}")
            own = Signal(high - low, name=f"own{place}")
            wrapped = Signal(name=f"wrapped{place}")
            m.d.sync += [own.eq(following), wrapped.eq(carry & following.all())]
            with m.If(carry):
                m.d.sync += following.eq(following + 1)
            carry = wrapped
            parts.append(delayed(m, own, len(bounds) - 1 - place, name=f"aligned{place}"))
        m.d.comb += self.words.eq(Cat(*parts))
        return m
