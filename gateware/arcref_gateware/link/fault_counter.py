"""The small counter of a fault: its lowest bits, of which the register file makes the rest."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.link.register_layout import TALLY_BITS


class FaultCounter(wiring.Component):
    """Counts the words in which a fault's cause was there, modulo 2^`TALLY_BITS`."""

    cause: In(1)
    """1 with each word that has the fault."""
    count: Out(TALLY_BITS)
    """How many there were."""

    def elaborate(self, platform):
        m = Module()
        cause = Signal()
        m.d.sync += [cause.eq(self.cause), self.count.eq(self.count + cause)]
        return m
