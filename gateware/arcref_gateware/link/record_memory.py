"""Records in block RAM, written whole in one clock and read word by word.

Block RAMs can have a narrower port to read than to write. Each of eight keeps two bits of every word of a record, so
that nothing has to be chosen behind them: the word number is part of their address. Sources: Lattice FPGA-TN-02002,
"Memory Usage Guide for iCE40 Devices" (SB_RAM40_4K, whose narrow words are every eighth bit of a wide one), and
FPGA-TN-02204, "ECP5 and ECP5-5G Memory Usage Guide" (DP16KD). Elsewhere it is a plain wide memory and a choice.
"""

from amaranth.hdl import Cat, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.fpga_family import is_ecp5, is_ice40
from arcref_gateware.memory_attributes import NO_COLLISION
from arcref_gateware.register_stages import delayed
from arcref_gateware.table_memory import DP16KD_WORDS, block_ram

WORDS = 8
"""Words of a record."""

WORD_BITS = 16

RECORD_BITS = WORDS * WORD_BITS

READ_CLOCKS = 2
"""Clocks from `read_record` and `read_word` to `word`."""

RAMS = WORD_BITS // 2
"""Block RAMs side by side, with two bits of each word."""

ICE40_ROWS = 256
ECP5_ROWS = DP16KD_WORDS[18]


class RecordMemory(wiring.Component):
    """`depth` records, a power of two: 256 at the most in block RAM of an iCE40, 1024 in that of an ECP5."""

    def __init__(self, depth: int):
        self.depth = depth
        super().__init__(
            {
                "write": In(1),
                "write_record": In(exact_log2(depth)),
                "record": In(RECORD_BITS),
                "read_record": In(exact_log2(depth)),
                "read_word": In(exact_log2(WORDS)),
                "word": Out(WORD_BITS),
            }
        )

    write: In
    """1 to write `record`, in every clock if need be."""
    write_record: In
    """Number of the record to write."""
    record: In
    """What to write, word 0 in its lowest bits."""
    read_record: In
    """Number of the record to read; not one that is being written."""
    read_word: In
    """Number of its word to read."""
    word: Out
    """The word, `READ_CLOCKS` clocks later."""

    def elaborate(self, platform):
        m = Module()
        if is_ice40(platform) and self.depth <= ICE40_ROWS:
            self._place_ice40(m)
        elif is_ecp5(platform) and self.depth <= ECP5_ROWS:
            self._place_ecp5(m)
        else:
            self._place_plain(m)
        return m

    def _place_plain(self, m: Module) -> None:
        m.submodules.memory = memory = Memory(shape=RECORD_BITS, depth=self.depth, init=[], attrs=NO_COLLISION)
        read, write = memory.read_port(domain="comb"), memory.write_port()
        record = Signal(RECORD_BITS, reset_less=True)
        number = delayed(m, self.read_word, 1, name="number")
        m.d.comb += [
            read.addr.eq(self.read_record),
            write.en.eq(self.write),
            write.addr.eq(self.write_record),
            write.data.eq(self.record),
        ]
        m.d.sync += [record.eq(read.data), self.word.eq(record.word_select(number, WORD_BITS))]

    def _bits(self, ram: int):
        """The pairs of bits of the record that one block RAM keeps, in the order of the words."""
        return [self.record[WORD_BITS * word + 2 * ram :][:2] for word in range(WORDS)]

    def _place_ice40(self, m: Module) -> None:
        """With eight words to a row, bit `word` and bit 8 + `word` of the row come out, at outputs 3 and 11."""
        row = Cat(self.read_record, Const(0, 8 - len(self.read_record)))
        word = Signal(WORD_BITS)
        for ram in range(RAMS):
            pairs = self._bits(ram)
            data = Signal(16, name=f"data{ram}")
            m.submodules[f"bits{2 * ram}"] = Instance(
                "SB_RAM40_4K",
                p_WRITE_MODE=0,
                p_READ_MODE=3,
                i_WCLK=ClockSignal(),
                i_WCLKE=Const(1),
                i_WE=self.write,
                i_WADDR=Cat(self.write_record, Const(0, 11 - len(self.write_record))),
                i_WDATA=Cat(*(pair[0] for pair in pairs), *(pair[1] for pair in pairs)),
                i_MASK=Const(0, 16),
                i_RCLK=ClockSignal(),
                i_RCLKE=Const(1),
                i_RE=Const(1),
                i_RADDR=Cat(row, self.read_word),
                o_RDATA=data,
            )
            m.d.comb += word[2 * ram : 2 * ram + 2].eq(Cat(data[3], data[11]))
        m.d.sync += self.word.eq(word)

    def _place_ecp5(self, m: Module) -> None:
        """A row is two bytes of nine bits, each with four pairs of bits; the ninth is not used."""
        for ram in range(RAMS):
            pairs = self._bits(ram)
            row = Cat(*pairs[:4], Const(0, 1), *pairs[4:], Const(0, 1))
            instance, data = block_ram(
                self.write_record, 18, (), self.write, row, Cat(self.read_word, self.read_record), read_width=2
            )
            m.submodules[f"bits{2 * ram}"] = instance
            m.d.comb += self.word[2 * ram : 2 * ram + 2].eq(data)
