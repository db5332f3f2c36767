"""A memory with a port to write and one to read, in block RAM, fast on every part.

On an ECP5 it is made of block RAMs with their own output registers, as `TableMemory` is and for the same reason.
Elsewhere it is a plain memory with registers behind it, which synthesis finds a block RAM for.
"""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.fpga_family import is_ecp5
from arcref_gateware.memory_attributes import NO_COLLISION, OUTPUT_REGISTER
from arcref_gateware.table_memory import DP16KD_WORDS, block_ram, width_for

READ_CLOCKS = 2
"""Clocks from an address to its word: the memory's own register, and one behind its slow output."""


class BufferMemory(wiring.Component):
    """`depth` words of `width` bits; `depth` is a power of two.

    `init` holds the first words at power-up, the rest are 0. A reset does not change the contents. A word that is
    written in the very clock in which its address is given is not to be used.
    """

    def __init__(self, width: int, depth: int, init=()):
        self.width, self.depth = width, depth
        words = [int(word) for word in init]
        self.words = words + [0] * (depth - len(words))
        if len(self.words) != depth or not all(0 <= word < 1 << width for word in self.words):
            raise ValueError(f"the initial words do not fit a memory of {depth} words of {width} bits")
        super().__init__(
            {
                "write": In(1),
                "write_address": In(exact_log2(depth)),
                "write_data": In(width),
                "read_address": In(exact_log2(depth)),
                "read_data": Out(width),
            }
        )

    write: In
    """1 to put `write_data` at `write_address`."""
    write_address: In
    """Word to write."""
    write_data: In
    """What to write."""
    read_address: In
    """Word to read."""
    read_data: Out
    """The word, `READ_CLOCKS` clocks after its address."""

    def elaborate(self, platform):
        m = Module()
        if is_ecp5(platform) and self.depth <= DP16KD_WORDS[4]:
            self._place_block_rams(m)
            return m
        m.submodules.memory = memory = Memory(shape=self.width, depth=self.depth, init=self.words, attrs=NO_COLLISION)
        read, write = memory.read_port(domain="comb"), memory.write_port()
        word = Signal(self.width, reset_less=True, attrs=OUTPUT_REGISTER)
        shown = Signal(self.width, reset_less=True)
        m.d.comb += [
            read.addr.eq(self.read_address),
            write.en.eq(self.write),
            write.addr.eq(self.write_address),
            write.data.eq(self.write_data),
            self.read_data.eq(shown),
        ]
        m.d.sync += [word.eq(read.data), shown.eq(word)]
        return m

    def _place_block_rams(self, m: Module) -> None:
        """Block RAMs side by side, each with as many bits of every word as fit."""
        width = width_for(self.depth)
        for low in range(0, self.width, width):
            bits = min(width, self.width - low)
            part = [word >> low & (1 << bits) - 1 for word in self.words]
            ram, data = block_ram(
                self.write_address, width, part, self.write, self.write_data[low : low + bits], self.read_address
            )
            m.submodules[f"bits{low}"] = ram
            m.d.comb += self.read_data[low : low + bits].eq(data)
