"""Records of one instant, kept in one block RAM: the snapshot that was asked for, and the first of each fault.

    words 0..47   eight for each fault, in the order of `fault_flags`: raw position (3), time (3)
    words 48..63  the snapshot: number (not kept here), raw position (3), time (3), position (3), flags

What is recorded is taken from the core's outputs in one clock, and written word by word behind it. Faults of one
instant share it. A fault that comes while a record is written, a dozen clocks, is entered with the instant after it.
"""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from arcref.angle import POSITION_BITS
from arcref.flags import FAULT_FLAGS, FLAG_MEANINGS, Flag
from arcref.link.register import WORD_BITS, Register
from arcref.link.registers import FAULT_LOG_STRIDE
from arcref_gateware.memory_attributes import NO_COLLISION

SNAPSHOT_PLACE = 48
FAULT_WORDS = 2 * POSITION_BITS // WORD_BITS
SNAPSHOT_WORDS = 3 * POSITION_BITS // WORD_BITS + 1


def fault_flags() -> list[Flag]:
    """The fault flags in the order of their logs."""
    return [flag for flag in FLAG_MEANINGS if flag & FAULT_FLAGS]


def is_recorded(register: Register) -> bool:
    """True for a register that stands in this memory."""
    name = register.name
    return name.endswith(("_first_position", "_first_time")) or (
        name.startswith("snapshot_") and name != "snapshot_number"
    )


class StatusRecorder(wiring.Component):
    """Keeps the records, and gives their words."""

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
    """1 for one clock once the snapshot can be read."""
    snapshot_number: Out(16)
    """Snapshots taken, modulo 65536."""
    address: In(6)
    """Word to read."""
    word: Out(WORD_BITS)
    """The word, two clocks after its address."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=WORD_BITS, depth=256, init=[], attrs=NO_COLLISION)
        write, read = memory.write_port(), memory.read_port(domain="comb")
        word = Signal(WORD_BITS, reset_less=True)
        m.d.comb += read.addr.eq(self.address)
        m.d.sync += [word.eq(read.data), self.word.eq(word)]

        faults = fault_flags()
        up = Cat(self.flags[flag.bit_length() - 1] for flag in faults)
        last_up, rises = Signal(len(faults)), Signal(len(faults))
        pending = Signal(len(faults))  # faults to be entered
        wants_snapshot, is_snapshot = Signal(), Signal()
        m.d.comb += rises.eq(up & ~last_up)
        m.d.sync += [last_up.eq(up), pending.eq(pending | rises)]
        with m.If(self.snapshot):
            m.d.sync += wants_snapshot.eq(1)

        instant = Cat(self.raw_position, self.time, self.position, self.flags, self.homed)
        shift = Signal(SNAPSHOT_WORDS * WORD_BITS, reset_less=True)
        group = Signal(len(faults))  # faults of the instant that is held
        next_fault = Signal(range(len(faults)))
        for i in reversed(range(len(faults))):
            with m.If(group[i]):
                m.d.comb += next_fault.eq(i)
        place, left = Signal(6), Signal(range(SNAPSHOT_WORDS + 1))
        m.d.sync += [
            write.en.eq(0),
            write.addr.eq(place),
            write.data.eq(shift[:WORD_BITS]),
            self.snapshot_done.eq(0),
        ]
        with m.FSM():
            with m.State("FOLLOW"):
                # Follows every word, so that a trigger finds the word it came with.
                with m.If(pending.any()):
                    m.d.sync += [group.eq(pending), pending.eq(rises)]
                    m.next = "FAULT"
                with m.Elif(wants_snapshot):
                    m.d.sync += [
                        wants_snapshot.eq(0),
                        is_snapshot.eq(1),
                        self.snapshot_number.eq(self.snapshot_number + 1),
                        place.eq(SNAPSHOT_PLACE + 1),
                        left.eq(SNAPSHOT_WORDS),
                    ]
                    m.next = "WRITE"
                with m.Else():
                    m.d.sync += shift.eq(instant)
            with m.State("FAULT"):
                m.d.sync += [
                    place.eq(next_fault * FAULT_LOG_STRIDE),
                    left.eq(SNAPSHOT_WORDS),
                    group.eq(group & (group - 1)),
                ]
                m.next = "WRITE"
            with m.State("WRITE"):
                # Once round, so that the instant serves the next fault of its group.
                m.d.sync += [
                    write.en.eq(is_snapshot | (left > SNAPSHOT_WORDS - FAULT_WORDS)),
                    place.eq(place + 1),
                    left.eq(left - 1),
                    shift.eq(shift.rotate_right(WORD_BITS)),
                ]
                with m.If(left == 1):
                    m.next = "END"
            with m.State("END"):
                m.d.sync += [self.snapshot_done.eq(is_snapshot), is_snapshot.eq(0)]
                with m.If(group.any()):
                    m.next = "FAULT"
                with m.Else():
                    m.d.sync += shift.eq(instant)
                    m.next = "FOLLOW"
        return m
