"""Sends captures over the UART as they come: one packet each, and one more where captures were lost."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref.link.capture_record import RECORD_BYTES
from arcref.link.packet import Kind
from arcref_gateware.correction import CORRECTION_BITS
from arcref_gateware.link.capture_fifo import COUNT_BITS

OVERRUN_BYTES = COUNT_BITS // 8
PUSH_CLOCKS = 4
"""Clocks from one byte of a packet to the next."""


class CaptureStreamer(wiring.Component):
    """Takes the oldest capture of the FIFO whenever the sender is free, while `enable` is 1."""

    enable: In(1)
    """1 to stream."""
    ready: In(1)
    """1 while the FIFO offers a capture."""
    taken: Out(1)
    """1 for one clock: it was sent."""
    time: In(POSITION_BITS)
    """Its time."""
    raw: In(signed(POSITION_BITS))
    """Its raw position."""
    correction: In(signed(CORRECTION_BITS))
    """Its corrected less its raw position."""
    flags: In(8)
    """Its flag byte."""
    after_loss: In(1)
    """1 when captures were lost before it."""
    lost: In(COUNT_BITS)
    """How many were lost so far, when `after_loss` is 1."""
    wants_sender: Out(1)
    """1 while there is something to send."""
    has_sender: In(1)
    """1 while the sender is idle and given to the streamer; stays so until `finish`."""
    push_valid: Out(1)
    """1 for one clock with a byte of a packet."""
    push_data: Out(8)
    """The byte."""
    finish: Out(1)
    """1 for one clock: the packet is whole."""

    def elaborate(self, platform):
        m = Module()
        record = Cat(self.time, self.raw, self.correction.as_signed(), self.correction[-1].replicate(2), self.flags)
        assert len(record) == 8 * RECORD_BYTES
        shift = Signal(8 * (RECORD_BYTES + 2), reset_less=True)
        left = Signal(range(RECORD_BYTES + 3))
        number = Signal(8)
        wait = Signal(range(PUSH_CLOCKS))
        loss_told = Signal()
        is_overrun = Signal()
        m.d.comb += [is_overrun.eq(self.after_loss & ~loss_told), self.push_data.eq(shift[:8])]
        m.d.sync += [self.taken.eq(0), self.finish.eq(0)]
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [wait.eq(0), left.eq(Mux(is_overrun, OVERRUN_BYTES, RECORD_BYTES) + 2)]
                m.d.sync += shift.eq(
                    Mux(
                        is_overrun,
                        Cat(Const(Kind.OVERRUN, 8), number, self.lost),
                        Cat(Const(Kind.CAPTURE, 8), number, record),
                    )
                )
                with m.If(self.enable & self.ready & ~self.taken & self.has_sender):
                    m.next = "PUSH"
            with m.State("PUSH"):
                m.d.sync += wait.eq(wait + 1)
                m.d.comb += self.push_valid.eq((wait == 0) & left.any())
                with m.If(wait == PUSH_CLOCKS - 1):
                    m.d.sync += [shift.eq(shift >> 8), left.eq(left - 1)]
                    with m.If(left == 0):
                        m.d.sync += [
                            self.finish.eq(1),
                            number.eq(number + 1),
                            self.taken.eq(~is_overrun),
                            loss_told.eq(is_overrun),
                        ]
                        m.next = "END"
            with m.State("END"):
                m.next = "IDLE"
        m.d.comb += self.wants_sender.eq(~states.ongoing("IDLE") | (self.enable & self.ready & ~self.taken))
        return m
