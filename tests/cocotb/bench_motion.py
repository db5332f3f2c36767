"""Counting: whatever the shaft does within reach of the samples, core and golden model read the true count."""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import SAMPLE_NS, SAMPLE_S, encoder_run, hold_steps, lines, mark, random_walk, rest, ride

from arcref.flags import Flag
from arcref_sim.motion import Motion
from arcref_sim.square_waves import SquareWaves, ZeroMark

WORDS = 10600
"""Words of one run: long enough to home and, past the check of the tables at power-up, to be corrected."""


async def count_without_loss(driver: CoreDriver, states, count, *, strobe_delay: int = 0) -> None:
    """Play a run from reset: bit for bit the golden model's, every count the true one, no illegal step."""
    await driver.reset(int(states[0]), strobe_delay=strobe_delay)
    await driver.play(states)
    await driver.check()
    shown = driver.per_word("raw_position")[: len(count) // driver.samples_per_word]
    true = count[driver.samples_per_word - 1 :: driver.samples_per_word][: len(shown)]
    homed = driver.per_word("homed")[: len(shown)].astype(bool)
    assert homed.any()
    assert np.array_equal(shown, np.where(homed, true, true - count[0]))
    assert driver.read("illegal_steps") == 0
    assert driver.read("largest_closure_error") == 0
    assert not driver.read("flags") & (Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR | Flag.INDEX_FAULT | Flag.ROM_FAULT)


def through_zero(driver: CoreDriver, speed: float) -> Motion:
    """The start of a motion at `speed` counts a sample that meets the zero mark after a quarter of a run."""
    return Motion(-speed * WORDS * driver.samples_per_word / 4 + 0.37)


@cocotb.test()
async def constant_speed_is_counted_from_rest_to_one_count_a_sample(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    for speed in (0.001, 0.05, 0.31, 0.5, 2 / 3, 0.9, 0.999, 1.0):
        for direction in (1, -1):
            motion = through_zero(driver, direction * speed).constant_speed(direction * speed, duration_s)
            await count_without_loss(driver, *encoder_run(motion))


@cocotb.test()
async def ramps_are_counted(dut):
    driver = CoreDriver(dut)
    half_s = WORDS * driver.samples_per_word * SAMPLE_S / 2
    for speed in (0.2, 0.99, -0.99):
        motion = through_zero(driver, speed / 2).ramp(speed, half_s).ramp(-speed, 2 * half_s)
        await count_without_loss(driver, *encoder_run(motion))


@cocotb.test()
async def reversals_are_counted_at_each_phase_and_each_sample_of_a_word(dut):
    driver = CoreDriver(dut)
    turns = [(far, near) for far in range(3, 7) for near in range(-6, -2)]
    for samples_per_count in (1, 1.5, 2, 3.25):
        for shift in range(driver.samples_per_word):
            targets = [target for pair in turns for target in pair]
            count = np.concatenate([rest(-9, shift + 1), ride(-9, *targets, samples_per_count=samples_per_count)])
            await count_without_loss(driver, lines(count, z=mark(count)), count)


@cocotb.test()
async def back_and_forth_is_counted(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    for amplitude in (0.7, 3.0, 150.0):
        # The fastest moment of the sine comes to a little below one count a sample.
        frequency_hz = min(0.95 / (2 * np.pi * amplitude * SAMPLE_S), 0.1 / SAMPLE_S)
        for start in (0.0, 0.4, 0.99):
            motion = Motion(start).swing(amplitude, frequency_hz, duration_s * frequency_hz)
            await count_without_loss(driver, *encoder_run(motion))


@cocotb.test()
async def random_steps_are_counted(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(5)
    for chances in ((0.5, 0, 0.5), (0.1, 0, 0.9), (0.3, 0.3, 0.4), (0.02, 0.96, 0.02)):
        walk = random_walk(random, -3, WORDS * driver.samples_per_word, chances)
        count = np.concatenate([ride(-20, 3, -3), walk])
        await count_without_loss(driver, lines(count, z=mark(count)), count)


@cocotb.test()
async def jitter_duty_and_phase_errors_cost_no_count(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    spaced = {"shortest_edge_spacing_ns": 1.02 * SAMPLE_NS}
    for number, waves in enumerate(
        (
            SquareWaves(jitter_ns=0.3 * SAMPLE_NS, **spaced),
            SquareWaves(jitter_ns=0.7 * SAMPLE_NS, **spaced),
            SquareWaves(a_duty=0.43, b_duty=0.56, **spaced),
            SquareWaves(phase_error_deg=-35, **spaced),
            SquareWaves(a_duty=0.55, phase_error_deg=25, jitter_ns=0.2 * SAMPLE_NS, **spaced),
        )
    ):
        for speed in (0.2, -0.5):
            motion = through_zero(driver, speed).constant_speed(speed, duration_s)
            # Z stays in its place while jitter and shifts move the gate state, so it is wider than one state.
            states, count = encoder_run(motion, waves=waves, zero_mark=ZeroMark(width_states=3), seed=number)
            await count_without_loss(driver, states, count)


@cocotb.test()
async def bunched_edges_of_a_converter_are_counted(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    for interval, speed in ((40, 0.5), (160, -0.7), (900, 0.9)):
        waves = SquareWaves(conversion_interval_ns=interval * SAMPLE_NS, shortest_edge_spacing_ns=1.02 * SAMPLE_NS)
        motion = through_zero(driver, speed).constant_speed(speed, duration_s)
        await count_without_loss(driver, *encoder_run(motion, waves=waves))


@cocotb.test()
async def any_noise_on_all_lines_gives_what_the_golden_model_says(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(6)
    for longest, words in ((1, 10600), (3, 2000), (40, 2000)):
        await driver.reset(strobe_delay=int(random.integers(0, 60)))
        for _ in range(2):
            samples = words * driver.samples_per_word
            await driver.play(hold_steps(random.integers(0, 16, samples), random, longest)[:samples])
            await driver.check()


@cocotb.test()
async def shortest_edge_spacing_is_exact(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(7)
    for spacing in (1, 2, 3, 4, 5, 7, 8, 9, 31, 300, 2040, 2047, 2050):
        gaps = spacing + random.integers(0, 5, 3)
        gaps[random.integers(1, 3)] = spacing
        count = np.repeat(np.arange(4), np.append(gaps, 20))
        count = np.concatenate([rest(0, int(random.integers(1, 9))), count])
        await driver.reset(int(lines(0)))
        await driver.play(lines(random.choice([-1, 1]) * count))
        await driver.check()
        if spacing < 2040:
            assert driver.read("shortest_edge_spacing") == spacing
        assert bool(driver.read("flags") & Flag.EDGE_SPACING_LIMIT) == (spacing == 1)
