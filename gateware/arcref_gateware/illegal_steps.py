"""Counting illegal steps, and keeping the place of the first one."""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS

ILLEGAL_COUNT_BITS = 16
"""Bits of the count; it stays at its largest value."""


class IllegalSteps(wiring.Component):
    """Number of samples in which A and B both changed, `CLOCKS` clocks later."""

    CLOCKS = 3

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
        in_word = Signal(range(len(self.illegal) + 1))
        m.d.sync += in_word.eq(sum(self.illegal[i] for i in range(len(self.illegal))))
        # One bit more than the count says that it ran over, which stops it there.
        total = Signal(ILLEGAL_COUNT_BITS + 1)
        with m.If(~total[-1]):
            m.d.sync += total.eq(total[:-1] + in_word)
        m.d.sync += self.count.eq(Mux(total[-1], ~0, total[:-1]))
        kept = Signal()
        with m.If((self.count != 0) & ~kept):
            m.d.sync += [kept.eq(1), self.first_position.eq(self.position), self.first_time.eq(self.time)]
        return m
