# amaranth: UnusedElaboratable=no
"""The capture FIFO against its golden model, clock by clock: what is kept, what is lost, and what is told about it."""

import random

import pytest
from amaranth.sim import Simulator

from arcref.link.capture_record import CaptureRecord
from arcref_gateware.golden.captures import CaptureFifoModel
from arcref_gateware.link.capture_fifo import REOPEN_CLOCKS, TAKE_CLOCKS, CaptureFifo
from arcref_gateware.link.record_memory import READ_CLOCKS

DEPTH = 16


def record_of(clock: int) -> CaptureRecord:
    """The capture that is offered in a clock."""
    raw = clock * 0x9E3779B97F4A7C15 % (1 << 48) - (1 << 47)
    return CaptureRecord(clock | (clock & 0xFF) << 40, raw, raw + clock % 8193 - 4096, clock & 0xFF)


class Reader:
    """Reads the FIFO as the streamer does, at its own pace: the number of the lost ones first, then the record."""

    def __init__(self, ctx, fifo, pace):
        self.ctx, self.oldest, self.pace = ctx, fifo.oldest, pace
        self.taken = []  # (captures lost before it or None, record)
        self.steps = self._steps()
        self.takes = self.tells = False

    def clock(self):
        """Sets the FIFO's inputs for this clock."""
        for name in ("taken", "told", "next_lost"):
            self.ctx.set(getattr(self.oldest, name), 0)
        next(self.steps)
        self.takes, self.tells = self.ctx.get(self.oldest.taken), self.ctx.get(self.oldest.told)

    def _word(self, number):
        self.ctx.set(self.oldest.word_number, number)
        for _ in range(READ_CLOCKS):
            yield
        return self.ctx.get(self.oldest.word)

    def _steps(self):
        while True:
            self.ctx.set(self.oldest.reading, 0)
            while not (self.ctx.get(self.oldest.ready) and self.pace()):
                yield
            self.ctx.set(self.oldest.reading, 1)
            last = yield from self._word(7)
            lost = None
            if last >> 8 & 1:
                lost = 0
                for byte in range(4):
                    lost |= self.ctx.get(self.oldest.lost) << 8 * byte
                    self.ctx.set(self.oldest.next_lost, 1)
                    yield
                    yield
                    yield
                self.ctx.set(self.oldest.told, 1)
                yield
            words = []
            for number in range(8):
                words.append((yield from self._word(number)))
            assert words[7] == last
            data = b"".join(word.to_bytes(2, "little") for word in words)
            self.taken.append((lost, CaptureRecord.decode(data[:15])))
            self.ctx.set(self.oldest.taken, 1)
            yield
            for _ in range(TAKE_CLOCKS - 1):
                yield


def run(offers, pace):
    """Offer a capture in each clock of `offers`; compare what is read, and at the end what is counted, with the model.

    Returns (what was taken, the model).
    """
    fifo, model = CaptureFifo(DEPTH), CaptureFifoModel(DEPTH, REOPEN_CLOCKS)
    simulator = Simulator(fifo)
    simulator.add_clock(1e-6)
    expected = []

    async def bench(ctx):
        await ctx.tick().repeat(2)  # it is cleared just after reset
        reader = Reader(ctx, fifo, pace)
        result.append(reader.taken)
        for clock, offer in enumerate(offers):
            record = record_of(clock)
            ctx.set(fifo.valid, offer)
            for name in ("time", "raw", "corrected", "flags"):
                ctx.set(getattr(fifo, name), getattr(record, name))
            reader.clock()
            if reader.takes:
                expected.append(model.queue[0])
            model.clock(record if offer else None, takes=reader.takes, tells=reader.tells)
            await ctx.tick()
            assert reader.taken[: len(expected)] == expected
        for port in (fifo.valid, fifo.oldest.taken, fifo.oldest.told):
            ctx.set(port, 0)
        await ctx.tick().repeat(10)
        got = {name: ctx.get(getattr(fifo, name)) for name in ("lost", "captures", "level")}
        assert got == {"lost": model.lost % 128, "captures": model.captures % 128, "level": len(model.queue)}

    result = []
    simulator.add_testbench(bench)
    simulator.run()
    return result[0], model


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("rate", [0.02, 0.3, 1.0])
def test_random_captures_are_kept_lost_and_told_as_the_model_does(seed, rate):
    rng = random.Random(f"{seed} {rate}")
    offers, paces = [], []
    while len(offers) < 2500:
        burst = rng.randrange(1, 120)
        here = rng.choice([0.0, rate, 1.0])
        offers += [rng.random() < here for _ in range(burst)]
        paces += [rng.choice([1, 1, 5, 60, 10_000])] * burst
    clock = iter(paces)
    taken, model = run(offers, lambda: rng.randrange(next(clock)) == 0)
    assert len(taken) > 5
    assert model.lost > 0 or rate < 0.1


def test_a_burst_at_full_rate_fills_the_fifo_and_tells_exactly_how_many_were_lost():
    offers = [True] * 50 + [False] * 1400 + [True] + [False] * 100
    started = iter([False] * 60 + [True] * 2000)
    taken, model = run(offers, lambda: next(started))
    assert taken == [(None, record_of(n)) for n in range(DEPTH)] + [(50 - DEPTH, record_of(1450))]
    assert (model.lost, model.captures) == (50 - DEPTH, 51)


def test_more_than_sixty_five_thousand_losses_are_told_exactly():
    number = (1 << 16) + 3000
    fifo = CaptureFifo(DEPTH)
    simulator = Simulator(fifo)
    simulator.add_clock(1e-6)

    async def bench(ctx):
        await ctx.tick().repeat(2)
        ctx.set(fifo.valid, 1)
        await ctx.tick().repeat(number)
        ctx.set(fifo.valid, 0)
        reader = Reader(ctx, fifo, lambda: True)
        for clock in range(1200):
            reader.clock()
            ctx.set(fifo.valid, clock == 1000)
            await ctx.tick()
        assert [lost for lost, _ in reader.taken] == [None] * DEPTH + [number - DEPTH]

    simulator.add_testbench(bench)
    simulator.run()


@pytest.mark.parametrize("seed", range(12))
def test_clear_empties_the_fifo_in_whatever_state_it_is_and_forgets_what_was_lost(seed):
    rng = random.Random(seed)
    fifo = CaptureFifo(DEPTH)
    simulator = Simulator(fifo)
    simulator.add_clock(1e-6)

    async def bench(ctx):
        reads = True
        reader = Reader(ctx, fifo, lambda: reads)

        async def clocks(count, rate, first=0):
            for clock in range(first, first + count):
                record = record_of(clock)
                for name in ("time", "raw", "corrected", "flags"):
                    ctx.set(getattr(fifo, name), getattr(record, name))
                ctx.set(fifo.valid, rng.random() < rate)
                reader.clock()
                await ctx.tick()
                ctx.set(fifo.clear, 0)

        for _ in range(6):
            reads = rng.random() < 0.7
            await clocks(rng.randrange(1, 150), rng.choice([0.01, 0.2, 1.0]))
            before = len(reader.taken)
            ctx.set(fifo.clear, 1)
            await clocks(1, 1.0)
            # What is being read goes on to its end, and is whole.
            await clocks(60, 0.0)
            assert len(reader.taken) <= before + 1
            assert all(record == record_of(record.time & 0xFFFFFFFFFF) for _, record in reader.taken)
            got = [ctx.get(port) for port in (fifo.oldest.ready, fifo.level, fifo.lost, fifo.captures)]
            assert got == [0, 0, 0, 0]
            reads, before = True, len(reader.taken)
            await clocks(1, 1.0, first=77_000)
            await clocks(100, 0.0)
            assert reader.taken[before:] == [(None, record_of(77_000))]
            reads = False
            await clocks(DEPTH + 5, 1.0)
            await clocks(8, 0.0)
            assert [ctx.get(port) for port in (fifo.level, fifo.lost, fifo.captures)] == [DEPTH, 5, DEPTH + 6]

    simulator.add_testbench(bench)
    simulator.run()


def test_a_fifo_too_small_is_refused():
    with pytest.raises(ValueError, match="16 is the least"):
        CaptureFifo(8)
