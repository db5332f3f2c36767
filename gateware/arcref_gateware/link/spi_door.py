"""The SPI port's door to the registers: one word a command frame."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import Status
from arcref_gateware.link.register_bus import RegisterBus, Request
from arcref_gateware.spi_registers import SpiRegisters


class SpiDoor(wiring.Component):
    """Carries a command of the SPI port over the bus: a write is checked first, and acts when it may.

    The two words of a wide register are written one after the other, the lower one first; it acts with the upper one.
    """

    registers: In(SpiRegisters())
    """Commands of the SPI port, and their answers."""
    bus: Out(RegisterBus())
    """The registers."""
    wants_bus: Out(1)
    """1 while a command is being carried out."""
    has_bus: In(1)
    """1 while the bus is given to this door; stays so until `wants_bus` falls."""

    def elaborate(self, platform):
        m = Module()
        registers, bus = self.registers, self.bus
        m.d.comb += [
            bus.address.eq(registers.address),
            bus.write_word.eq(registers.write_word),
            bus.is_last.eq(0),
            bus.following.eq(registers.write),
        ]
        # Plain data paths: a reset or an enable of so few registers would come late.
        waits, is_asked, checks = Signal(), Signal(), Signal()
        begins, ends, writes_next = Signal(), Signal(), Signal()
        m.d.comb += [
            begins.eq(waits & self.has_bus),
            ends.eq(is_asked & bus.done),
            writes_next.eq(ends & registers.write & checks & (bus.status == Status.DONE)),
            bus.request.eq(Mux(registers.write, Mux(checks, Request.CHECK, Request.WRITE), Request.READ)),
            self.wants_bus.eq(waits | is_asked),
        ]
        m.d.sync += [
            waits.eq((waits | registers.valid) & ~begins),
            is_asked.eq((is_asked | begins) & (~ends | writes_next)),
            checks.eq(waits | (checks & ~ends)),
            bus.valid.eq(begins | writes_next),
            registers.done.eq(ends & ~writes_next),
        ]
        with m.If(is_asked):
            m.d.sync += [registers.status.eq(bus.status), registers.read_word.eq(bus.read_word)]
        return m
