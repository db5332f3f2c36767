"""Faults: each is raised in its own flag and field, and in none of another fault.

A and B show the count modulo 4, so as long as no step is illegal the core agrees with them modulo 4. A loss that leaves
no illegal step is therefore always a multiple of 4: whole periods of A and B. A slip of one count can happen only
between Z and the pair A and B; it leaves the count whole, and shows as an index that is missing.
"""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import lines, mark, rest, ride

from arcref.angle import COUNTS_PER_LINE
from arcref.flags import FAULT_FLAGS, Flag

FAR = COUNTS_PER_LINE + 8
"""Counts to go beyond the neighbourhood of the zero mark."""

FAST = {"samples_per_count": 2}
"""As fast as two edges can come without touching the limit of their spacing."""


async def faults_after(driver: CoreDriver, *parts) -> Flag:
    """Play a run, made of arrays of states, from reset; returns the fault flags that are up at its end."""
    states = np.concatenate(parts)
    await driver.reset(int(states[0]))
    await driver.play(states)
    await driver.check()
    return Flag(driver.read("flags")) & FAULT_FLAGS


def homing(end: int, direction: int = 1) -> np.ndarray:
    """States of a shaft that meets the zero mark and goes on to `end` counts in `direction`."""
    count = direction * ride(-12, end, **FAST)
    return lines(count, z=mark(count))


def fields(driver: CoreDriver) -> tuple[int, int, int, int]:
    """Illegal steps, last and largest closure error, and the count of indices."""
    names = ("illegal_steps", "closure_error", "largest_closure_error", "index_count")
    return tuple(driver.read(name) for name in names)


@cocotb.test()
async def clean_run_through_the_mark_raises_nothing(dut):
    driver = CoreDriver(dut)
    for direction in (1, -1):
        count = direction * ride(100, -FAR, FAR, -100, **FAST)
        assert await faults_after(driver, homing(100, direction), lines(count, z=mark(count))) == 0
        assert fields(driver) == (0, 0, 0, 4)


@cocotb.test()
async def slip_of_whole_periods_is_a_closure_error_of_its_size_and_nothing_else(dut):
    driver = CoreDriver(dut)
    for slip in (4, -4, 8, -400):
        for direction in (1, -1):
            # Z stays with the shaft, which has moved on by `slip` counts that A and B never showed.
            shown = direction * ride(60, 500, -500, **FAST)
            raised = await faults_after(driver, homing(60, direction), lines(shown, z=mark(shown + slip)))
            assert raised == Flag.CLOSURE_ERROR
            assert fields(driver)[:3] == (0, -slip, -slip)


@cocotb.test()
async def dropped_and_extra_periods_on_the_wire_are_closure_errors(dut):
    driver = CoreDriver(dut)
    way, back = ride(80, 120, **FAST), ride(120, -200, **FAST)
    # The wire of A is dead for one period, in which B goes up and down once: the count stays behind by 4.
    dead = ride(120, 132, **FAST)
    states = lines(dead)
    low = (dead >= 121) & (dead < 126)
    states[low] &= ~np.uint8(1)
    after = ride(132, -200, **FAST)
    raised = await faults_after(driver, homing(80), lines(way), states, lines(after, z=mark(after)))
    assert raised == Flag.CLOSURE_ERROR
    assert fields(driver) == (0, -4, -4, 2)
    # Four edges that the shaft did not make.
    extra = ride(120, 124, **FAST)
    raised = await faults_after(driver, homing(80), lines(way), lines(extra), lines(back + 4, z=mark(back)))
    assert raised == Flag.CLOSURE_ERROR
    assert fields(driver) == (0, 4, 4, 2)


@cocotb.test()
async def slip_of_one_count_is_a_missing_index(dut):
    driver = CoreDriver(dut)
    for slip in (1, -1):
        # With Z one state wide, Z and the gate state no longer meet. A wider Z still holds the gate state: no fault.
        for width, expected in ((1, Flag.INDEX_FAULT), (3, Flag(0))):
            shown = ride(60, FAR, -FAR, **FAST)
            z = mark(shown + slip, -(width // 2), width)
            assert await faults_after(driver, homing(60), lines(shown, z=z)) == expected
            assert fields(driver) == (0, 0, 0, 2 if width > 1 else 1)


@cocotb.test()
async def missing_zero_mark_is_an_index_fault_and_nothing_else(dut):
    driver = CoreDriver(dut)
    for direction in (1, -1):
        away = direction * ride(20, FAR, **FAST)
        back = direction * ride(FAR, -COUNTS_PER_LINE, **FAST)
        beyond = direction * ride(-COUNTS_PER_LINE, -COUNTS_PER_LINE - 1, **FAST)
        assert await faults_after(driver, homing(20, direction), lines(away), lines(back)) == 0
        await driver.play(lines(beyond))
        await driver.check()
        assert Flag(driver.read("flags")) & FAULT_FLAGS == Flag.INDEX_FAULT
        assert fields(driver) == (0, 0, 0, 1)


@cocotb.test()
async def turning_back_before_the_mark_is_no_missing_index(dut):
    driver = CoreDriver(dut)
    for direction in (1, -1):
        count = direction * ride(20, FAR, 3, FAR, **FAST)
        assert await faults_after(driver, homing(20, direction), lines(count)) == 0


@cocotb.test()
async def second_zero_mark_near_is_a_closure_error_of_its_distance(dut):
    driver = CoreDriver(dut)
    for place in (4, 40, -40, 2044, COUNTS_PER_LINE, -COUNTS_PER_LINE):
        count = ride(20, -20, place, place + np.sign(place) * 3, **FAST)
        raised = await faults_after(driver, homing(20), lines(count, z=mark(count) | mark(count, place)))
        assert raised == Flag.CLOSURE_ERROR
        assert fields(driver)[:3] == (0, place, place)


@cocotb.test()
async def second_zero_mark_far_is_an_index_fault_and_leaves_the_closure_error_alone(dut):
    driver = CoreDriver(dut)
    for place in (COUNTS_PER_LINE + 4, -COUNTS_PER_LINE - 4, 3000):
        count = ride(20, -20, 40, -60, place, place + np.sign(place) * 3, **FAST)
        indices = mark(count) | mark(count, place)
        raised = await faults_after(driver, homing(20), lines(count, z=indices))
        assert raised == Flag.INDEX_FAULT
        assert fields(driver)[:3] == (0, 0, 0)


@cocotb.test()
async def double_transition_there_and_back_is_two_illegal_steps_and_nothing_else(dut):
    driver = CoreDriver(dut)
    for duration in (1, 2, 3, 9):
        count = ride(60, -60, samples_per_count=24)
        states = lines(count, z=mark(count))
        begin = np.flatnonzero(count == 30)[4]
        states[begin : begin + duration] ^= 3
        assert await faults_after(driver, homing(60), states) == Flag.ILLEGAL_STEP
        assert fields(driver) == (2, 0, 0, 2)


@cocotb.test()
async def net_double_transition_is_an_illegal_step_then_a_closure_error_of_two(dut):
    driver = CoreDriver(dut)
    for jump in (2, -2):
        before, after = ride(60, 40, **FAST), ride(40 + jump, -60, **FAST)
        parts = homing(60), lines(before), lines(rest(40 + jump, 4))
        assert await faults_after(driver, *parts) == Flag.ILLEGAL_STEP
        assert await faults_after(driver, *parts, lines(after, z=mark(after))) == Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR
        assert fields(driver) == (1, -jump, -jump, 2)


@cocotb.test()
async def last_and_largest_closure_error_keep_their_signs(dut):
    driver = CoreDriver(dut)
    # The mark stands at another place each time the shaft comes by.
    ends = (60, -60, 60, -60, 60)
    legs = [ride(*ends[i : i + 2], **FAST) for i in range(4)]
    passes = [lines(leg, z=mark(leg, place)) for leg, place in zip(legs, (8, -20, 12, 4), strict=True)]
    assert await faults_after(driver, homing(60), *passes) == Flag.CLOSURE_ERROR
    assert fields(driver) == (0, 4, -20, 5)
