"""The correction: at every word, across the turn's seam too, the position is `CorrectionRom.correct` of the raw one."""

import cocotb
import numpy as np
from core_driver import ROM, CoreDriver
from stimulus import hold_steps, lines, mark, random_walk, rest, ride

from arcref.angle import ANGLE_BITS, COUNTS_PER_LINE
from arcref.flags import Flag
from arcref_gateware.latency import FIRST_CORRECTED_WORD


async def corrected_run(driver: CoreDriver, count, *, z=None) -> np.ndarray:
    """Play a run from reset and compare every word with the ROM; returns the raw positions of the corrected words."""
    states = lines(count, z=mark(count) if z is None else z)
    await driver.reset(int(states[0]))
    await driver.play(states)
    await driver.check()
    raw, position = driver.per_word("raw_position"), driver.per_word("position")
    active = driver.per_word("homed").astype(bool) & (np.arange(len(raw)) >= FIRST_CORRECTED_WORD)
    assert np.array_equal(position[active], ROM.correct(raw[active]))
    assert np.array_equal(position[~active], raw[~active])
    assert np.array_equal(active, driver.per_word("flags") & Flag.CORRECTION_ACTIVE != 0)
    assert np.array_equal(raw[active] >> ANGLE_BITS, count_turns(raw[active]))
    assert active.any()
    return raw[active]


def count_turns(raw) -> np.ndarray:
    """Turns of positions near the first zero mark."""
    return np.where(raw < 0, -1, 0)


def until_checked(driver: CoreDriver, count: int) -> np.ndarray:
    """A shaft that waits at `count` until the tables were checked."""
    return rest(count, (FIRST_CORRECTED_WORD + 3) * driver.samples_per_word)


@cocotb.test()
async def every_word_is_corrected_across_the_seam(dut):
    driver = CoreDriver(dut)
    for samples_per_count in (1, 1.5, 3):
        way = 1200 * driver.samples_per_word // samples_per_count // 2
        there_and_back = ride(-5, int(way), -int(way), int(way), samples_per_count=samples_per_count)
        raw = await corrected_run(driver, np.concatenate([until_checked(driver, -5), there_and_back]))
        assert raw.min() < 0 < raw.max()


@cocotb.test()
async def all_cells_of_many_lines_are_corrected_at_the_highest_speed(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    far = 9000 * words // 3
    count = np.concatenate([until_checked(driver, -3), ride(-3, far, -far // 2, samples_per_count=1)])
    raw = await corrected_run(driver, count)
    assert len(np.unique(raw // COUNTS_PER_LINE)) >= 2 * words


@cocotb.test()
async def each_border_of_a_cell_is_met_at_each_sample_of_a_word(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    ways = []
    for samples_per_count in (1, 2, 1.25):
        for shift in range(words):
            ways += [rest(-2, shift), ride(-2, 22, -26, -2, samples_per_count=samples_per_count)]
    count = np.concatenate([ride(-12, 5, -2), until_checked(driver, -2), *ways])
    await corrected_run(driver, count)


@cocotb.test()
async def shaking_about_a_cell_border_is_corrected(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(15)
    ways = [until_checked(driver, 0)]
    for _ in range(6):
        shake = hold_steps(random_walk(random, 0, 500 * driver.samples_per_word, (0.4, 0.2, 0.4)), random, 2)
        ways.append(np.concatenate([shake, ride(int(shake[-1]), 0, samples_per_count=1)]))
    count = np.concatenate([ride(-12, 5, 0), *ways])
    await corrected_run(driver, count)


@cocotb.test()
async def correction_begins_with_the_home_word_once_the_tables_are_checked(dut):
    driver = CoreDriver(dut)
    for shift in range(2 * driver.samples_per_word):
        before = until_checked(driver, -60)[: -2 * driver.samples_per_word + shift]
        count = np.concatenate([before, ride(-60, 60, -60, samples_per_count=1)])
        raw = await corrected_run(driver, count)
        assert abs(raw[0]) <= driver.samples_per_word


@cocotb.test()
async def correction_begins_on_the_promised_word_when_homed_before(dut):
    driver = CoreDriver(dut)
    for samples_per_count in (1, 3):
        way = FIRST_CORRECTED_WORD * driver.samples_per_word + 400
        count = ride(-60, -60 + int(way / samples_per_count), samples_per_count=samples_per_count)
        await corrected_run(driver, count)
