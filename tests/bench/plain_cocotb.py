"""The plain way to simulate the core: cocotb makes the clock and drives every word. Only run by `compare_speed.py`."""

import json
import os
import time
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion

WORDS_VARIABLE = "ARCREF_BENCH_WORDS"
RESULT_VARIABLE = "ARCREF_BENCH_RESULT"
SAMPLES_PER_WORD = 4
SAMPLE_RATE_HZ = 800e6


@cocotb.test()
async def turns_at_10_rps(dut):
    """Drives words of an encoder at 10 r/s and reads the position after each; writes the seconds it took."""
    number = int(os.environ[WORDS_VARIABLE])
    duration_s = (number + 1) * SAMPLES_PER_WORD / SAMPLE_RATE_HZ
    encoder = SyntheticEncoder(Motion(-100.5).constant_speed(10, duration_s), SAMPLE_RATE_HZ)
    rows = encoder.whole().changes.to_words(SAMPLES_PER_WORD)[:number]
    lines = [[int(sum(int(state >> bit & 1) << i for i, state in enumerate(row))) for bit in range(3)] for row in rows]
    dut.rst.value, dut.strobe.value, dut.strobe_delay.value, dut.spi_cs_n.value = 1, 0, 0, 1
    dut.a.value, dut.b.value, dut.z.value = lines[0]
    Clock(dut.clk, 5, unit="ns").start()
    for _ in range(4):
        await RisingEdge(dut.clk)
    dut.rst.value = 0
    seen = set()
    begun = time.perf_counter()
    for a, b, z in lines:
        dut.a.value, dut.b.value, dut.z.value = a, b, z
        await RisingEdge(dut.clk)
        seen.add(dut.raw_position.value.to_signed())
    seconds = time.perf_counter() - begun
    assert len(seen) > number / 4, "the core did not count"
    Path(os.environ[RESULT_VARIABLE]).write_text(json.dumps({"words": number, "seconds": seconds}))
