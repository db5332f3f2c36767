"""One table of the correction, in block RAM."""

from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

TABLE_CLOCKS = 2
"""Clocks from an address to its word: the memory's own register, and one behind its slow output."""


class TableMemory(wiring.Component):
    """A read-only table of 16-bit words, `TABLE_CLOCKS` clocks from address to word.

    `words` holds its contents, 0..65535 each; their number is a power of two.
    """

    def __init__(self, words):
        self.words = [int(word) & 0xFFFF for word in words]
        super().__init__({"address": In(exact_log2(len(self.words))), "data": Out(16)})

    address: In
    """Word to read."""
    data: Out
    """The word, `TABLE_CLOCKS` clocks after its address."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=16, depth=len(self.words), init=self.words)
        port = memory.read_port()
        m.d.comb += [port.en.eq(1), port.addr.eq(self.address)]
        m.d.sync += self.data.eq(port.data)
        return m
