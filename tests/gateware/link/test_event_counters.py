"""Counters in the register file's memory against plain numbers: events in every clock, clears, limits, resets."""

import random

import pytest
from amaranth.hdl import Module, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from arcref.link.register import UNKNOWN_WORD
from arcref.link.registers import REGISTERS
from arcref_gateware.link.event_counters import ROUND_CLOCKS, EventCounters
from arcref_gateware.link.register_layout import CONSTANTS, COUNTED, initial_words
from arcref_gateware.link.register_memory import BUS_READ, RegisterMemory

NAMES = [counted.name for counted in COUNTED]
OFTEN = [counted.name for counted in COUNTED if not counted.rare]
SETTLED = 2 * ROUND_CLOCKS
"""Clocks after which the last event stands in the memory."""

FIRST_WORDS = initial_words(dict.fromkeys(CONSTANTS, 0xA5C3), {})


class Counting(wiring.Component):
    """Counters with their memory and the small counters before them: bit n of `events` is an event of register n."""

    events: In(len(COUNTED))
    clear: In(1)
    place: In(8)
    word: Out(16)
    reads: Out(1)

    def __init__(self, words=FIRST_WORDS):
        self.memory, self.counters = RegisterMemory(list(words)), EventCounters()
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory, m.submodules.counters = memory, counters = self.memory, self.counters
        for event, counted in zip(self.events, COUNTED, strict=True):
            small = Signal(counted.bits, name=f"{counted.name}_small")
            m.d.sync += small.eq(small + event)
            if counted.cleared:
                with m.If(self.clear):
                    m.d.sync += small.eq(0)
            m.d.comb += getattr(counters, counted.name).eq(small)
        m.d.comb += [
            counters.clear.eq(self.clear),
            counters.phase.eq(memory.phase),
            counters.word.eq(memory.word),
            memory.counter_place.eq(counters.read_place),
            memory.total_place.eq(counters.write_place),
            memory.total.eq(counters.total),
            memory.bus_place.eq(self.place),
            self.word.eq(memory.word),
            self.reads.eq(memory.phase[BUS_READ]),
        ]
        return m


class Rig:
    """Drives `Counting` and keeps the numbers that it must come to."""

    def __init__(self, body, words=FIRST_WORDS):
        self.dut, self.reset = Counting(words), Signal()
        self.right = dict.fromkeys(NAMES, 0)
        simulator = Simulator(ResetInserter(self.reset)(self.dut))
        simulator.add_clock(1e-6)

        async def drive(ctx):
            self.ctx = ctx
            await body(self)

        simulator.add_testbench(drive)
        simulator.run()

    async def clock(self, names=(), *, clear=False, reset=False):
        """One clock with an event of each of `names`."""
        self.ctx.set(self.dut.events, sum(1 << NAMES.index(name) for name in names))
        self.ctx.set(self.dut.clear, clear)
        self.ctx.set(self.reset, reset)
        await self.ctx.tick()
        for counted in COUNTED:
            if reset or (clear and counted.cleared):
                self.right[counted.name] = 0
            elif counted.name in names:
                bits = REGISTERS[counted.name].width
                more = self.right[counted.name] + 1
                self.right[counted.name] = min(more, (1 << bits) - 1) if counted.saturates else more % (1 << bits)

    async def clocks(self, number: int, names=()):
        for _ in range(number):
            await self.clock(names)

    async def read(self, name: str, names=()) -> int:
        """The register, its words one phase round behind the other, with events in every clock of it."""
        words = []
        for place in REGISTERS[name].addresses:
            self.ctx.set(self.dut.place, place)
            while not self.ctx.get(self.dut.reads):
                await self.clock(names)
            await self.clocks(3, names)
            words.append(self.ctx.get(self.dut.word))
        return REGISTERS[name].decode(words)

    async def write(self, place: int, word: int):
        """Put a word into the memory, again and again for a round: one alone may be overtaken by a look at it."""
        for port, value in (("setting_place", place), ("setting", word), ("setting_valid", 1)):
            self.ctx.set(getattr(self.dut.memory, port), value)
        await self.clocks(ROUND_CLOCKS + 8)
        self.ctx.set(self.dut.memory.setting_valid, 0)

    async def check(self):
        await self.clocks(SETTLED)
        for name in NAMES:
            assert await self.read(name) == self.right[name], name


def test_random_events_with_clears_and_resets_in_the_middle_are_all_counted():
    rng = random.Random(1)

    async def body(rig):
        for _ in range(25):
            density = rng.choice([0, 0.01, 0.5, 0.99, 1])
            rare_left = 0
            for _ in range(rng.randrange(400)):
                names = [name for name in OFTEN if rng.random() < density]
                if rare_left == 0:
                    rare_left = ROUND_CLOCKS + rng.randrange(90)
                    names += rng.sample(sorted(set(NAMES) - set(OFTEN)), rng.randrange(4))
                rare_left -= 1
                await rig.clock(names, clear=rng.random() < 0.01, reset=rng.random() < 0.002)
            await rig.check()

    Rig(body)


@pytest.mark.parametrize("after", range(0, ROUND_CLOCKS, 3))
def test_an_event_in_every_clock_is_counted_from_any_moment_of_a_clear_or_reset_on(after):
    async def body(rig):
        await rig.clock(reset=True)
        await rig.clocks(after, OFTEN)
        await rig.clock(clear=True)
        await rig.clocks(3 * ROUND_CLOCKS + after, OFTEN)
        await rig.check()
        await rig.clocks(after)
        await rig.clock(reset=True)
        await rig.clocks(5 * ROUND_CLOCKS, OFTEN)
        await rig.check()

    Rig(body)


def test_fault_counts_stay_at_their_largest_value_and_the_others_run_over():
    async def body(rig):
        await rig.clock(reset=True)
        short = 300
        await rig.clocks(SETTLED)  # the first round begins with 0 whatever stands in the memory
        for counted in COUNTED:
            if not counted.rare:
                almost = (1 << REGISTERS[counted.name].width) - short
                almost &= ~0x7F  # the small counters stand at 0
                rig.right[counted.name] = almost
                for i, place in enumerate(REGISTERS[counted.name].addresses):
                    await rig.write(place, almost >> 16 * i & 0xFFFF)
        await rig.check()
        for _ in range(12):
            await rig.clocks(61, OFTEN)
            await rig.check()
        assert rig.right["illegal_step_count"] == 65535
        assert 0 < rig.right["captures"] < 1000

    Rig(body)


def test_a_number_of_two_words_is_read_whole_while_it_runs_over():
    """Its lower word goes round while it is read, from every phase of the round."""
    wide = [name for name in OFTEN if REGISTERS[name].words == 2]

    async def body(rig):
        await rig.clocks(SETTLED)
        for name in wide:
            await rig.write(REGISTERS[name].address, 0xFE00)
            rig.right[name] = 0xFE00
        seen = []
        while rig.right[wide[0]] < 0x10400:
            for name in wide:
                before = rig.right[name]
                value = await rig.read(name, OFTEN)
                assert before - SETTLED <= value <= rig.right[name]
                seen.append(value)
        assert min(seen) < 0x10000 < max(seen)

    Rig(body)


def test_words_of_no_counter_are_never_written():
    async def body(rig):
        for _ in range(2):
            await rig.clocks(4 * ROUND_CLOCKS, OFTEN)
            counted = {place for name in NAMES for place in REGISTERS[name].addresses}
            for place in set(range(256)) - counted:
                rig.ctx.set(rig.dut.place, place)
                while not rig.ctx.get(rig.dut.reads):
                    await rig.clock()
                await rig.clocks(3)
                assert rig.ctx.get(rig.dut.word) == FIRST_WORDS[place], hex(place)
            await rig.clock(reset=True)
        assert UNKNOWN_WORD in FIRST_WORDS

    Rig(body)
