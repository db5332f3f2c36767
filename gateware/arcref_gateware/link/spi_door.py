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
        m.d.sync += [bus.valid.eq(0), registers.done.eq(0)]
        with m.FSM() as states:
            with m.State("IDLE"), m.If(registers.valid):
                m.next = "WAIT"
            with m.State("WAIT"), m.If(self.has_bus):
                m.d.sync += [bus.valid.eq(1), bus.request.eq(Mux(registers.write, Request.CHECK, Request.READ))]
                m.next = "ASKED"
            with m.State("ASKED"), m.If(bus.done):
                m.d.sync += [registers.status.eq(bus.status), registers.read_word.eq(bus.read_word)]
                with m.If(registers.write & (bus.status == Status.DONE) & (bus.request == Request.CHECK)):
                    m.d.sync += [bus.valid.eq(1), bus.request.eq(Request.WRITE)]
                with m.Else():
                    m.d.sync += registers.done.eq(1)
                    m.next = "IDLE"
        wants = Signal()
        m.d.comb += [wants.eq(~states.ongoing("IDLE")), self.wants_bus.eq(wants)]
        return m
