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
    ready: Out(1)
    """1 when a byte can be taken."""
    tx: Out(1, init=1)
    """The line, high when idle."""

    def __init__(self, divisor: int):
        self.divisor = divisor
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        clocks = Signal(range(self.divisor))
        bit_ends = Signal()  # a clock early, so that the counter's comparison is off the path
        bits_left = Signal(range(11))
        shift = Signal(9, init=~0)
        m.d.comb += self.ready.eq(bits_left == 0)
        m.d.sync += [clocks.eq(clocks - 1), bit_ends.eq(clocks == 1), self.tx.eq(shift[0])]
        with m.If(self.ready):
            m.d.sync += [clocks.eq(self.divisor - 1), bit_ends.eq(0)]
            with m.If(self.valid):
                m.d.sync += [shift.eq(Cat(Const(0, 1), self.data)), bits_left.eq(10)]
        with m.Elif(bit_ends):
            m.d.sync += [
                clocks.eq(self.divisor - 1),
                shift.eq(Cat(shift[1:], Const(1, 1))),
                bits_left.eq(bits_left - 1),
            ]
        return m
