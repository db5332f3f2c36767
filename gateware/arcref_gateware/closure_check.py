"""The proof that no count was lost: every index must come at a whole number of turns from the first one."""

from amaranth.hdl import Cat, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS, COUNTS_PER_LINE
from arcref_gateware.register_stages import delayed, pipeline_clocks, pipelined_add
from arcref_gateware.running_largest import RunningLargest

CLOSURE_BITS = 24
"""Bits of a closure error."""

INDEX_ANGLE_CLOCKS = pipeline_clocks(ANGLE_BITS)
"""Clocks from a word's angle to the angle at its index."""

ERROR_BITS = COUNTS_PER_LINE.bit_length() + 1
"""Bits that hold a closure error, which is one grating line at most."""

CLOSURE_CLOCKS = INDEX_ANGLE_CLOCKS + 5
"""Clocks from a word's position to the state after it."""


def _near_whole_turn(m: Module, angle, *, name: str):
    """Whether a signed angle lies within one grating line of zero, two clocks later."""
    line_bits = COUNTS_PER_LINE.bit_length() - 1
    low, high = angle[:line_bits], angle[line_bits:]
    none, all_ones, only_lowest, low_zero, near = (
        Signal(name=f"{name}_{part}") for part in ("none", "all_ones", "only_lowest", "low_zero", "near")
    )
    m.d.sync += [
        none.eq(high == 0),
        all_ones.eq(high.all()),
        only_lowest.eq(high == 1),
        low_zero.eq(low == 0),
        near.eq(none | all_ones | (only_lowest & low_zero)),
    ]
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
    """1 starts the search for the largest closure error again, from the error whose `closure_fault` comes next."""
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
        # First the index's own angle; the word's angle waits for it.
        at_index = Signal(signed(ANGLE_BITS))
        m.d.comb += at_index.eq(pipelined_add(m, self.angle, self.index_way_back, name="at_index"))
        waited = Signal(signed(ANGLE_BITS))
        m.d.comb += waited.eq(delayed(m, self.angle, INDEX_ANGLE_CLOCKS, name="angle"))
        # Two clocks more: near a whole turn or not, zero or not.
        index_near = _near_whole_turn(m, at_index, name="index")
        word_near = _near_whole_turn(m, waited, name="word")
        word_below = delayed(m, waited[-1], 2, name="word_below")
        parts_off = Signal(2)
        index_off = Signal()
        half = ANGLE_BITS // 2
        m.d.sync += [parts_off.eq(Cat(at_index[:half].any(), at_index[half:].any())), index_off.eq(parts_off.any())]
        homed = delayed(m, self.homed, INDEX_ANGLE_CLOCKS + 2, name="homed")
        index = delayed(m, self.index, INDEX_ANGLE_CLOCKS + 2, name="index")
        home = delayed(m, self.home, INDEX_ANGLE_CLOCKS + 2, name="home")

        # Third clock from there: what happened in the word.
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

        # Fourth clock: the faults. A neighbourhood is left where it was entered, or its whole turn was passed.
        seen, came_from_below = Signal(), Signal()
        takes_error = Signal()
        m.d.sync += [
            seen.eq((seen & ~enters) | index_here),
            came_from_below.eq(Mux(enters, below, came_from_below)),
            takes_error.eq(checked_near),
            self.closure_fault.eq(error_here),
            self.index_fault.eq(unexpected | (leaves & (came_from_below ^ below) & ~seen & ~index_here)),
        ]
        # An error is near a whole turn: a few bits hold it.
        error = delayed(m, at_index[:ERROR_BITS].as_signed(), 4, name="error")

        # Fifth clock: the state after the word.
        with m.If(delayed(m, index, 2, name="index_counted")):
            m.d.sync += self.index_count.eq(self.index_count + 1)
        last_error, largest_error = Signal(signed(ERROR_BITS)), Signal(signed(ERROR_BITS))
        with m.If(takes_error):
            m.d.sync += last_error.eq(error)

        # The size of the error is made while the error waits, so that the largest is known a clock after the last.
        below = delayed(m, at_index[-1], 1, name="at_index_below")
        turned, size, checked_size = (Signal(ERROR_BITS - 1, name=name) for name in ("turned", "size", "checked_size"))
        m.d.sync += [
            turned.eq(at_index[: ERROR_BITS - 1] ^ at_index[-1].replicate(ERROR_BITS - 1)),
            size.eq(turned + below),
            checked_size.eq(size & (checked & index_near).replicate(ERROR_BITS - 1)),
        ]
        m.submodules.search = search = RunningLargest(ERROR_BITS - 1)
        taken, none = Signal(), Signal()
        m.d.sync += [taken.eq(search.takes), none.eq(search.none & ~search.takes)]
        m.d.comb += [
            search.number.eq(checked_size),
            search.valid.eq(checked_near),
            search.clear.eq(self.clear),
            self.closure_error.eq(last_error),
            self.largest_closure_error.eq(largest_error),
        ]
        with m.If(taken):
            m.d.sync += largest_error.eq(last_error)
        with m.Elif(none):
            m.d.sync += largest_error.eq(0)
        return m
