"""The correction: what the ROM says must be taken off a position, for the end of each word and for an event in it.

`corrected = position - ((line[angle >> 11] + sub[(angle & 2047) >> 2] + 8) >> 4)`, as `arcref.CorrectionRom.correct`.

Both tables have one read port, yet an event needs a look-up of its own when it lies in another cell than the word's
end. A cell of the finer table is 4 counts and a word has 4 steps at most, so a word touches two neighbouring cells at
most: the one the word before ended in, whose correction is still held, and one other. One look-up a word serves both.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed, sum_and_carry
from arcref_gateware.table_memory import TABLE_CLOCKS, TableMemory

CELL_BITS = 2
"""Low bits of the angle that the tables do not see: a cell of the finer table is 4 counts."""

CELL_NUMBER_BITS = 21
"""Bits of a cell's number in the turn: 9 address the finer table, the 12 above them the line table."""

CORRECTION_BITS = 14
"""Bits of a correction in whole counts: (2 x 32767 + 8) >> 4 is 4096."""

CORRECTION_CLOCKS = 2 + TABLE_CLOCKS + 4
"""Clocks from `angle` to `word_complement`, `event_complement` and `active`."""


class Correction(wiring.Component):
    """Looks the corrections up, `CORRECTION_CLOCKS` clocks after the angle of a word.

    Parameters: the two tables, as 16-bit words. Until the word is homed its corrections are 0.
    While `check_enable` is high the tables serve the power-up check at `check_address`, and every correction is 0
    until the second word after it.
    """

    def __init__(self, line_words, subdivision_words):
        self.line_words, self.subdivision_words = line_words, subdivision_words
        super().__init__(
            {
                "angle": In(CELL_NUMBER_BITS + CELL_BITS),
                "homed": In(1),
                "event": In(1),
                "event_angle": In(CELL_NUMBER_BITS + CELL_BITS),
                "usable": In(1),
                "check_enable": In(1),
                "check_address": In(CELL_NUMBER_BITS),
                "write_line": In(1),
                "write_subdivision": In(1),
                "write_word": In(16),
                "line_word": Out(16),
                "subdivision_word": Out(16),
                "word_complement": Out(signed(CORRECTION_BITS)),
                "event_complement": Out(signed(CORRECTION_BITS)),
                "active": Out(1),
            }
        )

    angle: In
    """Angle after the word."""
    homed: In
    """1 when the word is homed, with `angle`."""
    event: In
    """1 when the word has an event, with `angle`."""
    event_angle: In
    """Angle at the event's sample, one clock after `angle`."""
    usable: In
    """1 when the power-up check found the tables good."""
    check_enable: In
    """1 while the power-up check reads the tables."""
    check_address: In
    """What is read or written then: 9 low bits for the subdivision table, the 12 above them for the line table."""
    write_line: In
    """1 to write `write_word` into the line table at `check_address`, while `check_enable` is 1."""
    write_subdivision: In
    """The same for the subdivision table."""
    write_word: In
    """The word to write, held for three clocks."""
    line_word: Out
    """Word of the line table, for the check: 2 + `TABLE_CLOCKS` clocks after `check_address`."""
    subdivision_word: Out
    """Word of the subdivision table, for the check, with `line_word`."""
    word_complement: Out
    """One's complement of the whole counts to take off the position after the word; 0 when it is not corrected."""
    event_complement: Out
    """The same for the position at the event."""
    active: Out
    """1 when the word is corrected. Corrected position = position + complement + `active`."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.line_table = line_table = TableMemory(self.line_words)
        m.submodules.subdivision_table = subdivision_table = TableMemory(self.subdivision_words)

        # First clock. Before homing, cell 0 is looked up again and again: the zero mark lies at its edge, so the
        # word that homes finds the correction of the cell it starts from already held.
        cell = Signal(CELL_NUMBER_BITS)
        word_homed = Signal()
        looked_up = Signal()
        last_cell_odd = Signal()
        last_looked_up = Signal()
        m.d.sync += [
            cell.eq(Mux(self.check_enable, self.check_address, Mux(self.homed, self.angle[CELL_BITS:], 0))),
            word_homed.eq(self.homed),
            looked_up.eq(~self.check_enable),
            last_cell_odd.eq(cell[0]),
            last_looked_up.eq(looked_up),
        ]
        # Neighbouring cells differ in their lowest bit.
        next_cell_odd = self.angle[CELL_BITS] & self.homed
        moves_on = (next_cell_odd ^ cell[0]) | ~looked_up
        moved_on = Signal()
        event_looked_up = Signal()
        m.d.sync += [
            moved_on.eq(moves_on),
            # One look-up a word: the event's, when the word's end needs none.
            event_looked_up.eq(self.event & ~self.check_enable & ~moves_on),
        ]
        event_cell = self.event_angle[CELL_BITS:]
        event_moved_on = event_cell[0] ^ last_cell_odd

        # Second clock: the address, in registers of its own, as the way to many block RAMs is long.
        address = Signal(CELL_NUMBER_BITS)
        m.d.sync += address.eq(Mux(event_looked_up, event_cell, cell))
        m.d.comb += [
            subdivision_table.address.eq(address[: len(subdivision_table.address)]),
            line_table.address.eq(address[len(subdivision_table.address) :]),
            line_table.write.eq(delayed(m, self.write_line, 2, name="write_line")),
            subdivision_table.write.eq(delayed(m, self.write_subdivision, 2, name="write_subdivision")),
            line_table.write_data.eq(self.write_word),
            subdivision_table.write_data.eq(self.write_word),
            self.line_word.eq(line_table.data),
            self.subdivision_word.eq(subdivision_table.data),
        ]

        # Then the sum of both tables, rounded to whole counts, in three clocks: sums of the low halves; the carry
        # into the high halves and the rounding of the low one; the carry from there.
        line, subdivision = line_table.data, subdivision_table.data
        low_sum = Signal(9)
        low_rounded = Signal(5)
        high_sum = Signal(signed(9))
        high_line, high_subdivision = (
            delayed(m, word[8:].as_signed(), 1, name=name)
            for word, name in ((line, "high_line"), (subdivision, "high_subdivision"))
        )
        rounded = Signal(signed(CORRECTION_BITS))
        m.d.sync += [
            low_sum.eq(sum_and_carry(m, line[:8], subdivision[:8])),
            low_rounded.eq(low_sum[4:8] + low_sum[3]),
            high_sum.eq((Cat(Const(1, 1), high_line).as_signed() + Cat(low_sum[8], high_subdivision).as_signed()) >> 1),
            rounded.eq(Cat(low_rounded[:4], high_sum + low_rounded[4])),
        ]
        wait = TABLE_CLOCKS + 4
        use_new = delayed(m, moved_on, wait, name="moved_on")
        event_use_new = delayed(m, event_moved_on, wait, name="event_moved_on")
        correct_now = delayed(m, word_homed & looked_up & last_looked_up & self.usable, wait, name="correct_now")

        held = Signal(signed(CORRECTION_BITS))
        word_value = Mux(use_new, rounded, held)
        event_value = Mux(event_use_new, rounded, held)
        everywhere = correct_now.replicate(CORRECTION_BITS)
        m.d.sync += [
            held.eq(word_value),
            self.word_complement.eq(~word_value & everywhere),
            self.event_complement.eq(~event_value & everywhere),
            self.active.eq(correct_now),
        ]
        return m
