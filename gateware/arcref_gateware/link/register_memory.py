"""The register file's memory, and who may use it when.

Four phases follow one another, a clock each; reads take two clocks from place to word.

| phase | read that begins | what is written |
|-------|------------------|-----------------|
| 0     | counters         | a record        |
| 1     | counters         | a record        |
| 2     | counters         | a total         |
| 3     | bus              | a setting       |

So the bus never reads where a total or a record is just being written, and two words that the bus reads one behind the
other are as far apart as two words of a total are written: both of before, or both of after.
"""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.register import WORD_BITS
from arcref_gateware.buffer_memory import BufferMemory
from arcref_gateware.link.register_layout import PLACE_BITS

PHASES = 4

COUNTER_WRITE = 1
"""Phase in which a total is taken to be written."""

SETTING_WRITE = 1
"""Phase in which a setting is taken to be written."""

RECORD_WRITES = (2, 3)
"""Phases in which a word of a record is taken to be written."""

BUS_READ = 2
"""Phase in which the bus's place is taken."""

BUS_WORD = 1
"""Phase in which the word that the bus reads is there."""


class RegisterMemory(wiring.Component):
    """256 words; `words` are those of power-up."""

    def __init__(self, words: list[int]):
        self.words = words
        super().__init__(
            {
                "phase": Out(PHASES, init=1 << BUS_READ),
                "word": Out(WORD_BITS),
                "bus_place": In(PLACE_BITS),
                "counter_place": In(PLACE_BITS),
                "total_place": In(PLACE_BITS),
                "total": In(WORD_BITS),
                "setting_valid": In(1),
                "setting_place": In(PLACE_BITS),
                "setting": In(WORD_BITS),
                "record_valid": In(1),
                "record_place": In(PLACE_BITS),
                "record": In(WORD_BITS),
            }
        )

    phase: Out
    """Bit n: it is phase n."""
    word: Out
    """The word that was read: in phase `BUS_WORD` the bus's, else the counters'."""
    bus_place: In
    """Word that the bus wants."""
    counter_place: In
    """Word that the counters want."""
    total_place: In
    """Where `total` belongs."""
    total: In
    """A total, written in every `COUNTER_WRITE`."""
    setting_valid: In
    """1 to write `setting` in phase `SETTING_WRITE`."""
    setting_place: In
    """Where it belongs."""
    setting: In
    """What is written."""
    record_valid: In
    """1 to write `record` in phases `RECORD_WRITES`."""
    record_place: In
    """Where it belongs."""
    record: In
    """What is written."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = BufferMemory(WORD_BITS, len(self.words), self.words)
        phase = self.phase
        place = Signal(PLACE_BITS)
        m.d.sync += [phase.eq(phase.rotate_left(1)), place.eq(self.counter_place)]
        with m.If(phase[BUS_READ]):
            m.d.sync += place.eq(self.bus_place)
        m.d.comb += [memory.read_address.eq(place), self.word.eq(memory.read_data)]

        # Settings and records share a register before that of the memory.
        other_place, other, other_valid = Signal(PLACE_BITS), Signal(WORD_BITS), Signal()
        with m.If(phase[SETTING_WRITE]):
            m.d.sync += [other_place.eq(self.setting_place), other.eq(self.setting)]
        with m.Else():
            m.d.sync += [other_place.eq(self.record_place), other.eq(self.record)]
        may_record = phase[RECORD_WRITES[0]] | phase[RECORD_WRITES[1]]
        m.d.sync += other_valid.eq((self.setting_valid & phase[SETTING_WRITE]) | (self.record_valid & may_record))
        write_place, written, writes = Signal(PLACE_BITS), Signal(WORD_BITS), Signal()
        m.d.sync += [
            write_place.eq(other_place),
            written.eq(other),
            writes.eq(other_valid | phase[COUNTER_WRITE]),
        ]
        with m.If(phase[COUNTER_WRITE]):
            m.d.sync += [write_place.eq(self.total_place), written.eq(self.total)]
        m.d.comb += [memory.write.eq(writes), memory.write_address.eq(write_place), memory.write_data.eq(written)]
        return m
