"""The capture FIFO against its golden model: what is kept, what is lost, and what is told about it."""

import random

import pytest
from amaranth.sim import Simulator

from arcref_gateware.golden.captures import CaptureFifoModel
from arcref_gateware.link.capture_fifo import CaptureFifo

DEPTH = 8


def run(offers, takes):
    """Offer capture n in each clock n with `offers[n]`, take whenever `takes` allows it and one is ready.

    Returns (what was taken, the FIFO's lost and captures, the clocks in which it was taken).
    """
    fifo = CaptureFifo(DEPTH)
    simulator = Simulator(fifo)
    simulator.add_clock(1e-6)
    taken, clocks, end = [], [], {}

    async def bench(ctx):
        for clock, (offer, take) in enumerate(zip(offers, takes, strict=True)):
            ctx.set(fifo.valid, offer)
            ctx.set(fifo.time, clock)
            ctx.set(fifo.raw, -clock)
            ctx.set(fifo.corrected, -clock + (clock % 4097) - 2048)
            ctx.set(fifo.flags, clock & 0xFF)
            takes_now = take and ctx.get(fifo.ready)
            ctx.set(fifo.taken, takes_now)
            if takes_now:
                time, after_loss = ctx.get(fifo.out_time), ctx.get(fifo.out_after_loss)
                assert ctx.get(fifo.out_raw) == -time
                assert ctx.get(fifo.out_correction) == time % 4097 - 2048
                assert ctx.get(fifo.out_flags) == time & 0xFF
                taken.append((ctx.get(fifo.out_lost) if after_loss else None, time))
                clocks.append(clock)
            await ctx.tick()
        ctx.set(fifo.valid, 0)
        ctx.set(fifo.taken, 0)
        await ctx.tick().repeat(5)
        end.update(lost=ctx.get(fifo.lost), captures=ctx.get(fifo.captures), level=ctx.get(fifo.level))

    simulator.add_testbench(bench)
    simulator.run()
    return taken, clocks, end


def expected(offers, clocks):
    model, taken = CaptureFifoModel(DEPTH), []
    removals = set(clocks)
    for clock in range(len(offers) + 1):
        # A capture is in its record register for one clock before it is kept.
        if clock and offers[clock - 1]:
            model.offer(clock - 1)
        if clock in removals:
            taken.append(model.take())
    return taken, {"lost": model.lost, "captures": model.captures, "level": len(model)}


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("offer_rate", [0.05, 0.3, 1.0])
def test_random_captures_are_kept_lost_and_told_as_the_model_does(seed, offer_rate):
    rng = random.Random(seed)
    offers, takes = [], []
    while len(offers) < 1500:
        burst = rng.randrange(1, 80)
        rate = rng.choice([0.0, offer_rate, 1.0])
        pace = rng.choice([1, 4, 17, 1000])
        offers += [rng.random() < rate for _ in range(burst)]
        takes += [rng.randrange(pace) == 0 for _ in range(burst)]
    taken, clocks, end = run(offers, takes)
    assert (taken, end) == expected(offers, clocks)


def test_a_burst_at_full_rate_fills_the_fifo_and_tells_exactly_how_many_were_lost():
    offers = [True] * 50 + [False] * 400 + [True] + [False] * 100
    takes = [False] * 60 + [True] * 491
    taken, _, end = run(offers, takes)
    assert taken == [(None, n) for n in range(DEPTH)] + [(50 - DEPTH, 450)]
    assert end == {"lost": 50 - DEPTH, "captures": 51, "level": 0}


def test_clear_empties_the_fifo_and_forgets_what_was_lost():
    fifo = CaptureFifo(DEPTH)
    simulator = Simulator(fifo)
    simulator.add_clock(1e-6)

    async def bench(ctx):
        ctx.set(fifo.valid, 1)
        await ctx.tick().repeat(30)
        ctx.set(fifo.valid, 0)
        ctx.set(fifo.clear, 1)
        await ctx.tick()
        ctx.set(fifo.clear, 0)
        await ctx.tick().repeat(6)
        assert (ctx.get(fifo.ready), ctx.get(fifo.level), ctx.get(fifo.lost), ctx.get(fifo.captures)) == (0, 0, 0, 0)
        ctx.set(fifo.valid, 1)
        ctx.set(fifo.time, 77)
        await ctx.tick()
        ctx.set(fifo.valid, 0)
        await ctx.tick().repeat(6)
        assert (ctx.get(fifo.ready), ctx.get(fifo.out_time), ctx.get(fifo.out_after_loss)) == (1, 77, 0)

    simulator.add_testbench(bench)
    simulator.run()
