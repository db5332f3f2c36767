"""From a packet in memory to bytes on the line: CRC behind it, COBS over it, a zero at its end."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.crc.catalog import CRC16_IBM_3740
from amaranth.lib.wiring import In, Out

from arcref_gateware.link.packet_memory import PART_BITS, SENT_PART


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
    """1 while nothing is being sent."""
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
        place = Signal(PART_BITS)  # next byte to send
        ahead = Signal(PART_BITS)  # byte looked at in search of the next zero
        run = Signal(8)
        at_end, is_zero = Signal(), Signal()
        crc_bytes = Signal(16)
        wait = Signal(2)
        m.d.comb += [
            self.read_address.eq(Cat(ahead, Const(SENT_PART, 2))),
            self.write_valid.eq(self.push_valid),
            self.write_address.eq(length),
            self.write_data.eq(self.push_data),
            crc.data.eq(self.push_data),
            crc.valid.eq(self.push_valid),
        ]
        m.d.sync += [at_end.eq(ahead == length), is_zero.eq(self.read_data == 0)]
        with m.FSM():
            with m.State("IDLE"):
                m.d.comb += self.idle.eq(1)
                m.d.sync += [place.eq(0), ahead.eq(0), wait.eq(0)]
                with m.If(self.push_valid):
                    m.d.sync += length.eq(length + 1)
                with m.If(self.finish):
                    m.d.sync += crc_bytes.eq(crc.crc)
                    m.next = "CRC_HIGH"
            with m.State("CRC_HIGH"):
                m.d.comb += [self.write_valid.eq(1), self.write_data.eq(crc_bytes[8:]), crc.start.eq(1)]
                m.d.sync += length.eq(length + 1)
                m.next = "PAUSE"
            with m.State("PAUSE"):
                # A received byte may be waiting for the memory.
                m.d.sync += wait.eq(wait + 1)
                with m.If(wait == 2):
                    m.next = "CRC_LOW"
            with m.State("CRC_LOW"):
                m.d.comb += [self.write_valid.eq(1), self.write_data.eq(crc_bytes[:8])]
                m.d.sync += [length.eq(length + 1), wait.eq(0), run.eq(1)]
                m.next = "SEARCH"
            with m.State("SEARCH"):
                # Four clocks a byte: address, memory, its register, comparison.
                m.d.sync += wait.eq(wait + 1)
                with m.If(wait == 3):
                    with m.If(at_end | is_zero):
                        m.d.sync += ahead.eq(place)
                        m.next = "CODE"
                    with m.Else():
                        m.d.sync += [ahead.eq(ahead + 1), run.eq(run + 1)]
            with m.State("CODE"):
                m.d.comb += [self.valid.eq(1), self.data.eq(run)]
                with m.If(self.ready):
                    m.d.sync += [run.eq(run - 1), wait.eq(0)]
                    m.next = "FETCH"
            with m.State("FETCH"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(wait == 3):
                    with m.If(run.any()):
                        m.next = "LITERAL"
                    with m.Elif(at_end):
                        m.next = "DELIMITER"
                    with m.Else():
                        # The zero that the code stands for is passed over.
                        m.d.sync += [place.eq(ahead + 1), ahead.eq(ahead + 1), run.eq(1)]
                        m.next = "SEARCH"
            with m.State("LITERAL"):
                m.d.comb += [self.valid.eq(1), self.data.eq(self.read_data)]
                with m.If(self.ready):
                    m.d.sync += [run.eq(run - 1), ahead.eq(ahead + 1), wait.eq(0)]
                    m.next = "FETCH"
            with m.State("DELIMITER"):
                m.d.comb += [self.valid.eq(1), self.data.eq(0)]
                with m.If(self.ready):
                    m.d.sync += length.eq(0)
                    m.next = "IDLE"
        return m
