"""The sending half of the UART: 8 data bits, no parity, one stop bit, least significant bit first."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out


class UartTransmitter(wiring.Component):
    """Sends bytes without a pause between them. `divisor`: clocks in a bit."""

    data: In(8)
    """The byte to send, with `valid`."""
    valid: In(1)
    """1 while there is a byte; it is taken in the clock in which `ready` is 1 as well."""
    ready: Out(1, init=1)
    """1 when a byte can be taken."""
    tx: Out(1, init=1)
    """The line, high when idle."""

    def __init__(self, divisor: int):
        self.divisor = divisor
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        # Set anew while the line is idle, so they need no reset, which would stand before every bit's.
        clocks = Signal(range(self.divisor), reset_less=True)
        bit_ends = Signal(reset_less=True)  # a clock early, so that the counter's comparison is off the path
        # The bits that are left, a register each: the last one goes out as the only one is left.
        left = Signal(10)
        shift = Signal(9, init=~0)
        m.d.sync += [self.tx.eq(shift[0]), bit_ends.eq(clocks == 1), clocks.eq(clocks - 1)]
        with m.If(self.ready | bit_ends):
            m.d.sync += clocks.eq(self.divisor - 1)
        with m.If(self.ready):
            m.d.sync += bit_ends.eq(0)
            with m.If(self.valid):
                m.d.sync += [shift.eq(Cat(Const(0, 1), self.data)), left.eq(-1), self.ready.eq(0)]
        with m.Elif(bit_ends):
            m.d.sync += [shift.eq(Cat(shift[1:], Const(1, 1))), left.eq(left >> 1), self.ready.eq(~left[1])]
        return m
