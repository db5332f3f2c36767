"""A wide value that waits for many clocks: registers, or block RAM where registers are the scarcer of the two."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from arcref_gateware.fpga_family import is_short_of_registers
from arcref_gateware.memory_attributes import NO_COLLISION, OUTPUT_REGISTER
from arcref_gateware.register_stages import delayed

LEAST_MEMORY_CLOCKS = 3
"""Shortest delay through a memory: it is written, read, and the word registered behind its slow output."""


class DelayLine(wiring.Component):
    """`delayed` is `value`, `clocks` later.

    For the first clocks after a reset it is 0 from registers, and what came before the reset from a memory: clearing
    that would take a reset of its own, as wide as the value.
    """

    def __init__(self, width: int, clocks: int):
        self.clocks = clocks
        super().__init__({"value": In(width), "delayed": Out(width)})

    value: In
    """What is to wait."""
    delayed: Out
    """`value`, `clocks` clocks ago."""

    def elaborate(self, platform):
        m = Module()
        if not is_short_of_registers(platform) or self.clocks < LEAST_MEMORY_CLOCKS:
            m.d.comb += self.delayed.eq(delayed(m, self.value, self.clocks, name="value"))
            return m
        ahead = self.clocks - LEAST_MEMORY_CLOCKS + 1
        address_bits = ahead.bit_length()
        attributes = {"ram_style": "block"} | NO_COLLISION
        memory = Memory(shape=len(self.value), depth=1 << address_bits, init=[], attrs=attributes)
        m.submodules.memory = memory
        write, read = memory.write_port(), memory.read_port(domain="comb")
        word = Signal(len(self.value), reset_less=True, attrs=OUTPUT_REGISTER)
        # The two go round together; what one writes the other reads `ahead` clocks later.
        write_address = Signal(address_bits, init=ahead, reset_less=True)
        read_address = Signal(address_bits, reset_less=True)
        shown = Signal(len(self.value), reset_less=True)
        m.d.comb += [
            write.en.eq(1),
            write.addr.eq(write_address),
            write.data.eq(self.value),
            read.addr.eq(read_address),
            self.delayed.eq(shown),
        ]
        m.d.sync += [
            write_address.eq(write_address + 1),
            read_address.eq(read_address + 1),
            word.eq(read.data),
            shown.eq(word),
        ]
        return m
