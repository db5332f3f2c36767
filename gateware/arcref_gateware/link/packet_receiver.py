"""From bytes on the line to whole packets in memory: COBS undone, CRC checked."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.crc.catalog import CRC16_IBM_3740
from amaranth.lib.wiring import In, Out

from arcref.link.packet import MOST_BODY_BYTES
from arcref_gateware.link.packet_memory import PART_BITS

LEAST_BODY_BYTES = 4
"""Bytes of the shortest packet: kind, number and CRC."""


class PacketReceiver(wiring.Component):
    """Puts one packet after the other into the two received parts of `PacketMemory`, in turn.

    A packet is offered with `ready` until `taken`. One that is complete while the one before is still offered is
    refused, as broken ones are: its sender will ask again.
    """

    data: In(8)
    """A byte from the line, with `valid` and held for two clocks more."""
    valid: In(1)
    """1 for one clock with each byte; the next comes eight clocks later at the earliest."""
    bad: In(1)
    """1 for one clock when a byte was lost on the line."""
    write_valid: Out(1)
    """1 for one clock with a byte for the memory."""
    write_address: Out(PART_BITS + 1)
    """Its place, the part in the highest bit."""
    write_data: Out(8)
    """The byte."""
    ready: Out(1)
    """1 while a packet is offered."""
    part: Out(1)
    """The part it stands in."""
    length: Out(PART_BITS)
    """Its bytes, without the CRC."""
    taken: In(1)
    """1 for one clock: the packet is done with."""
    refused: Out(16)
    """Packets that were refused, modulo 65536."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.crc = crc = CRC16_IBM_3740().create()

        # First clock: whether it is zero. Second: what it means.
        valid, is_zero = Signal(), Signal()
        first, broken = Signal(init=1), Signal()
        left = Signal(8, init=1)  # bytes up to the next code, it included
        is_code, one_less = Signal(init=1), Signal(8)  # left == 1 and left - 1, known by the next byte
        put, put_data, ends = Signal(), Signal(8, reset_less=True), Signal()
        whole = Signal()  # no literal was missing when the delimiter came
        came = Signal()  # anything at all before the delimiter
        m.d.sync += [
            valid.eq(self.valid),
            is_zero.eq(self.data == 0),
            is_code.eq(left == 1),
            one_less.eq(left - 1),
            put_data.eq(Mux(is_code, 0, self.data)),
            # A code stands for the zero before it, unless it is the first.
            put.eq(valid & ~is_zero & ~(is_code & first)),
            ends.eq(valid & is_zero),
        ]
        with m.If(valid):
            m.d.sync += [first.eq(is_zero), left.eq(Mux(is_code, self.data, one_less))]
            with m.If(is_zero):
                m.d.sync += [whole.eq(is_code & ~first), came.eq(~first), left.eq(1)]

        # Third clock: the byte goes into the memory and the CRC.
        count = Signal(range(MOST_BODY_BYTES + 2))
        full = Signal()
        part = Signal()
        m.d.sync += full.eq(count >= MOST_BODY_BYTES)
        m.d.comb += [
            self.write_valid.eq(put & ~full & ~broken),
            self.write_data.eq(put_data),
            self.write_address.eq(Cat(count[:PART_BITS], part)),
            crc.data.eq(put_data),
            crc.valid.eq(put),
        ]
        over = Signal()
        # Plain data paths: a reset of so few registers would come late.
        m.d.sync += [
            broken.eq((broken | (put & full) | self.bad) & ~over),
            count.eq((count + (put & ~full)) & ~over.replicate(len(count))),
        ]

        # At the end of a packet: two clocks later its CRC is known, and two more later the verdict acts.
        judged, long_enough, crc_good = Signal(), Signal(), Signal()
        good, bad = Signal(), Signal()
        m.d.sync += [judged.eq(ends), long_enough.eq(count >= LEAST_BODY_BYTES), crc_good.eq(crc.match_detected)]
        fits = whole & ~broken & long_enough & crc_good & ~self.ready
        m.d.sync += [good.eq(judged & fits), bad.eq(judged & ~fits & (came | broken)), over.eq(judged)]
        m.d.comb += crc.start.eq(over)
        m.d.sync += [
            self.ready.eq(good | (self.ready & ~self.taken)),
            part.eq(part ^ good),
            self.refused.eq(self.refused + bad),
        ]
        with m.If(good):
            m.d.sync += [self.part.eq(part), self.length.eq(count - 2)]
        return m
