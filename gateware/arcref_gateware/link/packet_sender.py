"""From a packet in memory to bytes on the line: CRC behind it, COBS over it, a zero at its end."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.crc.catalog import CRC16_IBM_3740
from amaranth.lib.wiring import In, Out

from arcref_gateware.link.packet_memory import PART_BITS, SENT_PART

STATES = ("idle", "crc_high", "crc_low", "searches", "sends_code", "sends", "ends")


class PacketSender(wiring.Component):
    """Takes the bytes of one packet and sends them once `finish` says that it is whole.

    While `idle` is 1 a packet may be put together: a byte at most every third clock.
    """

    push_valid: In(1)
    """1 for one clock with a byte of the packet."""
    push_data: In(8)
    """The byte."""
    finish: In(1)
    """1 for one clock, three clocks or more after the last byte: send it."""
    idle: Out(1)
    """1 while a packet may be put together; the last byte of the one before may still wait for the line."""
    write_valid: Out(1)
    """1 for one clock with a byte for the memory."""
    write_address: Out(PART_BITS)
    """Its place."""
    write_data: Out(8)
    """The byte."""
    read_address: Out(PART_BITS + 2)
    """Byte of the memory that is wanted, while not `idle`."""
    read_data: In(8)
    """The byte, two clocks later."""
    data: Out(8)
    """A byte for the line, with `valid`."""
    valid: Out(1)
    """1 while there is a byte; it is taken in the clock in which `ready` is 1 as well."""
    ready: In(1)
    """1 when the line takes a byte."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.crc = crc = CRC16_IBM_3740().create()
        length = Signal(PART_BITS)  # bytes written so far
        # Both are set anew while idle, so they need no reset.
        place = Signal(PART_BITS, reset_less=True)  # first byte behind the last code or zero
        ahead = Signal(PART_BITS)  # byte that is looked at: the next to send, or in search of the next zero
        run = Signal(
            PART_BITS + 1, reset_less=True
        )  # code of the bytes from `place` on, then how many of them are left
        m.d.comb += [self.read_address.eq(Cat(ahead, Const(SENT_PART, 2))), self.write_address.eq(length)]

        # States, a register each. They go on every eighth clock: `steps`. By then what they ask for is known.
        idle, crc_high, crc_low, searches, sends_code, sends, ends = (
            Signal(name=name, init=name == "idle") for name in STATES
        )
        phase, steps = Signal(3), Signal()
        at_end, is_zero, none_left = Signal(), Signal(), Signal()
        found, goes_on, loads = Signal(), Signal(), Signal()
        is_full = self.valid  # a byte waits for the line
        m.d.comb += [
            self.idle.eq(idle),
            found.eq(steps & searches & (at_end | is_zero)),
            goes_on.eq(steps & sends & none_left),  # the zero that the next code stands for is passed over
            loads.eq(steps & ~is_full & (sends_code | (sends & ~none_left) | ends)),
        ]
        m.d.sync += [
            phase.eq(phase + 1),
            steps.eq(phase == 6),
            at_end.eq(ahead == length),
            is_zero.eq(self.read_data == 0),
            none_left.eq(run == 0),
            idle.eq((idle & ~self.finish) | (ends & loads)),
            crc_high.eq((idle & self.finish) | (crc_high & ~steps)),
            crc_low.eq(Mux(steps, crc_high, crc_low)),
            searches.eq((searches & ~found) | (steps & crc_low) | (goes_on & ~at_end)),
            sends_code.eq(found | (sends_code & ~loads)),
            sends.eq((sends_code & loads) | (sends & ~goes_on)),
            ends.eq((goes_on & at_end) | (ends & ~loads)),
        ]

        # Bytes into the memory: those of the packet, then the CRC.
        pushed = Signal()
        m.d.sync += [
            pushed.eq(self.push_valid),
            self.write_valid.eq(self.push_valid | (steps & (crc_high | crc_low))),
            self.write_data.eq(Mux(idle, self.push_data, Mux(crc_high, crc.crc[8:], crc.crc[:8]))),
        ]
        m.d.comb += [crc.data.eq(self.write_data), crc.valid.eq(pushed), crc.start.eq(searches)]
        m.d.sync += length.eq((length + self.write_valid) & ~ends.replicate(PART_BITS))

        # Bytes out of it. The search counts, and goes back to where it began.
        back, on, begins, counts = Signal(), Signal(), Signal(), Signal()
        loaded, from_code, from_memory = Signal(), Signal(), Signal()
        m.d.sync += [
            back.eq(found),
            on.eq((steps & searches & ~found) | (loads & sends) | goes_on),
            begins.eq(goes_on),
            counts.eq(steps & searches & ~found),
            loaded.eq(loads),
            from_code.eq(sends_code),
            from_memory.eq(sends),
        ]
        m.d.sync += [
            ahead.eq(Mux(back, place, ahead + on) & ~idle.replicate(PART_BITS)),
            run.eq(Mux(begins, 1, Mux(counts, run + 1, Mux(loaded, run - 1, run)))),
        ]
        with m.If(begins):
            m.d.sync += place.eq(ahead + 1)
        with m.If(idle):
            m.d.sync += [place.eq(0), run.eq(1)]
        with m.If(loads):
            m.d.sync += self.data.eq((run & from_code.replicate(8)) | (self.read_data & from_memory.replicate(8)))
        m.d.sync += self.valid.eq(loads | (self.valid & ~self.ready))
        return m
