"""The largest number of a row of numbers, one each clock, with no more than one comparison in any clock.

A comparison and what it decides do not fit into one clock of a fast core. So every number is compared a clock ahead
with the largest so far and with the number just before it, and a clock later it is known which comparison counts.
"""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import sum_and_carry


class RunningLargest(wiring.Component):
    """Largest valid number since reset or `clear`; 0 when there was none.

    A number that comes together with `clear` is the first one that counts after it.
    """

    CLOCKS = 2
    """Clocks from `number` to `largest`, and from `clear` to 0."""

    def __init__(self, width: int):
        super().__init__(
            {
                "number": In(width),
                "valid": In(1),
                "clear": In(1),
                "takes": Out(1),
                "none": Out(1, init=1),
                "largest": Out(width),
            }
        )

    number: In
    """The next number; 0 when there is none."""
    valid: In
    """1 when there is one."""
    clear: In
    """1 forgets the numbers before."""
    takes: Out
    """1 in the clock before `largest` shows a new number, a clock after that number."""
    none: Out
    """1 from the clock after `clear` until a number is taken: in the next clock there is none."""
    largest: Out
    """Largest number."""

    def elaborate(self, platform):
        m = Module()
        width = len(self.number)
        # Kept turned over: a number exceeds another when adding it to the other, turned over, carries out.
        not_before, not_largest = Signal(width, reset_less=True), Signal(width, reset_less=True)
        exceeds_largest, exceeds_before = Signal(), Signal()
        arrived, took, first, empty = Signal(), Signal(), Signal(), Signal(init=1)
        forgotten = self.clear | (self.none & ~arrived)
        m.d.sync += [
            not_before.eq(~self.number),
            exceeds_largest.eq(sum_and_carry(m, self.number, not_largest)[-1]),
            exceeds_before.eq(sum_and_carry(m, self.number, not_before)[-1]),
            arrived.eq(self.valid),
            took.eq(self.takes),
            self.none.eq(forgotten),
            first.eq(forgotten & self.valid),
            empty.eq(self.none & ~arrived),
        ]
        m.d.comb += [
            # The 0 that stands for none exceeds nothing.
            self.takes.eq(first | Mux(took, exceeds_before, exceeds_largest)),
            self.largest.eq(~not_largest & ~empty.replicate(width)),
        ]
        with m.If(self.takes):
            m.d.sync += not_largest.eq(not_before)
        return m
