"""The proof that no count was lost: every index must come at a whole number of turns from the first one."""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS, COUNTS_PER_LINE
from arcref_gateware.register_stages import delayed, pipelined_add

CLOSURE_BITS = 24
"""Bits of a closure error."""

CLOSURE_CLOCKS = 6
"""Clocks from a word's position to the state after it."""


def _near_whole_turn(m: Module, angle, *, name: str):
    """Register whether a signed angle lies within one grating line of zero."""
    near = Signal(name=f"{name}_near")
    line_bits = COUNTS_PER_LINE.bit_length() - 1
    low, high = angle[:line_bits], angle[line_bits:]
    at_upper_end = (high == 1) & (low == 0)
    m.d.sync += near.eq((high == 0) | high.all() | at_upper_end)
    return near


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
    index_way_back: In(signed(3))
    """Minus the sum of the word's steps after the index."""
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
        m.d.comb += at_index.eq(pipelined_add(m, self.angle, self.index_way_back, name="at_index"))
        waited = Signal(signed(ANGLE_BITS))
        m.d.comb += waited.eq(delayed(m, self.angle, 2, name="angle"))
        # Third clock: near a whole turn or not.
        index_near = _near_whole_turn(m, at_index, name="index")
        word_near = _near_whole_turn(m, waited, name="word")
        word_below = delayed(m, waited[-1], 1, name="word_below")
        index_off = Signal()
        m.d.sync += index_off.eq(at_index != 0)
        homed = delayed(m, self.homed, 3, name="homed")
        index = delayed(m, self.index, 3, name="index")
        home = delayed(m, self.home, 3, name="home")

        # Fourth clock: what happened in the word.
        inside, enters, leaves, below = Signal(), Signal(), Signal(), Signal()
        index_here, error_here, unexpected, checked_near = Signal(), Signal(), Signal(), Signal()
        checked = index & ~home
        m.d.sync += [
            inside.eq(homed & word_near),
            enters.eq(homed & word_near & ~inside),
            leaves.eq(~word_near & inside),
            below.eq(word_below),
            index_here.eq(index & (home | index_near)),
            checked_near.eq(checked & index_near),
            error_here.eq(checked & index_near & index_off),
            unexpected.eq(checked & ~index_near),
        ]

        # Fifth clock: the faults. A neighbourhood is left where it was entered, or its whole turn was passed.
        seen, came_from_below = Signal(), Signal()
        takes_error = Signal()
        m.d.sync += [
            seen.eq((seen & ~enters) | index_here),
            came_from_below.eq(Mux(enters, below, came_from_below)),
            takes_error.eq(checked_near),
            self.closure_fault.eq(error_here),
            self.index_fault.eq(unexpected | (leaves & (came_from_below ^ below) & ~seen & ~index_here)),
        ]
        error = delayed(m, at_index, 3, name="error")

        # Sixth clock: the state after the word.
        with m.If(delayed(m, index, 2, name="index_counted")):
            m.d.sync += self.index_count.eq(self.index_count + 1)
        with m.If(takes_error):
            m.d.sync += self.closure_error.eq(error)

        size = Signal(range(COUNTS_PER_LINE + 1))
        largest_size = Signal(range(COUNTS_PER_LINE + 1))
        sized, sized_error = Signal(), Signal(signed(CLOSURE_BITS))
        m.d.sync += [size.eq(Mux(error < 0, -error, error)), sized.eq(takes_error), sized_error.eq(error)]
        with m.If(self.clear):
            m.d.sync += [largest_size.eq(0), self.largest_closure_error.eq(0)]
        with m.Elif(sized & (size > largest_size)):
            m.d.sync += [largest_size.eq(size), self.largest_closure_error.eq(sized_error)]
        return m
