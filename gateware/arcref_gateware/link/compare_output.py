"""The compare output: a pulse each time the corrected position passes a line of a grid, every K counts.

The grid begins at the first passage of the corrected angle past `start` after it was switched on. From then on one
line below and one above the position are known; passing one of them gives a pulse and moves both by K. A position
that stays beyond a line gives its pulse at any time, so nothing is lost while the lines are moved. One that comes back
within those ten words, as a shaft at rest on a line does, gives one pulse or none for it.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS
from arcref.link.registers import REGISTERS
from arcref_gateware.link.wide_counter import WideCounter
from arcref_gateware.register_stages import delayed, pipeline_clocks

PERIOD_BITS = REGISTERS["compare_period"].width
GRID_BITS = PERIOD_BITS + 2
"""Bits of a position in which a line and the position are never more than a quarter of the range apart."""

LEAST_PERIOD = 64
"""Smallest K: more counts than the position moves while the lines are moved."""

_SEGMENT = 13
COMPARE_CLOCKS = pipeline_clocks(GRID_BITS, _SEGMENT) + 4
"""Clocks from a position to its pulse."""

SETTLE_CLOCKS = 4
"""Clocks from a line that is moved to its first comparison."""


def _difference(m: Module, left, right, *, name: str):
    """`left - right`, two segments, two clocks; the operands are held aligned by the caller."""
    low = Signal(_SEGMENT + 1, name=f"{name}_low")
    high = Signal(GRID_BITS - _SEGMENT, name=f"{name}_high")
    left_high = delayed(m, left[_SEGMENT:], 1, name=f"{name}_left")
    right_high = delayed(m, right[_SEGMENT:], 1, name=f"{name}_right")
    low_later = delayed(m, low[:_SEGMENT], 1, name=f"{name}_low_later")
    m.d.sync += [
        low.eq(left[:_SEGMENT] - right[:_SEGMENT]),
        high.eq(left_high - right_high - low[-1]),
    ]
    return Cat(low_later, high).as_signed()


class CompareOutput(wiring.Component):
    """Pulses of `width` word clocks; a passage during a pulse makes it longer."""

    position: In(signed(48))
    """Corrected position after a word, in counts."""
    homed: In(1)
    """1 when the word was homed; until then there is no pulse."""
    period: In(PERIOD_BITS)
    """K, in counts; below `LEAST_PERIOD` the output is off."""
    start: In(ANGLE_BITS)
    """Corrected angle that has a pulse."""
    width: In(16)
    """Length of a pulse, in word clocks; 0 counts as 1."""
    pulse: Out(1)
    """The output, `COMPARE_CLOCKS` clocks after the position that passed a line."""
    count: Out(32)
    """Pulses since reset, modulo 2^32."""

    def elaborate(self, platform):
        m = Module()
        position = Signal(GRID_BITS)
        enabled = Signal()
        period = Signal(GRID_BITS)
        m.d.sync += [
            position.eq(self.position[:GRID_BITS]),
            enabled.eq(self.homed & (self.period[LEAST_PERIOD.bit_length() - 1 :] != 0)),
            period.eq(self.period),
        ]
        lower, upper = Signal(GRID_BITS), Signal(GRID_BITS)
        above = _difference(m, position, upper, name="above")
        below = _difference(m, position, lower, name="below")
        # While it waits, the distance from the start is that of the angle.
        start = Cat(self.start, Const(0, GRID_BITS - ANGLE_BITS))
        from_start = _difference(m, position, start, name="from_start")
        shown = delayed(m, position, 2, name="shown")

        distance = from_start[:ANGLE_BITS].as_signed()
        near, is_below, was_near, was_below = Signal(), Signal(), Signal(), Signal()
        passes_up, passes_down = Signal(), Signal()
        near_bits = distance[8:]
        m.d.sync += [
            near.eq((near_bits == 0) | near_bits.all()),
            is_below.eq(distance < 0),
            was_near.eq(near),
            was_below.eq(is_below),
            passes_up.eq(~above[-1]),
            passes_down.eq(below[-1]),
        ]
        line = Signal(GRID_BITS)  # the line that the start's passage is at
        m.d.sync += line.eq(shown - distance)
        settle = Signal(range(SETTLE_CLOCKS + 3))
        passed = Signal()
        moved_up = Signal()
        other, other_low, step = Signal(GRID_BITS), Signal(_SEGMENT + 1), Signal(GRID_BITS)
        m.d.sync += [passed.eq(0)]
        with m.FSM():
            with m.State("OFF"):
                m.d.sync += settle.eq(SETTLE_CLOCKS + 2)
                with m.If(enabled):
                    m.next = "WAIT"
            with m.State("WAIT"):
                # The first comparisons are of a time before it was switched on.
                with m.If(settle != 0):
                    m.d.sync += settle.eq(settle - 1)
                with m.Elif(near & was_near & (is_below != was_below)):
                    m.d.sync += [passed.eq(1), lower.eq(line), upper.eq(line), moved_up.eq(~is_below)]
                    m.next = "FIRST"
                with m.If(~enabled):
                    m.next = "OFF"
            with m.State("FIRST"):
                # Both lines are at the one just passed. One of them goes K further on, in two steps.
                m.d.sync += step.eq(Mux(moved_up, period, -period))
                m.next = "STEP"
            with m.State("STEP"):
                m.d.sync += other_low.eq(lower[:_SEGMENT] + step[:_SEGMENT])
                m.next = "CARRY"
            with m.State("CARRY"):
                m.d.sync += other.eq(Cat(other_low[:_SEGMENT], lower[_SEGMENT:] + step[_SEGMENT:] + other_low[-1]))
                m.next = "PLACE"
            with m.State("PLACE"):
                m.d.sync += settle.eq(SETTLE_CLOCKS)
                with m.If(moved_up):
                    m.d.sync += upper.eq(other)
                with m.Else():
                    m.d.sync += lower.eq(other)
                m.next = "SETTLE"
            with m.State("SETTLE"):
                m.d.sync += settle.eq(settle - 1)
                with m.If(settle == 1):
                    m.next = "RUN"
                with m.If(~enabled):
                    m.next = "OFF"
            with m.State("RUN"):
                with m.If(passes_up):
                    m.d.sync += [passed.eq(1), lower.eq(upper), moved_up.eq(1)]
                    m.next = "FIRST"
                with m.Elif(passes_down):
                    m.d.sync += [passed.eq(1), upper.eq(lower), moved_up.eq(0)]
                    m.next = "FIRST"
                with m.If(~enabled):
                    m.next = "OFF"

        left = Signal(16)
        m.d.sync += self.pulse.eq(passed | left[1:].any())
        with m.If(passed):
            m.d.sync += left.eq(self.width)
        with m.Elif(left != 0):
            m.d.sync += left.eq(left - 1)
        m.submodules.counter = counter = WideCounter()
        m.d.comb += [counter.count.eq(passed), self.count.eq(counter.total)]
        return m
