"""A model of the iCE40 block RAM, written from Lattice FPGA-TN-02002 and not from the gateware.

4096 bits in 256 rows of 16. A narrow port takes its words from a row by the address lines above the row's eight: a
word of 16 / 2^mode bits is made of every (2^mode)-th bit of the row, from the place that these lines say on. Narrow
data come out at fixed bits: with 2 bits to a word, 3 and 11. A word that is read in the clock in which its row is
written comes out inverted, as a stand-in for no telling what.
"""

from amaranth.hdl import Array, Elaboratable, Module, Mux, Signal
from amaranth.lib.memory import Memory

OUTPUTS = {0: range(16), 3: (3, 11)}
"""Data outputs in use, by `READ_MODE`."""


class Ice40RamModel(Elaboratable):
    """Takes the place of `Instance("SB_RAM40_4K", ...)` that writes whole rows, clocked by the sync domain."""

    def __init__(self, kind: str, **arguments):
        assert kind == "SB_RAM40_4K"
        self.parameters = {name[2:]: value for name, value in arguments.items() if name.startswith("p_")}
        self.ports = {name[2:]: value for name, value in arguments.items() if name[:2] in ("i_", "o_")}
        assert self.parameters["WRITE_MODE"] == 0
        assert self.ports["MASK"].value == 0
        assert all(len(self.ports[name]) == 11 for name in ("WADDR", "RADDR"))

    def elaborate(self, platform):
        m = Module()
        ports, outputs = self.ports, OUTPUTS[self.parameters["READ_MODE"]]
        m.submodules.rows = memory = Memory(shape=16, depth=256, init=[])
        write, read = memory.write_port(), memory.read_port()
        enable = Signal()
        place, spoilt = Signal(3), Signal()
        m.d.comb += [
            enable.eq(ports["WE"] & ports["WCLKE"]),
            write.en.eq(enable),
            write.addr.eq(ports["WADDR"][:8]),
            write.data.eq(ports["WDATA"]),
            read.addr.eq(ports["RADDR"][:8]),
            read.en.eq(ports["RE"] & ports["RCLKE"]),
        ]
        m.d.sync += [place.eq(ports["RADDR"][8:]), spoilt.eq(enable & (write.addr == read.addr))]
        row = Signal(16)
        m.d.comb += row.eq(Mux(spoilt, ~read.data, read.data))
        step = 16 // len(outputs)
        for i, output in enumerate(outputs):
            m.d.comb += ports["RDATA"][output].eq(Array(row[step * i : step * (i + 1)])[place] if step > 1 else row[i])
        m.d.comb += [ports["RDATA"][bit].eq(0) for bit in range(16) if bit not in outputs]
        return m
