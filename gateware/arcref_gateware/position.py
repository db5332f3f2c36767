"""The 48-bit position: steps summed up in segments, a clock apart, and aligned again before anyone reads it."""

from amaranth.hdl import Cat, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref_gateware.register_stages import add_small_to_segment, delayed, segment_bounds

ANGLE_CLOCKS = 2
"""Clocks from a word's total to the lowest 24 bits of the position."""

POSITION_CLOCKS = len(segment_bounds(POSITION_BITS))
"""Clocks from a word's total to the whole position."""


class PositionAccumulator(wiring.Component):
    """Signed position after each word.

    With `home` the position after that word becomes `home_remainder`, which puts the zero on the index's own sample.
    """

    total: In(signed(4))
    """Sum of the word's steps."""
    home: In(1)
    """1 with the word that holds the first index."""
    home_remainder: In(signed(3))
    """Sum of the word's steps after the index."""
    event_way_back: In(signed(3))
    """Minus the sum of the word's steps after the sample of an event, given one clock after `total`."""
    angle: Out(24)
    """Lowest 24 bits of the position after the word, `ANGLE_CLOCKS` clocks after `total`."""
    event_angle: Out(24)
    """Lowest 24 bits of the position at the event's sample, `ANGLE_CLOCKS` + 1 clocks after `total`."""
    position: Out(signed(POSITION_BITS))
    """Position after the word, `POSITION_CLOCKS` clocks after `total`."""

    def elaborate(self, platform):
        m = Module()
        bounds = segment_bounds(POSITION_BITS)
        carry = Mux(self.home, self.home_remainder, self.total)
        home = self.home
        segments = []
        for place, (low, high) in enumerate(bounds):
            kept = Signal(high - low, name=f"kept{place}")
            segment, next_carry = add_small_to_segment(m, kept, carry, name=f"segment{place}")
            # Homing starts the sum again from zero, each segment when the homing word reaches it.
            m.d.comb += kept.eq(Mux(home, 0, segment))
            segments.append(segment)
            carry, home = next_carry, delayed(m, home, 1, name=f"home{place}")

        m.d.comb += self.angle.eq(Cat(delayed(m, segments[0], 1, name="angle0"), segments[1]))
        event0, event_carry = add_small_to_segment(m, segments[0], self.event_way_back, name="event0")
        event1, _ = add_small_to_segment(m, segments[1], event_carry, name="event1")
        m.d.comb += self.event_angle.eq(Cat(delayed(m, event0, 1, name="event0"), event1))
        aligned = [
            delayed(m, segment, len(segments) - 1 - place, name=f"aligned{place}")
            for place, segment in enumerate(segments)
        ]
        m.d.comb += self.position.eq(Cat(*aligned))
        return m
