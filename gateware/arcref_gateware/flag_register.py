"""The flag byte: faults stay up until they are cleared by command, status bits follow the present state."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.flags import FAULT_FLAGS


class FlagRegister(wiring.Component):
    """The flags of `arcref.flags.Flag`, one clock after their causes.

    A fault that is raised in the very clock of its clearing stays up.
    """

    raised: In(8)
    """Bit n: the cause of flag n is there. For status flags this is the state itself."""
    clear: In(8)
    """Bit n: clear fault flag n, for one clock."""
    flags: Out(8)
    """The flag byte."""

    def elaborate(self, platform):
        m = Module()
        kept = Signal(8)
        m.d.comb += kept.eq(self.flags & ~self.clear & int(FAULT_FLAGS))
        m.d.sync += self.flags.eq(kept | (self.raised))
        return m
