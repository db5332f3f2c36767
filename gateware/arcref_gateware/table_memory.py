"""One table of the correction, in block RAM.

The ECP5 form follows Lattice FPGA-TN-02204, "ECP5 and ECP5-5G Memory Usage Guide": the block RAM's own output register
halves its clock-to-output time, and no synthesis infers it. Elsewhere the register behind the memory is a plain one.
"""

from amaranth.hdl import Cat, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.fpga_family import is_ecp5
from arcref_gateware.memory_attributes import NO_COLLISION, OUTPUT_REGISTER

TABLE_CLOCKS = 3
"""Clocks from an address to its word: the memory's own register, one behind its slow output, and one more, as the way
from many block RAMs to the sums is long."""

WORD_BITS = 16
"""Bits of a table's word."""

DP16KD_ADDRESS_BITS = 14
"""Address lines of an ECP5 block RAM. They count bits; the lowest ones are not used by wider words."""

DP16KD_WORDS = {18: 1024, 4: 4096, 2: 8192}
"""Words of an ECP5 block RAM, by their width in bits."""

DP16KD_ROW_WORDS = 16
"""Words of 18 bits in one `INITVAL` parameter, 20 bits each; there are 64 of these."""


def width_for(depth: int) -> int:
    """Bits of each of `depth` words, 4096 at the most, that one block RAM takes."""
    return next(width for width, words in DP16KD_WORDS.items() if depth <= words)


class TableMemory(wiring.Component):
    """A table of 16-bit words, `TABLE_CLOCKS` clocks from address to word.

    `words` holds its contents, 0..65535 each; their number is a power of two.
    """

    def __init__(self, words):
        self.words = [int(word) & 0xFFFF for word in words]
        super().__init__(
            {
                "address": In(exact_log2(len(self.words))),
                "data": Out(WORD_BITS),
                "write": In(1),
                "write_data": In(WORD_BITS),
            }
        )

    address: In
    """Word to read."""
    data: Out
    """The word, `TABLE_CLOCKS` clocks after its address."""
    write: In
    """1 to put `write_data` at `address`; what is read in that clock is not to be used."""
    write_data: In
    """The word to write."""

    def elaborate(self, platform):
        m = Module()
        shown = Signal(WORD_BITS, reset_less=True)
        m.d.comb += self.data.eq(shown)
        if is_ecp5(platform) and len(self.words) <= DP16KD_WORDS[4]:
            self._place_block_rams(m, shown)
        else:
            m.submodules.memory = memory = Memory(
                shape=WORD_BITS, depth=len(self.words), init=self.words, attrs=NO_COLLISION
            )
            port, write = memory.read_port(domain="comb"), memory.write_port()
            word = Signal(WORD_BITS, reset_less=True, attrs=OUTPUT_REGISTER)
            chosen = Signal(WORD_BITS, reset_less=True)
            m.d.comb += [
                port.addr.eq(self.address),
                write.en.eq(self.write),
                write.addr.eq(self.address),
                write.data.eq(self.write_data),
            ]
            m.d.sync += [word.eq(port.data), chosen.eq(word), shown.eq(chosen)]
        return m

    def _place_block_rams(self, m: Module, shown: Signal) -> None:
        """Block RAMs side by side, each with as many bits of every word as fit: one for 1024 words, four for 4096."""
        width = width_for(len(self.words))
        for low in range(0, WORD_BITS, width):
            bits = min(width, WORD_BITS - low)
            part = [word >> low & (1 << bits) - 1 for word in self.words]
            ram, data = block_ram(self.address, width, part, self.write, self.write_data[low : low + bits])
            m.submodules[f"bits{low}"] = ram
            m.d.sync += shown[low : low + bits].eq(data)


def block_ram(address, width: int, words, write, write_data, read_address=None, read_width=None):
    """One ECP5 block RAM with its output register: the `Instance`, and its data output of `read_width` bits.

    Port A writes, `width` bits at `address`. It reads there as well, or with `read_address` port B reads, from words of
    `read_width` bits, `width` if left out.
    """
    data = Signal(18)
    read_width = read_width or width
    reader = "A" if read_address is None else "B"
    lines = {"A": _address_lines(address, width)}
    lines["B"] = Const(0, DP16KD_ADDRESS_BITS) if reader == "A" else _address_lines(read_address, read_width)
    written = {"A": Cat(write_data, Const(0, 18 - len(write_data))), "B": Const(0, 18)}
    ports = {f"o_DO{reader}{bit}": data[bit] for bit in range(18)}
    for port in "AB":
        on = int(port in ("A", reader))
        ports |= {f"i_AD{port}{bit}": lines[port][bit] for bit in range(DP16KD_ADDRESS_BITS)}
        ports |= {f"i_DI{port}{bit}": written[port][bit] for bit in range(18)}
        ports |= {f"i_CS{port}{bit}": Const(0) for bit in range(3)}
        ports |= {f"i_WE{port}": write if port == "A" else Const(0), f"i_RST{port}": Const(0)}
        ports |= {f"i_CE{port}": Const(on), f"i_OCE{port}": Const(on)}
        ports |= {f"i_CLK{port}": ClockSignal() if on else Const(0)}
        ports |= {f"p_REGMODE_{port}": "OUTREG" if port == reader else "NOREG"}
    ram = Instance(
        "DP16KD",
        p_DATA_WIDTH_A=width,
        p_DATA_WIDTH_B=read_width,
        p_RESETMODE="SYNC",
        p_ASYNC_RESET_RELEASE="SYNC",
        p_CSDECODE_A="0b000",
        p_CSDECODE_B="0b000",
        p_WRITEMODE_A="NORMAL",
        p_WRITEMODE_B="NORMAL",
        p_GSR="DISABLED",
        **initial_values(width, words),
        **ports,
    )
    return ram, data[:read_width]


def _address_lines(address, width: int):
    """All address lines of a port of `width` bits: those below its words are not used."""
    lines = Cat(Const(0, DP16KD_ADDRESS_BITS - exact_log2(DP16KD_WORDS[width])), address)
    return Cat(lines, Const(0, DP16KD_ADDRESS_BITS - len(lines)))


def initial_values(width: int, words) -> dict[str, Const]:
    """`INITVAL` parameters of a block RAM that holds `words`.

    Each stands for 16 rows of two 9-bit bytes, 20 bits a row. A word of 18 bits is a row; of 4-bit words, two lie in
    a byte, whose ninth bit stays unused.
    """
    rows = [0] * (64 * DP16KD_ROW_WORDS)
    for place, word in enumerate(words):
        if width == 18:
            rows[place] = word
        else:
            row, nibble = divmod(place, 4)
            rows[row] |= word << 9 * (nibble // 2) + 4 * (nibble % 2)
    values = {}
    for group in range(64):
        value = sum(rows[group * DP16KD_ROW_WORDS + row] << 20 * row for row in range(DP16KD_ROW_WORDS))
        values[f"p_INITVAL_{group:02X}"] = Const(value, 20 * DP16KD_ROW_WORDS)
    return values
