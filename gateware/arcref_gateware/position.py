"""The 48-bit position: steps summed up in segments, a clock apart.

Segment k of a position comes k clocks after segment 0, and whoever adds to it goes on in the same way: nothing waits
for a carry.
"""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS, POSITION_BITS
from arcref_gateware.register_stages import add_small_to_segment, aligned, delayed, segment_bounds, skewed_add

POSITION_SEGMENTS = segment_bounds(POSITION_BITS)
"""Where a position is cut: `(low, high)` of each segment."""

ANGLE_SEGMENTS = sum(low < ANGLE_BITS for low, _ in POSITION_SEGMENTS)
"""Segments of the position that hold the angle."""

POSITION_CLOCKS = 1
"""Clocks from a word's step to the lowest segment of the position after it."""

ANGLE_CLOCKS = POSITION_CLOCKS + ANGLE_SEGMENTS - 1
"""Clocks from a word's step to the angle after it."""


def segments_of(position) -> list:
    """The segments of a position, the lowest first."""
    return [position[low:high] for low, high in POSITION_SEGMENTS]


class PositionAccumulator(wiring.Component):
    """Signed position after each word.

    With `home` the sum starts again from zero, which puts the zero on the index's own sample when `advance` is the sum
    of the steps after it.
    """

    advance: In(signed(4))
    """Sum of the word's steps."""
    home: In(1)
    """1 with the word that holds the first index."""
    event_way_back: In(signed(3))
    """Minus the sum of the word's steps after the sample of an event, given one clock after `advance`."""
    angle: Out(ANGLE_BITS)
    """Angle after the word, `ANGLE_CLOCKS` clocks after `advance`."""
    event_angle: Out(ANGLE_BITS)
    """Angle at the event's sample, `ANGLE_CLOCKS` + 1 clocks after `advance`."""
    position: Out(signed(POSITION_BITS))
    """Position after the word; its segment k comes `POSITION_CLOCKS` + k clocks after `advance`."""

    def elaborate(self, platform):
        m = Module()
        carry, home = self.advance, self.home
        segments = []
        for place, (low, high) in enumerate(POSITION_SEGMENTS):
            # Homing starts the sum again from zero, each segment when the homing word reaches it.
            kept = Signal(high - low, name=f"kept{place}")
            segment, carry = add_small_to_segment(m, kept, carry, name=f"segment{place}", restart=home)
            m.d.comb += kept.eq(segment)
            segments.append(segment)
            home = delayed(m, home, 1, name=f"home{place}")
        angle_segments = segments[:ANGLE_SEGMENTS]
        event_segments = skewed_add(m, angle_segments, self.event_way_back, name="event")
        m.d.comb += [
            self.position.eq(Cat(segments)),
            self.angle.eq(aligned(m, angle_segments, name="angle")),
            self.event_angle.eq(aligned(m, event_segments, name="event_angle")),
        ]
        return m
