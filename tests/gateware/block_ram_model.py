"""A model of the ECP5 block RAM, written from Lattice FPGA-TN-02204 and not from the gateware.

Read port only: the address is taken at a clock edge with clock enable and chip select, the data come out after it, and
with `REGMODE` "OUTREG" after one more edge with the output's clock enable. An address counts bits: its lowest lines are
without effect for wider words. A row of 18 bits is two bytes of 9; words of 4 bits use 8 of the 9.
"""

from amaranth.hdl import Cat, Elaboratable, Module, Signal
from amaranth.lib.memory import Memory

ROWS = 1024
LOWEST_ADDRESS_LINE = {4: 2, 18: 4}


def initial_rows(parameters: dict[str, int]) -> list[int]:
    """The 1024 rows of 18 bits that the parameters `INITVAL_00` .. `INITVAL_3F` set."""
    rows = []
    for group in range(64):
        value = parameters[f"INITVAL_{group:02X}"]
        assert 0 <= value < 1 << 320
        rows += [value >> 20 * row & 0x3FFFF for row in range(16)]
        assert all(not value >> 20 * row + 18 & 3 for row in range(16)), "bits 18 and 19 of a row do not exist"
    return rows


def word_at(rows: list[int], width: int, address: int) -> int:
    """The word that the block RAM reads at the 14 bits of `address`."""
    row = rows[address >> 4]
    if width == 18:
        return row
    byte = row >> 9 * (address >> 3 & 1)
    return byte >> 4 * (address >> 2 & 1) & 0xF


class BlockRamModel(Elaboratable):
    """Takes the place of `Instance("DP16KD", ...)`: the same arguments, port A only, clocked by the sync domain."""

    def __init__(self, kind: str, **arguments):
        assert kind == "DP16KD"
        self.parameters = {name[2:]: value for name, value in arguments.items() if name.startswith("p_")}
        self.ports = {name[2:]: value for name, value in arguments.items() if name[:2] in ("i_", "o_")}
        assert len(self.parameters) + len(self.ports) == len(arguments)

    def elaborate(self, platform):
        m = Module()
        ports, width = self.ports, self.parameters["DATA_WIDTH_A"]
        values = {name: getattr(value, "value", value) for name, value in self.parameters.items()}
        address = Cat(ports[f"ADA{bit}"] for bit in range(14))
        m.submodules.rows = memory = Memory(shape=18, depth=ROWS, init=initial_rows(values))
        read = memory.read_port()
        selected = Signal()
        low = Signal(4)
        m.d.comb += [
            selected.eq(ports["CEA"] & (Cat(ports[f"CSA{bit}"] for bit in range(3)) == int(values["CSDECODE_A"], 0))),
            read.addr.eq(address[4:]),
            read.en.eq(selected),
        ]
        with m.If(selected):
            m.d.sync += low.eq(address[:4])
        word = Signal(18)
        m.d.comb += word.eq(read.data)
        if width == 4:
            m.d.comb += word.eq((read.data >> (low[3] * 9)).bit_select(low[2] << 2, 4))
        data = word
        if values["REGMODE_A"] == "OUTREG":
            data = Signal(18)
            with m.If(ports["OCEA"]):
                m.d.sync += data.eq(word)
        for bit in range(18):
            m.d.comb += ports[f"DOA{bit}"].eq(data[bit])
        # Writing is not modelled: who loads tables reads them back through their CRC.
        assert getattr(ports["RSTA"], "value", None) == 0, "the output register is never reset"
        return m
