"""The compare output: a pulse each time the corrected position passes a line of a grid, every K counts.

The grid begins at the first passage of the corrected angle past `start` after it was switched on. From then on the line
below the position is known: a position that falls below it, or that is K or more above it, gives a pulse and moves the
line by K. A position that stays there gives its pulse at any time, so nothing is lost while the line is moved. One that
comes back within those `MOVE_CLOCKS` words, as a shaft at rest on a line does, gives one pulse or none for it.

Two differences in a row do all of it: position less line, and that less K; before the grid begins the line is 0 and
the second one takes `start` off. The line is kept as its complement, so that only sums are made.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_layout import TALLY_BITS
from arcref_gateware.register_stages import delayed, sum_and_carry

PERIOD_BITS = REGISTERS["compare_period"].width
GRID_BITS = PERIOD_BITS + 2
"""Bits of a position in which the line and the position are never more than a quarter of the range apart."""

LEAST_PERIOD = 64
"""Smallest K: more counts than the position moves while the line is moved."""

COMPARE_CLOCKS = 9
"""Clocks from a position to its pulse."""

MOVE_CLOCKS = 10
"""Most words after a passage in which the next one is not seen at once."""

SETTLE_CLOCKS = 16
"""Words before the output is on that must have gone through."""

MOVE_SETTLE_CLOCKS = 5
"""Clocks from the last half of a move to the first word that is compared with the new line."""

TAKES_PERIOD, ADDS_PERIOD, TAKES_START, TAKES_TURNS = range(4)

STEPS = ("start_low", "start_high", "turns_low", "turns_high", "down", "move_low", "move_high")

_HALF = 8
_LOW = 13
_HIGH = GRID_BITS - _LOW


class CompareOutput(wiring.Component):
    """Pulses of `width` word clocks; a passage during a pulse makes it longer. With `restart` a new grid begins."""

    position: In(signed(48))
    """Corrected position after a word, in counts."""
    homed: In(1)
    """1 when the word was homed; until then there is no pulse."""
    period: In(PERIOD_BITS)
    """K, in counts; below `LEAST_PERIOD` the output is off."""
    start: In(ANGLE_BITS)
    """Corrected angle that has a pulse."""
    restart: In(1)
    """1 for one clock as `period` or `start` has become another: the grid begins anew."""
    width: In(16)
    """Length of a pulse, in word clocks; 0 counts as 1."""
    pulse: Out(1)
    """The output, `COMPARE_CLOCKS` clocks after the position that passed a line."""
    count: Out(TALLY_BITS)
    """Pulses since reset: the lowest bits of their number."""

    def elaborate(self, platform):
        m = Module()
        # What is added to the complement of the line, and to the first difference: a complement of `start` or K, which
        # takes one more to take the number off, or K itself.
        choice = Signal(2)
        line_turns = Signal(3)
        addend = Signal(GRID_BITS, reset_less=True)
        with m.Switch(choice):
            with m.Case(TAKES_PERIOD):
                m.d.sync += addend.eq(~Cat(self.period, Const(0, GRID_BITS - PERIOD_BITS)))
            with m.Case(ADDS_PERIOD):
                m.d.sync += addend.eq(self.period)
            with m.Case(TAKES_START):
                m.d.sync += addend.eq(Cat(~self.start, Const(-1, GRID_BITS - ANGLE_BITS)))
            with m.Case(TAKES_TURNS):
                m.d.sync += addend.eq(Cat(Const(-1, ANGLE_BITS), ~line_turns))
        addend_low, addend_high = addend[:_LOW], addend[_LOW:]

        # Position less line, and that with the addend: a half a clock, the lower one first.
        line_low, line_high = Signal(_LOW, reset_less=True), Signal(_HIGH, reset_less=True)  # complements
        first_low, first_high = Signal(_LOW + 1, reset_less=True), Signal(_HIGH, reset_less=True)
        second_carry, second_high = Signal(reset_less=True), Signal(_HIGH, reset_less=True)
        second_low = Signal(_LOW, reset_less=True)  # never read: the carry is what counts
        position_high = delayed(m, self.position[_LOW:GRID_BITS], 1, name="position_high")
        m.d.sync += [
            first_low.eq(sum_and_carry(m, self.position[:_LOW], line_low, Const(1, 1))),
            first_high.eq(sum_and_carry(m, position_high, line_high, first_low[-1])),
            Cat(second_low, second_carry).eq(sum_and_carry(m, first_low[:_LOW], addend_low, Const(1, 1))),
            second_high.eq(sum_and_carry(m, first_high, addend_high, second_carry)),
        ]
        # Before the grid begins the second difference is that from the start, in turns and a part of one.
        sign, quarter = ANGLE_BITS - 1 - _LOW, ANGLE_BITS - 2 - _LOW
        is_beyond, is_below, crosses = Signal(), Signal(), Signal()
        before = Signal()
        turns = Signal(3)
        m.d.sync += [
            is_beyond.eq(~second_high[-1]),
            is_below.eq(delayed(m, first_high[-1], 1, name="first_sign")),
            before.eq(second_high[sign]),
            crosses.eq((second_high[sign] ^ before) & ~(second_high[sign] ^ second_high[quarter])),
            turns.eq(second_high[sign + 1 :] + second_high[sign]),
        ]

        is_long, enabled = Signal(), Signal()
        m.d.sync += [
            is_long.eq(self.period[LEAST_PERIOD.bit_length() - 1 :] != 0),
            enabled.eq(self.homed & is_long & ~self.restart),
        ]
        # States, each a register of its own: off until the pipeline holds nothing from before, waiting for the start,
        # the steps of a move, comparing.
        off, waits, compares = Signal(init=1), Signal(), Signal()
        start_low, start_high, turns_low, turns_high, down, move_low, move_high = (Signal(name=name) for name in STEPS)
        settling = Signal(MOVE_SETTLE_CLOCKS)
        settle, has_settled = Signal(range(SETTLE_CLOCKS), reset_less=True), Signal()
        passed, moved_up = Signal(), Signal()
        ends, may_start, may_pass = Signal(), Signal(), Signal()
        interrupted = Signal()  # in the middle of a move
        m.d.comb += [
            ends.eq(~enabled | interrupted),
            may_start.eq(waits & ~ends),
            may_pass.eq(compares & ~ends),
        ]
        m.d.sync += [
            settle.eq(Mux(off & enabled, settle + 1, 0)),
            has_settled.eq(settle.all()),
            interrupted.eq(ends & ~off & ~waits & ~compares),
            off.eq((off & ~has_settled) | ((waits | compares) & ends)),
            waits.eq((off & has_settled) | (may_start & ~crosses)),
            start_low.eq(may_start & crosses),
            start_high.eq(start_low),
            turns_low.eq(start_high),
            turns_high.eq(turns_low),
            down.eq(may_pass & is_below),
            move_low.eq((may_pass & is_beyond & ~is_below) | down | (turns_high & ~moved_up)),
            move_high.eq(move_low),
            settling.eq(Cat(move_high | (turns_high & moved_up), settling)),
            compares.eq(settling[-1] | (may_pass & ~is_beyond & ~is_below)),
            passed.eq((may_pass & (is_beyond | is_below)) | (may_start & crosses)),
        ]
        with m.If(waits):
            m.d.sync += [moved_up.eq(~before), line_turns.eq(turns)]
        with m.If(compares):
            m.d.sync += moved_up.eq(~is_below)
        # What they do comes a clock behind them. The line becomes the start, at the turn in which that was passed;
        # it goes K down when the position is below it.
        restarts, moves_low, moves_high = Signal(), Signal(), Signal()
        with_start, with_turns = off | waits | start_low, start_high | turns_low
        adds = down | ((turns_high | move_low) & ~moved_up)
        m.d.sync += [
            restarts.eq(off),
            moves_low.eq(start_low | turns_low | move_low),
            moves_high.eq(start_high | turns_high | move_high),
            choice.eq(Cat(adds | with_turns, with_start | with_turns)),
        ]
        # The complement of the line goes down when K is added to the line.
        takes_off, carry = Signal(), Signal()
        moved_low, moved_high = Signal(_LOW, reset_less=True), Signal(_HIGH, reset_less=True)
        writes_low, writes_high = (delayed(m, moves, 1, name="writes") for moves in (moves_low, moves_high))
        m.d.sync += [
            takes_off.eq(choice != ADDS_PERIOD),
            Cat(moved_low, carry).eq(sum_and_carry(m, line_low, addend_low, takes_off)),
            moved_high.eq(sum_and_carry(m, line_high, addend_high, carry)),
            line_low.eq(Mux(restarts, Const(-1, _LOW), Mux(writes_low, moved_low, line_low))),
            line_high.eq(Mux(restarts, Const(-1, _HIGH), Mux(writes_high, moved_high, line_high))),
        ]

        # A pulse lasts while a counter that begins with minus its length is below zero. Its upper half follows the
        # lower one, which makes that two clocks longer.
        left, upper_left, ended = Signal(_HALF), Signal(_HALF + 1), Signal(reset_less=True)
        runs = upper_left[-1]
        ran = Signal(2)
        passed_later = delayed(m, passed, 3, name="passed_later")
        m.d.sync += [
            Cat(left, ended).eq(Mux(passed, ~self.width[:_HALF], sum_and_carry(m, left, Const(0, _HALF), runs))),
            upper_left.eq(Mux(passed, Cat(~self.width[_HALF:], Const(1, 1)), upper_left + ended)),
            ran.eq(Cat(runs, ran)),
            self.pulse.eq((runs & ran.all()) | passed_later),
            self.count.eq(self.count + passed),
        ]
        return m
