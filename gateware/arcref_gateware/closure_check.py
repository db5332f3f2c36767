"""The proof that no count was lost: every index must come at a whole number of turns from the first one."""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS, COUNTS_PER_LINE
from arcref_gateware.register_stages import delayed, pipelined_subtract

CLOSURE_BITS = 24
"""Bits of a closure error."""

CLOSURE_CLOCKS = 4
"""Clocks from a word's position to the state after it."""


def _near_whole_turn(m: Module, angle, *, name: str):
    """Register whether a signed angle lies within one grating line of zero. Returns `(near, negative)`."""
    near, negative = Signal(name=f"{name}_near"), Signal(name=f"{name}_negative")
    line_bits = COUNTS_PER_LINE.bit_length() - 1
    low, high = angle[:line_bits], angle[line_bits:]
    at_upper_end = (high == 1) & (low == 0)
    m.d.sync += [near.eq((high == 0) | high.all() | at_upper_end), negative.eq(angle[-1])]
    return near, negative


class ClosureCheck(wiring.Component):
    """Judges every index after the first, and watches for whole turns that go by without one.

    The closure error is the index's position less the nearest whole turn. Beyond one grating line (2048 counts) it is
    no closure error but an unexpected index. A whole turn passed from more than a line on one side to more than a
    line on the other without an index is a missing index. Neither changes the closure error.
    """

    angle: In(ANGLE_BITS)
    """Angle after the word."""
    homed: In(1)
    """1 when the word is homed."""
    index: In(1)
    """1 when the word holds an index."""
    home: In(1)
    """1 when that index homes."""
    index_remainder: In(signed(3))
    """Sum of the word's steps after the index."""
    clear: In(1)
    """1 starts the search for the largest closure error again."""
    closure_error: Out(signed(CLOSURE_BITS))
    """Closure error at the last index that was checked, in counts."""
    largest_closure_error: Out(signed(CLOSURE_BITS))
    """The closure error that was largest in size, with its sign."""
    index_count: Out(16)
    """Indices since reset, the homing and the unexpected ones among them, modulo 65536."""
    closure_fault: Out(1)
    """1 with a word whose index had a closure error. One clock before `closure_error`."""
    index_fault: Out(1)
    """1 with a word whose index was unexpected, or in which a missing index was found out. With `closure_fault`."""

    def elaborate(self, platform):
        m = Module()
        # Two clocks: the index's own angle; the word's angle waits for it.
        at_index = Signal(signed(ANGLE_BITS))
        m.d.comb += at_index.eq(pipelined_subtract(m, self.angle, self.index_remainder, name="at_index"))
        waited = Signal(signed(ANGLE_BITS))
        m.d.comb += waited.eq(delayed(m, self.angle, 2, name="angle"))
        # Third clock: near a whole turn or not.
        index_near, _ = _near_whole_turn(m, at_index, name="index")
        word_near, word_negative = _near_whole_turn(m, waited, name="word")
        error = delayed(m, at_index, 1, name="error")
        homed = delayed(m, self.homed, 3, name="homed")
        index = delayed(m, self.index, 3, name="index")
        home = delayed(m, self.home, 3, name="home")

        checked = index & ~home
        inside, seen, came_from_below = Signal(), Signal(), Signal()
        enters = homed & word_near & ~inside
        leaves = homed & ~word_near & inside
        index_here = index & (home | index_near)
        has_seen = (seen & ~enters) | index_here
        passed = leaves & (came_from_below ^ word_negative)
        m.d.comb += [
            self.closure_fault.eq(checked & index_near & (error != 0)),
            self.index_fault.eq((checked & ~index_near) | (passed & ~has_seen)),
        ]
        # Fourth clock: the state after the word.
        m.d.sync += seen.eq(has_seen)
        with m.If(enters):
            m.d.sync += [inside.eq(1), came_from_below.eq(word_negative)]
        with m.If(leaves):
            m.d.sync += inside.eq(0)
        with m.If(index):
            m.d.sync += self.index_count.eq(self.index_count + 1)
        with m.If(checked & index_near):
            m.d.sync += self.closure_error.eq(error)

        size = Signal(range(COUNTS_PER_LINE + 1))
        largest_size = Signal(range(COUNTS_PER_LINE + 1))
        sized, sized_error = Signal(), Signal(signed(CLOSURE_BITS))
        m.d.sync += [size.eq(Mux(error < 0, -error, error)), sized.eq(checked & index_near), sized_error.eq(error)]
        with m.If(self.clear):
            m.d.sync += [largest_size.eq(0), self.largest_closure_error.eq(0)]
        with m.Elif(sized & (size > largest_size)):
            m.d.sync += [largest_size.eq(size), self.largest_closure_error.eq(sized_error)]
        return m
