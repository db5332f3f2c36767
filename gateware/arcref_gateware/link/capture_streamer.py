"""Sends captures over the UART as they come: one packet each, and one more where captures were lost."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.capture_record import RECORD_BYTES
from arcref.link.packet import Kind
from arcref_gateware.link.capture_fifo import COUNT_BITS, LOSS_BIT, CaptureOutlet
from arcref_gateware.link.record_memory import READ_CLOCKS, WORD_BITS

OVERRUN_BYTES = COUNT_BITS // 8
PUSH_CLOCKS = 8
"""Clocks from one byte of a packet to the next."""

LAST_BYTE = RECORD_BYTES - 1

KINDS_OF_BYTE = ("kind", "number", "lost", "low", "high")

assert PUSH_CLOCKS >= READ_CLOCKS + 5, "a byte must have come out of the memory before it is pushed"
assert LOSS_BIT == 8 * RECORD_BYTES, "the byte behind the record says whether captures were lost"


class CaptureStreamer(wiring.Component):
    """Takes the oldest capture of the FIFO whenever the sender is free, while `enable` is 1."""

    enable: In(1)
    """1 to stream."""
    oldest: Out(CaptureOutlet())
    """The oldest capture of a `CaptureFifo`."""
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
        oldest = self.oldest
        byte = Signal(range(RECORD_BYTES + 1), init=RECORD_BYTES)  # of the record; between records the one behind it
        number = Signal(8)
        wait = Signal(range(PUSH_CLOCKS))
        may_push, is_last = Signal(), Signal()
        loss_told, is_overrun, sends_overrun = Signal(), Signal(), Signal()
        starts = Signal()
        m.d.comb += [
            oldest.word_number.eq(byte[1:]),
            # Until it is told, the number of the lost ones comes before the record.
            is_overrun.eq(oldest.word[LOSS_BIT % WORD_BITS] & ~loss_told),
        ]
        # What the next byte is.
        is_kind, is_number, is_lost, is_low, is_high = (Signal(name=f"is_{n}") for n in KINDS_OF_BYTE)
        # The FSM's states, a clock later and on their own: what follows from them has little to think.
        in_content, in_end, ends = Signal(), Signal(), Signal()
        begins, follows = Signal(), Signal()
        m.d.sync += [
            starts.eq(self.enable & oldest.ready),
            begins.eq(starts & oldest.ready & self.has_sender & ~oldest.reading),
            may_push.eq(wait == PUSH_CLOCKS - 3),
            self.push_valid.eq(may_push & ~in_end),
            is_last.eq(byte == LAST_BYTE),
            ends.eq(in_end & (wait == 2)),
            self.finish.eq(ends),
            oldest.taken.eq(ends & ~sends_overrun),
            oldest.told.eq(ends & sends_overrun),
            follows.eq(self.push_valid & in_content),
            byte.eq(Mux(is_kind, Mux(sends_overrun, RECORD_BYTES - OVERRUN_BYTES, 0), byte + follows)),
            oldest.next_lost.eq(self.push_valid & in_content & sends_overrun),
            # Once there is another record, its loss is another one.
            loss_told.eq(oldest.ready & (loss_told | (ends & sends_overrun))),
        ]

        def chosen(selected, value):
            return value & selected.replicate(8)

        word = Signal(WORD_BITS, reset_less=True)  # once more, near where it is chosen
        m.d.sync += word.eq(oldest.word)
        m.d.sync += self.push_data.eq(
            chosen(is_kind, Kind.CAPTURE | (sends_overrun & (Kind.OVERRUN ^ Kind.CAPTURE)))
            | chosen(is_number, number)
            | chosen(is_lost, oldest.lost)
            | chosen(is_low, word[:8])
            | chosen(is_high, word[8:])
        )
        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [wait.eq(0), sends_overrun.eq(is_overrun)]
                with m.If(begins):
                    m.next = "KIND"
            with m.State("KIND"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(self.push_valid):
                    m.next = "NUMBER"
            with m.State("NUMBER"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(self.push_valid):
                    m.next = "CONTENT"
            with m.State("CONTENT"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(self.push_valid & is_last):
                    m.next = "END"
            with m.State("END"):
                # In these clocks the sender is given back, and `ready` becomes that of the next capture.
                m.d.sync += wait.eq(wait + 1)
                with m.If(may_push):
                    m.next = "IDLE"
        m.d.sync += [
            in_content.eq(states.ongoing("CONTENT")),
            in_end.eq(states.ongoing("END")),
            is_kind.eq(states.ongoing("KIND")),
            is_number.eq(states.ongoing("NUMBER")),
            is_lost.eq(in_content & sends_overrun),
            is_low.eq(in_content & ~sends_overrun & ~byte[0]),
            is_high.eq(in_content & ~sends_overrun & byte[0]),
            number.eq(number + ends),
        ]
        busy = Signal()  # 1 while the FSM is not idle
        m.d.sync += busy.eq((busy | begins) & ~(states.ongoing("END") & may_push))
        m.d.comb += [
            oldest.reading.eq(begins | busy),
            self.wants_sender.eq(oldest.reading | (starts & oldest.ready)),
        ]
        return m
