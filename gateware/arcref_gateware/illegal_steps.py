"""Counting illegal steps, and keeping the place of the first one."""

from amaranth.hdl import Cat, Const, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref_gateware.register_stages import delayed, sum_and_carry

ILLEGAL_COUNT_BITS = 16
"""Bits of the count; it stays at its largest value."""


class IllegalSteps(wiring.Component):
    """Number of samples in which A and B both changed, `CLOCKS` clocks later."""

    CLOCKS = 5

    def __init__(self, samples_per_word: int):
        super().__init__(
            {
                "illegal": In(samples_per_word),
                "position": In(signed(POSITION_BITS)),
                "time": In(POSITION_BITS),
                "count": Out(ILLEGAL_COUNT_BITS),
                "first_position": Out(signed(POSITION_BITS)),
                "first_time": Out(POSITION_BITS),
            }
        )

    illegal: In
    """Bit i: A and B both changed at sample i."""
    position: In
    """Raw position after the word, `CLOCKS` clocks after `illegal`."""
    time: In
    """Number of the word's first sample, with `position`."""
    count: Out
    """Illegal steps since reset; stays at 65535."""
    first_position: Out
    """`position` at the first illegal step. One clock after `count`."""
    first_time: Out
    """`time` at the first illegal step."""

    def elaborate(self, platform):
        m = Module()
        half = ILLEGAL_COUNT_BITS // 2
        in_word = Signal(range(len(self.illegal) + 1))
        m.d.sync += in_word.eq(sum(self.illegal[i] for i in range(len(self.illegal))))
        addend = Signal(half)
        # The sum runs over and over, in two halves a clock apart; that it ran over once is kept, and stops the count.
        low = Signal(half + 1)
        high = Signal(ILLEGAL_COUNT_BITS - half + 1)
        full = Signal()
        m.d.sync += [
            addend.eq(in_word),
            low.eq(sum_and_carry(m, low[:half], addend)),
            high.eq(sum_and_carry(m, high[:-1], Cat(low[-1], Const(0, len(high) - 2)))),
            full.eq(full | high[-1]),
        ]
        stopped = (full | high[-1]).replicate(ILLEGAL_COUNT_BITS)
        m.d.sync += self.count.eq(Cat(delayed(m, low[:half], 1, name="low"), high[:-1]) | stopped)
        # The first word with an illegal step, told with `count`. In reset the place is taken too, when it is 0: a reset
        # of its own would lengthen the way to the enable of so many registers.
        seen, first = Signal(), Signal()
        takes = Signal(init=1)
        first_position = Signal(POSITION_BITS, reset_less=True)
        first_time = Signal(POSITION_BITS, reset_less=True)
        m.d.sync += [
            seen.eq(seen | (in_word != 0)),
            first.eq((in_word != 0) & ~seen),
            takes.eq(delayed(m, first, self.CLOCKS - 3, name="first")),
        ]
        with m.If(takes):
            m.d.sync += [first_position.eq(self.position), first_time.eq(self.time)]
        m.d.comb += [self.first_position.eq(first_position), self.first_time.eq(first_time)]
        return m
