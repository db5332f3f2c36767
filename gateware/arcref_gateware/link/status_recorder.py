"""Records of one instant for the register file's memory: the snapshot that was asked for, and the first of each fault.

What is recorded is taken from the core's outputs in one clock, into words that then go round, one a clock. The memory
takes two neighbours of every four, so twice round brings it all ten: 0 1, 4 5, 8 9, 2 3, 6 7. That is a record, and
the words are back where they began, for the next fault of the same instant. A fault that comes while records are
written, twenty clocks each, is entered with the instant after them.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref.link.register import WORD_BITS
from arcref.link.registers import FAULT_LOG_ADDRESS, FAULT_LOG_STRIDE, REGISTERS
from arcref_gateware.link.register_layout import PLACE_BITS, fault_flags

FAULT_WORDS = 2 * POSITION_BITS // WORD_BITS
SNAPSHOT_WORDS = 3 * POSITION_BITS // WORD_BITS + 1

RECORD_CLOCKS = 2 * SNAPSHOT_WORDS
"""Clocks that a record takes."""

# In ten clocks the phases are two on, in twenty all words have met a phase in which they are taken.
assert SNAPSHOT_WORDS == 10
# The words of a snapshot count from 1, like the words on their way round.
_SNAPSHOT_PLACE = REGISTERS["snapshot_raw"].address - 1
assert _SNAPSHOT_PLACE % 16 == 0
assert FAULT_LOG_STRIDE == 8
assert FAULT_LOG_ADDRESS % 64 == 0


class StatusRecorder(wiring.Component):
    """Gives the words of records, each with its place."""

    raw_position: In(signed(POSITION_BITS))
    """Raw position after a word."""
    position: In(signed(POSITION_BITS))
    """Corrected position after that word."""
    time: In(POSITION_BITS)
    """Its last sample, in sample periods since reset."""
    flags: In(8)
    """The flag byte after that word."""
    homed: In(1)
    """1 when that word was homed."""
    snapshot: In(1)
    """1 for one clock: take a snapshot."""
    snapshot_done: Out(1)
    """1 for one clock once its words were given."""
    snapshot_number: Out(1)
    """Changes with every snapshot."""
    record_valid: Out(1)
    """1 while the words below belong to a record; two neighbours of every four clocks are to be written."""
    record_place: Out(PLACE_BITS)
    """Where `record` belongs."""
    record: Out(WORD_BITS)
    """A word of the record."""

    def elaborate(self, platform):
        m = Module()
        faults = fault_flags()
        up = Cat(self.flags[flag.bit_length() - 1] for flag in faults)
        # `follows`: the words below are those of the present instant. It decides over them all, so little stands before
        # it: `blind` keeps faults from it in the clock behind the last record. They are entered all the same, later.
        follows, ends = Signal(init=1), Signal()
        last_up, blind = Signal(len(faults)), Signal(len(faults))
        wanted, waits = Signal(len(faults) + 1), Signal()  # faults and a snapshot that are to be recorded
        was_following, begins = Signal(init=1), Signal()
        m.d.comb += begins.eq(was_following & ~follows)
        m.d.sync += [
            last_up.eq(up),
            blind.eq(up | (~follows).replicate(len(faults))),
            follows.eq(~((up & ~blind).any() | Mux(follows, waits, ~ends))),
            was_following.eq(follows),
            wanted.eq(Cat(up & ~last_up, self.snapshot) | (wanted & ~begins.replicate(len(wanted)))),
            waits.eq(wanted.any()),
        ]

        # The instant, the lowest word first, and which of its words is in front: 1 to 10.
        instant = Cat(self.raw_position, self.time, self.position, self.flags, self.homed)
        words = Signal(SNAPSHOT_WORDS * WORD_BITS, reset_less=True)
        word = Signal(range(SNAPSHOT_WORDS + 1), init=1)
        restarts = follows | (word == SNAPSHOT_WORDS)
        m.d.sync += [
            words.eq(Mux(follows, instant, words.rotate_right(WORD_BITS))),
            word.eq(((word + 1) & ~restarts.replicate(len(word))) | restarts),
        ]

        # Record after record. One is chosen two clocks behind the instant and after every second time round.
        group, more = Signal(len(faults) + 1), Signal()  # what of this instant is still to be recorded
        is_record, is_snapshot, fault = Signal(), Signal(), Signal(range(len(faults)))
        second, chooses, begun = Signal(), Signal(), Signal()
        is_first = word == 2
        first_fault = Signal.like(fault)
        for i in reversed(range(len(faults))):
            with m.If(group[i]):
                m.d.comb += first_fault.eq(i)
        being_written = Cat(*(is_record & ~is_snapshot & (fault == i) for i in range(len(faults))), is_snapshot)
        m.d.comb += ends.eq(chooses & ~more)
        m.d.sync += [
            group.eq(Mux(begins, wanted, group & ~being_written)),
            more.eq(group.any()),
            begun.eq(begins),
            second.eq(second ^ (is_first & ~begun)),
            chooses.eq(begun | (is_first & second)),
            self.snapshot_done.eq(chooses & is_snapshot),
            self.snapshot_number.eq(self.snapshot_number ^ self.snapshot_done),
        ]
        with m.If(chooses):
            m.d.sync += [
                is_record.eq(more),
                is_snapshot.eq(more & (group[: len(faults)] == 0)),
                fault.eq(first_fault),
            ]

        # Of a fault the first six words are kept.
        fault_word = Signal(3)
        m.d.comb += [
            self.record.eq(words[:WORD_BITS]),
            self.record_valid.eq(is_record & (is_snapshot | (word <= FAULT_WORDS))),
            fault_word.eq(word[:3] - 1),
            self.record_place.eq(
                Mux(
                    is_snapshot,
                    Cat(word, Const(_SNAPSHOT_PLACE >> 4, 4)),
                    Cat(fault_word, fault, Const(FAULT_LOG_ADDRESS >> 6, 2)),
                )
            ),
        ]
        return m
