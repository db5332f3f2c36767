"""The register file, made from the declaration in `arcref.link.registers`.

Whatever can stands in one memory, see `register_layout`: constants, what was written to settings, snapshot and fault
logs, counted registers. The few values that are live are joined to what is read there. A request goes through four
steps of a round of the memory's phases each:

1. the address is looked at;
2. the first word of its pair is read, and the live values of both are taken;
3. the second word is read;
4. a write acts, and the status is known.

So the two words of a register are of one instant. A following request for the second word gets the one that was taken
with the first.
"""

from amaranth.hdl import Cat, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import Status
from arcref.link.register import ADDRESS_BITS, WORD_BITS
from arcref.link.registers import REGISTERS
from arcref_gateware.link.event_counters import EventCounters
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request
from arcref_gateware.link.register_decoder import RegisterDecoder
from arcref_gateware.link.register_layout import (
    COUNTED,
    PLACE_BITS,
    READABLE_WINDOW,
    SHADOW_BITS,
    UNKNOWN_PAIR,
    ZERO_PLACE,
    initial_words,
    live_registers,
    settings,
    writable_registers,
)
from arcref_gateware.link.register_memory import BUS_READ, BUS_WORD, SETTING_WRITE, RegisterMemory
from arcref_gateware.link.selected_words import joining_clocks, selected_word
from arcref_gateware.link.written_registers import WrittenRegisters

READ_FIRST, READ_SECOND, ACT = 1, 2, 3
"""Steps of a request."""

STEPS = 4

# A step ends with the phase that brings the bus's word, and the next one begins with that in which a place is taken.
assert BUS_READ == BUS_WORD + 1 == SETTING_WRITE + 1


class RegisterFile(wiring.Component):
    """One port for each register that is not constant or recorded, by its name.

    Inputs are the values of live registers and what tells of the events of counted ones, see `EventCounters`. Outputs
    are settings and commands; a command's holds the written value for one clock and is 0 otherwise. Besides: the bus,
    the recorder's records and the windows. `constants` gives the registers `register_layout.CONSTANTS`, `resets` gives
    settings another reset value than the declaration.

    The lower word of a setting that is written alone waits in the memory, where it is read back, for the upper one.
    """

    def __init__(self, constants: dict[str, int], resets: dict[str, int] | None = None):
        self.resets = resets or {}
        self.constants = constants
        members = {"bus": In(RegisterBus())}
        for register in live_registers():
            members[register.name] = In(signed(register.width) if register.signed else register.width)
        members |= {counted.name: In(counted.bits) for counted in COUNTED}
        self.written = WrittenRegisters(self.resets)
        members |= {register.name: self.written.signature.members[register.name] for register in writable_registers()}
        super().__init__(
            members
            | {
                "snapshot": Out(1),
                "snapshot_done": In(1),
                "record_valid": In(1),
                "record_place": In(PLACE_BITS),
                "record": In(WORD_BITS),
                "window_address": Out(12),
                "grid_written": Out(1),
                "captures_cleared": In(1),
                "identity_word": In(WORD_BITS),
                "loading": In(1),
                "window_write": Out(len(REGISTERS.windows)),
                "window_word": Out(WORD_BITS),
            }
        )

    bus: In
    """The doors' bus."""
    snapshot: Out
    """1 for one clock: take a snapshot."""
    snapshot_done: In
    """1 for one clock once its words were given."""
    record_valid: In
    """1 while a record's words come; see `StatusRecorder`."""
    record_place: In
    """Where `record` belongs in the memory."""
    record: In
    """A word of a record."""
    window_address: Out
    """Word of a window, counted from its beginning."""
    grid_written: Out
    """1 for one clock as the compare output's period or start was written, with the new value."""
    captures_cleared: In
    """1 for one clock: the counts of captures start from 0, those that are told in the next clock."""
    identity_word: In
    """Word of the identity memory, four clocks after its address."""
    loading: In
    """1 while trial tables are loaded: the windows may be written."""
    window_write: Out
    """Bit n: write `window_word` to window n of the declaration, for one clock."""
    window_word: Out
    """Word for a window."""

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        m.submodules.memory = memory = RegisterMemory(initial_words(self.constants, self.resets))
        m.submodules.counters = counters = EventCounters()
        m.submodules.decoder = decoder = RegisterDecoder()
        m.submodules.written = written = self.written

        # The request, held.
        address, word = Signal(ADDRESS_BITS, reset_less=True), Signal(WORD_BITS, reset_less=True)
        is_read, is_write, is_upper = Signal(), Signal(), Signal()
        m.d.sync += [
            address.eq(bus.address),
            word.eq(bus.write_word),
            is_read.eq(bus.request == Request.READ),
            is_write.eq(bus.request == Request.WRITE),
        ]
        m.d.comb += [decoder.address.eq(address), decoder.word.eq(word), decoder.is_upper.eq(is_upper)]
        takes_snapshot = Signal()
        m.d.sync += takes_snapshot.eq(decoder.at_snapshot & is_read)
        asked, step, goes_on = self._steps(m, memory.phase[BUS_WORD], counters.round_ends, takes_snapshot)
        # A read works on both words of the pair, one after the other; anything else on its own, until the next request.
        reads_next = goes_on | (step[0] & ~takes_snapshot)
        with m.If(memory.phase[BUS_WORD] & (asked | reads_next)):
            m.d.sync += is_upper.eq(~asked & (is_read | address[0]))

        # What is read, and where.
        in_identity = decoder.window[READABLE_WINDOW]
        pair = decoder.place[1:]
        reads_pair = Signal.like(pair)
        with m.If(decoder.is_unknown):
            m.d.sync += reads_pair.eq(UNKNOWN_PAIR >> 1)
        with m.Elif(in_identity):
            m.d.sync += reads_pair.eq(ZERO_PLACE >> 1)
        with m.Else():
            m.d.sync += reads_pair.eq(
                pair ^ ((written.as_after_reset & is_read).replicate(len(pair)) & SHADOW_BITS >> 1)
            )
        reads_upper = Signal()
        m.d.sync += reads_upper.eq(is_upper)
        m.d.comb += memory.bus_place.eq(Cat(reads_upper, reads_pair))

        first_live, second_live = _live_words(m, self, decoder, in_identity)
        first, second = Signal(WORD_BITS, reset_less=True), Signal(WORD_BITS, reset_less=True)
        is_second, has_second, takes = Signal(), Signal(), Signal()
        m.d.sync += [
            is_second.eq(address[0] & ~in_identity),
            has_second.eq(is_second & bus.following & is_read),
            takes.eq(memory.phase[BUS_WORD - 1] & (step[READ_FIRST] | step[READ_SECOND]) & ~has_second),
        ]
        # Spelt out so that both are enabled together: an enable of few registers costs more than it saves.
        later = step[READ_SECOND].replicate(WORD_BITS)
        with m.If(takes):
            m.d.sync += [
                first.eq((first & later) | ((first_live | memory.word) & ~later)),
                second.eq((second & later) | (memory.word & later) | (second_live & ~later)),
            ]
        m.d.comb += bus.read_word.eq(Mux(is_second, second, first))

        # What a write does. The windows' memories are elsewhere.
        act, keeps = Signal(), Signal()
        in_window = Signal()
        m.d.sync += [
            act.eq(memory.phase[BUS_READ] & step[ACT] & is_write),
            keeps.eq(step[ACT] & is_write & decoder.kept),
            in_window.eq(decoder.window.any()),
            self.window_write.eq(decoder.window & act.replicate(len(decoder.window))),
        ]
        m.d.comb += [
            written.act.eq(act),
            self.grid_written.eq(written.grid_written),
            written.word.eq(word),
            written.lower_word.eq(first),
            memory.setting_valid.eq(keeps),
            memory.setting_place.eq(decoder.place),
            memory.setting.eq(word),
            self.window_address.eq(address),
            self.window_word.eq(word),
        ]
        for register in writable_registers():
            at = f"at_{register.name}"
            m.d.comb += [
                getattr(self, register.name).eq(getattr(written, register.name)),
                getattr(written, at).eq(getattr(decoder, at)),
            ]
        for register in settings():
            inside = f"in_{register.name}"
            m.d.comb += getattr(written, inside).eq(getattr(decoder, inside))

        # What is said of a write before it acts.
        incomplete, refused = Signal(), Signal()
        unknown, read_only, out_of_range, not_now = Signal(), Signal(), Signal(), Signal()
        m.d.sync += [
            incomplete.eq((decoder.later_word & ~bus.following) | (decoder.two_words & bus.is_last)),
            refused.eq(decoder.misfit | incomplete),
            unknown.eq(~is_read & ~in_window & ~decoder.known),
            read_only.eq(~is_read & ~in_window & decoder.known & ~decoder.writable),
            out_of_range.eq(~is_read & ~in_window & decoder.writable & refused),
            not_now.eq(~is_read & in_window & ~self.loading),
        ]
        m.d.comb += bus.status.eq(
            _status(unknown, Status.UNKNOWN_ADDRESS)
            | _status(read_only, Status.READ_ONLY)
            | _status(out_of_range, Status.OUT_OF_RANGE)
            | _status(not_now, Status.NOT_NOW)
        )

        # The memory's other users.
        m.d.comb += [
            memory.counter_place.eq(counters.read_place),
            memory.total_place.eq(counters.write_place),
            memory.total.eq(counters.total),
            memory.record_valid.eq(self.record_valid),
            memory.record_place.eq(self.record_place),
            memory.record.eq(self.record),
            counters.phase.eq(memory.phase),
            counters.word.eq(memory.word),
            counters.clear.eq(self.captures_cleared),
            *(getattr(counters, counted.name).eq(getattr(self, counted.name)) for counted in COUNTED),
        ]
        return m

    def _steps(self, m: Module, ends, round_ends, takes_snapshot):
        """Whether there is a request, its way through its steps, and whether a snapshot that it waited for is there."""
        asked, step = Signal(), Signal(STEPS)
        # A snapshot takes its time, and a whole round of the counters after it, to count it.
        waits, recorded, rounds = Signal(), Signal(), Signal(2)
        begins_wait, ends_wait = Signal(), Signal()
        goes_on = rounds[1]
        m.d.comb += [begins_wait.eq(ends & step[0] & takes_snapshot), ends_wait.eq(ends & goes_on)]
        m.d.sync += [
            asked.eq(self.bus.valid | (asked & ~ends)),
            self.bus.done.eq(ends & step[ACT]),
            self.snapshot.eq(begins_wait),
            waits.eq(begins_wait | (waits & ~ends_wait)),
            recorded.eq((self.snapshot_done & waits) | (recorded & ~ends_wait)),
            rounds.eq((rounds | (Cat(1, rounds[0]) & (recorded & round_ends).replicate(2))) & ~ends_wait.replicate(2)),
        ]
        with m.If(ends):
            m.d.sync += step.eq(Cat(asked, (step[0] & ~takes_snapshot) | goes_on, step[READ_FIRST:]))
        return asked, step, goes_on


def _status(holds, status: Status):
    """The status, or 0."""
    return int(status) & holds.replicate(STATUS_BITS)


def _live_words(m: Module, file: RegisterFile, decoder: RegisterDecoder, in_identity):
    """The live values, and the identity's, at the two words of the pair, both of one clock."""
    firsts, seconds = [(in_identity, file.identity_word)], []
    for register in live_registers():
        value = getattr(file, register.name).as_unsigned()
        select = getattr(decoder, f"pair_{register.name}")
        low, high = value[:WORD_BITS], value[WORD_BITS:]
        if register.address % 2:
            seconds.append((select, low))
        else:
            firsts.append((select, low))
            if len(high):
                seconds.append((select, high))
    clocks = max(joining_clocks(len(firsts)), joining_clocks(len(seconds)))
    return (
        selected_word(m, firsts, name="first_live", clocks=clocks),
        selected_word(m, seconds, name="second_live", clocks=clocks),
    )
