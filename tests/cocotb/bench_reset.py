"""Reset: whatever the lines show, it leaves a clean core that counts nothing false."""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import lines, random_walk, rest, ride

from arcref.flags import FAULT_FLAGS, Flag


@cocotb.test()
async def reset_in_any_state_makes_no_false_step_and_no_false_fault(dut):
    driver = CoreDriver(dut)
    for start in range(4):
        for z in (0, 1):
            for strobe in (0, 1):
                count = np.concatenate([rest(start, 40), ride(start, start + 9, start - 9, samples_per_count=2.5)])
                await driver.reset(int(lines(start, z=z, strobe=strobe)))
                await driver.play(lines(count, z=z, strobe=strobe))
                await driver.check()
                at_rest = slice(40 // driver.samples_per_word)
                assert not driver.per_word("raw_position")[at_rest].any()
                assert not driver.per_word("flags")[at_rest].max() & FAULT_FLAGS
                # Once the shaft moves, a Z that is stuck high is an index at every fourth count, and rightly reported.
                assert not driver.per_word("flags").max() & FAULT_FLAGS & ~Flag.CLOSURE_ERROR
                assert driver.per_word("homed")[0] == (z and start == 0)
                assert not driver.captures, "a strobe line that is stuck high captured something"


@cocotb.test()
async def first_sample_may_move_on_at_once(dut):
    driver = CoreDriver(dut)
    for start in range(4):
        for before in range(4):
            for direction in (1, -1):
                count = ride(start - direction, start + 40 * direction, samples_per_count=1)
                await driver.reset(int(lines(before)))
                await driver.play(lines(count))
                await driver.check()
                shown = driver.per_word("raw_position")[:8]
                assert list(shown) == list((count - start)[driver.samples_per_word - 1 :: driver.samples_per_word][:8])


@cocotb.test()
async def reset_in_the_middle_of_a_run_starts_clean(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(1)
    await driver.reset()
    for clocks in (1, 2, 3, 7, 20):
        # Everything at once: homed, illegal steps, closure errors, strobes on their way.
        noise = random.integers(0, 16, 300 * driver.samples_per_word)
        await driver.play(noise)
        in_reset = random.integers(0, 16, (clocks, driver.samples_per_word))
        await driver.reset(clocks=clocks, noise=in_reset, strobe_delay=int(random.integers(0, 100)))
        count = random_walk(random, int(random.integers(-40, 40)), 400 * driver.samples_per_word)
        strobe = random.random(len(count)) < 0.05
        await driver.play(lines(count, z=(count & ~3) == 0, strobe=strobe))
        await driver.check()
        assert driver.per_word("illegal_steps").max() == 0


@cocotb.test()
async def reset_starts_the_check_of_the_tables_again(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(2)
    for clocks, words in ((3, 2000), (1, 10600)):
        await driver.reset(clocks=clocks)
        count = random_walk(random, 0, words * driver.samples_per_word)
        await driver.play(lines(count, z=count == 0))
        await driver.check()
    assert driver.per_word("flags")[-1] & Flag.CORRECTION_ACTIVE
    assert not driver.per_word("flags").max() & Flag.ROM_FAULT


@cocotb.test()
async def outputs_are_zero_while_in_reset_whatever_the_lines_do(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(3)
    await driver.reset()
    await driver.play(random.integers(0, 16, 200 * driver.samples_per_word))
    await driver.reset(clocks=40, noise=random.integers(0, 16, (40, driver.samples_per_word)))
    for name in ("raw_position", "position", "homed", "flags", "index_count", "illegal_steps", "closure_error"):
        assert driver.read(name) == 0
    assert driver.read("capture_valid") == 0
