"""The zero mark: the latched place is one quadrature state at any direction, width of Z and sample of a word."""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import hold_steps, lines, mark, random_walk, rest, ride

from arcref.flags import FAULT_FLAGS, Flag

MARKS = [(begin, width) for width in (1, 2, 3, 4) for begin in range(1 - width, 1)]
"""Every Z of one to four states that holds the gate state, which is count 0: its first count, and its width."""


async def home_through(driver: CoreDriver, count, begin: int, width: int) -> None:
    """Run over the mark from reset: wherever the first index came from, the core then reads the shaft's own count."""
    states = lines(count, z=mark(count, begin, width))
    await driver.reset(int(states[0]))
    await driver.play(states)
    await driver.check()
    assert driver.read("homed")
    assert driver.read("raw_position") == count[-1]
    assert driver.read("largest_closure_error") == 0
    assert not driver.read("flags") & FAULT_FLAGS & ~Flag.EDGE_SPACING_LIMIT


@cocotb.test()
async def zero_is_the_same_place_in_both_directions_at_any_width_and_sample(dut):
    driver = CoreDriver(dut)
    for begin, width in MARKS:
        for direction in (1, -1):
            for shift in range(driver.samples_per_word):
                for samples_per_count in (1, 2, 3.4):
                    start = -9 * direction
                    way = ride(start, -start, samples_per_count=samples_per_count)
                    await home_through(driver, np.concatenate([rest(start, shift + 1), way]), begin, width)


@cocotb.test()
async def reversal_at_any_phase_inside_the_mark_moves_no_zero(dut):
    driver = CoreDriver(dut)
    for begin, width in MARKS:
        for direction in (1, -1):
            for phase in range(-3, 4):
                for shift in range(driver.samples_per_word):
                    # To a phase of the mark, back out, in again to the same phase, and through to the other side.
                    targets = (phase, -8, phase, phase - 1, phase, 8, phase, 8)
                    way = ride(-8, *targets, samples_per_count=1 + (shift + phase) % 2)
                    await home_through(driver, direction * np.concatenate([rest(-8, shift + 1), way]), begin, width)


@cocotb.test()
async def shaking_inside_the_mark_moves_no_zero(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(8)
    for begin, width in MARKS:
        shake = hold_steps(random_walk(random, 0, 250), random, 2)
        shake = np.where(shake % 14 < 7, shake % 14, 14 - shake % 14) - 4
        last = int(shake[-1])
        count = np.concatenate([ride(-9, int(shake[0]), samples_per_count=1), shake, ride(last, 9, -9, 9)])
        await home_through(driver, count, begin, width)
        assert driver.read("index_count") >= 3


@cocotb.test()
async def start_inside_the_mark_homes_at_the_gate_state(dut):
    driver = CoreDriver(dut)
    for begin, width in MARKS:
        for start in range(begin, begin + width):
            for target in (9, -9):
                for pause in range(1, 2 * driver.samples_per_word + 1):
                    count = np.concatenate([rest(start, pause), ride(start, target, -target)])
                    await home_through(driver, count, begin, width)


@cocotb.test()
async def z_outside_the_gate_state_never_homes(dut):
    driver = CoreDriver(dut)
    for begin, width in ((1, 3), (-3, 3), (1, 1), (2, 1), (-1, 1)):
        count = np.concatenate([rest(-9, 5), ride(-9, 9, -9, 9, samples_per_count=1)])
        await driver.reset(int(lines(-9)))
        await driver.play(lines(count, z=mark(count, begin, width)))
        await driver.check()
        assert not driver.read("homed")
        assert driver.read("index_count") == 0
        assert driver.read("raw_position") == 18


@cocotb.test()
async def nothing_homes_again_by_itself(dut):
    driver = CoreDriver(dut)
    count = ride(-9, 900, -900, 900, samples_per_count=1)
    await driver.reset(int(lines(-9)))
    await driver.play(lines(count, z=mark(count) | mark(count, 400, 4) | mark(count, -604, 2)))
    await driver.check()
    assert driver.read("raw_position") == 900
    assert driver.read("closure_error") == 400
    assert driver.read("largest_closure_error") == -604
