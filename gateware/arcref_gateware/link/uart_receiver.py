"""The receiving half of the UART: 8 data bits, no parity, one stop bit, least significant bit first."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out


class UartReceiver(wiring.Component):
    """Bytes out of the line, each sampled in the middle of its bits. `divisor`: clocks in a bit, 8 or more."""

    rx: In(1, init=1)
    """The line, asynchronous; high when idle."""
    data: Out(8)
    """The byte, with `valid`."""
    valid: Out(1)
    """1 for one clock with each byte."""
    bad: Out(1)
    """1 for one clock with a byte whose stop bit was low: noise, a break, or another baud rate."""

    def __init__(self, divisor: int):
        self.divisor = divisor
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        line = Signal(init=1)
        m.submodules.synchroniser = FFSynchronizer(self.rx, line, init=1)
        clocks = Signal(range(self.divisor))
        at_middle = Signal(reset_less=True)  # a clock early, so that the counter's comparison is off the path
        bit = Signal(range(10))
        shift = Signal(8, reset_less=True)
        ends = Signal()  # in the middle of the stop bit
        m.d.sync += [at_middle.eq(clocks == 1), self.valid.eq(ends & line), self.bad.eq(ends & ~line)]
        m.d.comb += self.data.eq(shift)
        with m.FSM():
            with m.State("IDLE"):
                # Half a bit from the edge to the middle of the start bit.
                m.d.sync += [clocks.eq(self.divisor // 2 - 1), bit.eq(0), at_middle.eq(0)]
                with m.If(~line):
                    m.next = "BITS"
            with m.State("BITS"):
                m.d.sync += clocks.eq(clocks - 1)
                with m.If(at_middle):
                    m.d.sync += [clocks.eq(self.divisor - 1), bit.eq(bit + 1)]
                    with m.If(bit == 0), m.If(line):
                        m.next = "IDLE"  # a glitch, no start bit
                    with m.Elif(bit == 9):
                        m.d.comb += ends.eq(1)
                        m.next = "STOP"
                    with m.Else():
                        m.d.sync += shift.eq(Cat(shift[1:], line))
            with m.State("STOP"), m.If(line):
                m.next = "IDLE"
        return m
