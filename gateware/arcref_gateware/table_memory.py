"""One table of the correction, in block RAM.

The ECP5 form follows Lattice FPGA-TN-02204, "ECP5 and ECP5-5G Memory Usage Guide": the block RAM's own output register
halves its clock-to-output time, and no synthesis infers it. Elsewhere the register behind the memory is a plain one.
"""

from amaranth.hdl import Cat, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.memory_attributes import NO_COLLISION

TABLE_CLOCKS = 2
"""Clocks from an address to its word: the memory's own register, and one behind its slow output."""

WORD_BITS = 16
"""Bits of a table's word."""

DP16KD_ADDRESS_BITS = 14
"""Address lines of an ECP5 block RAM. They count bits; the lowest ones are not used by wider words."""

DP16KD_WORDS = {18: 1024, 4: 4096}
"""Words of an ECP5 block RAM, by their width in bits."""

DP16KD_ROW_WORDS = 16
"""Words of 18 bits in one `INITVAL` parameter, 20 bits each; there are 64 of these."""


def is_ecp5(platform) -> bool:
    """Whether `platform` builds for an ECP5 (LFE5U, LFE5UM, LFE5UM5G)."""
    return str(getattr(platform, "device", "")).upper().startswith("LFE5U")


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
        if is_ecp5(platform) and len(self.words) <= max(DP16KD_WORDS.values()):
            self._place_block_rams(m)
        else:
            m.submodules.memory = memory = Memory(
                shape=WORD_BITS, depth=len(self.words), init=self.words, attrs=NO_COLLISION
            )
            port, write = memory.read_port(domain="comb"), memory.write_port()
            word = Signal(WORD_BITS, reset_less=True)
            m.d.comb += [
                port.addr.eq(self.address),
                write.en.eq(self.write),
                write.addr.eq(self.address),
                write.data.eq(self.write_data),
            ]
            m.d.sync += [word.eq(port.data), self.data.eq(word)]
        return m

    def _place_block_rams(self, m: Module) -> None:
        """Block RAMs side by side, each with as many bits of every word as fit: one for 1024 words, four for 4096."""
        width = next(width for width, words in DP16KD_WORDS.items() if len(self.words) <= words)
        for low in range(0, WORD_BITS, width):
            bits = min(width, WORD_BITS - low)
            part = [word >> low & (1 << bits) - 1 for word in self.words]
            ram, data = block_ram(self.address, width, part, self.write, self.write_data[low : low + bits])
            m.submodules[f"bits{low}"] = ram
            m.d.comb += self.data[low : low + bits].eq(data)


def block_ram(address, width: int, words, write, write_data) -> tuple[Instance, Signal]:
    """One ECP5 block RAM with its output register, one port for both ways, and its data output of `width` bits."""
    data = Signal(18)
    line = Cat(Const(0, DP16KD_ADDRESS_BITS - exact_log2(DP16KD_WORDS[width])), address)
    line = Cat(line, Const(0, DP16KD_ADDRESS_BITS - len(line)))
    ports = {f"i_ADA{bit}": line[bit] for bit in range(DP16KD_ADDRESS_BITS)}
    ports |= {f"i_ADB{bit}": Const(0) for bit in range(DP16KD_ADDRESS_BITS)}
    ports |= {f"o_DOA{bit}": data[bit] for bit in range(18)}
    for port, on in (("A", 1), ("B", 0)):
        written = Cat(write_data, Const(0, 18 - len(write_data))) if on else Const(0, 18)
        ports |= {f"i_DI{port}{bit}": written[bit] for bit in range(18)}
        ports |= {f"i_CS{port}{bit}": Const(0) for bit in range(3)}
        ports |= {f"i_WE{port}": write if on else Const(0), f"i_RST{port}": Const(0)}
        ports |= {f"i_CE{port}": Const(on), f"i_OCE{port}": Const(on)}
    ram = Instance(
        "DP16KD",
        p_DATA_WIDTH_A=width,
        p_DATA_WIDTH_B=width,
        p_REGMODE_A="OUTREG",
        p_REGMODE_B="NOREG",
        p_RESETMODE="SYNC",
        p_ASYNC_RESET_RELEASE="SYNC",
        p_CSDECODE_A="0b000",
        p_CSDECODE_B="0b000",
        p_WRITEMODE_A="NORMAL",
        p_WRITEMODE_B="NORMAL",
        p_GSR="DISABLED",
        **initial_values(width, words),
        i_CLKA=ClockSignal(),
        i_CLKB=Const(0),
        **ports,
    )
    return ram, data[:width]


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
