"""A model of the ECP5 block RAM, written from Lattice FPGA-TN-02204 and not from the gateware.

Two ports of any two widths. A port takes its address at a clock edge with clock enable and chip select, and writes or
reads there; data come out after the edge, and with `REGMODE` "OUTREG" after one more edge with the output's clock
enable. An address counts bits: its lowest lines are without effect for wider words. A row of 18 bits is two bytes of 9;
words of 4 and 2 bits use 8 of the 9. A word that is read in the clock in which it is written comes out inverted, as a
stand-in for no telling what.
"""

from amaranth.hdl import Array, Cat, Const, Elaboratable, Module, Mux, Signal
from amaranth.lib.memory import Memory

ROWS = 1024
LOWEST_ADDRESS_LINE = {2: 1, 4: 2, 18: 4}


def initial_rows(parameters: dict[str, int]) -> list[int]:
    """The 1024 rows of 18 bits that the parameters `INITVAL_00` .. `INITVAL_3F` set."""
    rows = []
    for group in range(64):
        value = parameters[f"INITVAL_{group:02X}"]
        assert 0 <= value < 1 << 320
        rows += [value >> 20 * row & 0x3FFFF for row in range(16)]
        assert all(not value >> 20 * row + 18 & 3 for row in range(16)), "bits 18 and 19 of a row do not exist"
    return rows


def bits_of_row(width: int, place: int) -> range:
    """Bits of a row that a word of `width` bits takes; `place` is what the four lowest address lines say."""
    if width == 18:
        return range(18)
    low = 9 * (place >> 3) + (place & 7 & -width)
    return range(low, low + width)


def word_at(rows: list[int], width: int, address: int) -> int:
    """The word that the block RAM reads at the 14 bits of `address`."""
    bits = bits_of_row(width, address & 15)
    return rows[address >> 4] >> bits.start & (1 << width) - 1


class BlockRamModel(Elaboratable):
    """Takes the place of `Instance("DP16KD", ...)`: the same arguments, clocked by the sync domain."""

    def __init__(self, kind: str, **arguments):
        assert kind == "DP16KD"
        self.parameters = {name[2:]: value for name, value in arguments.items() if name.startswith("p_")}
        self.ports = {name[2:]: value for name, value in arguments.items() if name[:2] in ("i_", "o_")}
        assert len(self.parameters) + len(self.ports) == len(arguments)

    def elaborate(self, platform):
        m = Module()
        values = {name: getattr(value, "value", value) for name, value in self.parameters.items()}
        m.submodules.rows = memory = Memory(shape=18, depth=ROWS, init=initial_rows(values))
        writes = [self._write(m, memory, port, values) for port in "AB" if self._is_used(port)]
        for port in "AB":
            if f"DO{port}0" in self.ports:
                self._read(m, memory, port, values, writes)
        return m

    def _is_used(self, port: str) -> bool:
        return not isinstance(self.ports[f"WE{port}"], Const)

    def _line(self, port: str, values):
        ports = self.ports
        address = Cat(ports[f"AD{port}{bit}"] for bit in range(14))
        chip = Cat(ports[f"CS{port}{bit}"] for bit in range(3)) == int(values[f"CSDECODE_{port}"], 0)
        assert not isinstance(ports[f"CLK{port}"], Const), "the port has no clock"
        assert getattr(ports[f"RST{port}"], "value", None) == 0, "the output register is never reset"
        return address, ports[f"CE{port}"] & chip

    def _write(self, m: Module, memory, port: str, values):
        """Returns the port's (row that is written or not, which of its bits)."""
        width = values[f"DATA_WIDTH_{port}"]
        address, selected = self._line(port, values)
        write = memory.write_port(granularity=1)
        data = Cat(self.ports[f"DI{port}{bit}"] for bit in range(18))
        masks, words = [], []
        for place in range(16):
            bits = bits_of_row(width, place)
            masks.append(Const(sum(1 << bit for bit in bits), 18))
            words.append((data[:width] << bits.start)[:18])
        enable = Signal(18)
        m.d.comb += [
            write.addr.eq(address[4:]),
            write.data.eq(Array(words)[address[:4]]),
            enable.eq(Mux(self.ports[f"WE{port}"] & selected, Array(masks)[address[:4]], 0)),
            write.en.eq(enable),
        ]
        return address[4:], enable

    def _read(self, m: Module, memory, port: str, values, writes) -> None:
        ports, width = self.ports, values[f"DATA_WIDTH_{port}"]
        address, selected = self._line(port, values)
        read = memory.read_port()
        m.d.comb += [read.addr.eq(address[4:]), read.en.eq(selected)]
        low, spoilt = Signal(4), Signal(18)
        with m.If(selected):
            m.d.sync += low.eq(address[:4])
            for row, enable in writes:
                m.d.sync += spoilt.eq(Mux(row == address[4:], enable, 0))
        word = Signal(18)
        row = read.data ^ spoilt
        m.d.comb += word.eq(Array(row[bits_of_row(width, place).start :][:width] for place in range(16))[low])
        data = word
        if values[f"REGMODE_{port}"] == "OUTREG":
            data = Signal(18)
            with m.If(ports[f"OCE{port}"]):
                m.d.sync += data.eq(word)
        for bit in range(18):
            m.d.comb += ports[f"DO{port}{bit}"].eq(data[bit])
