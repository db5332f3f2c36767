"""The bytes of packets, received and to be sent, in one block RAM.

Two received packets have a half each, so that one can come while the other is obeyed; the third part is the packet to
be sent. A part is 64 bytes, more than the longest packet.
"""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import MOST_BODY_BYTES
from arcref_gateware.buffer_memory import READ_CLOCKS, BufferMemory

PART_BITS = 6
"""Address bits of a part."""

SENT_PART = 2
"""Number of the part that is sent; 0 and 1 are received."""

assert MOST_BODY_BYTES <= 1 << PART_BITS
assert READ_CLOCKS == 2, "who reads counts on it"


class PacketMemory(wiring.Component):
    """One memory of 256 bytes. Both writers come rarely; a received byte waits while one to be sent is written."""

    receive_valid: In(1)
    """1 for one clock with a received byte. The next may come four clocks later."""
    receive_address: In(PART_BITS + 1)
    """Its place: part 0 or 1 in the highest bit."""
    receive_data: In(8)
    """The byte."""
    send_valid: In(1)
    """1 for one clock with a byte to be sent; not in more than two clocks of three."""
    send_address: In(PART_BITS)
    """Its place in the part that is sent."""
    send_data: In(8)
    """The byte."""
    read_address: In(PART_BITS + 2)
    """Byte to read: part in the two highest bits."""
    read_data: Out(8)
    """The byte, `READ_CLOCKS` clocks later."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = BufferMemory(8, 1 << PART_BITS + 2)
        waits = Signal()
        # Transient: what stands in them without a write does no harm.
        address, data = Signal(PART_BITS + 1, reset_less=True), Signal(8, reset_less=True)
        write_address, write_data = Signal(PART_BITS + 2, reset_less=True), Signal(8, reset_less=True)
        write_enable = Signal()
        m.d.comb += [
            memory.read_address.eq(self.read_address),
            self.read_data.eq(memory.read_data),
            memory.write_address.eq(write_address),
            memory.write_data.eq(write_data),
            memory.write.eq(write_enable),
        ]
        m.d.sync += write_enable.eq(self.send_valid | waits)
        with m.If(self.send_valid):
            m.d.sync += [write_address.eq(self.send_address | SENT_PART << PART_BITS), write_data.eq(self.send_data)]
        with m.Else():
            m.d.sync += [write_address.eq(address), write_data.eq(data), waits.eq(0)]
        with m.If(self.receive_valid):
            m.d.sync += [address.eq(self.receive_address), data.eq(self.receive_data), waits.eq(1)]
        return m
