"""Flags: faults stay until they are cleared by command, status bits follow."""

import numpy as np
from amaranth_bench import Bench, assert_rows

from arcref.flags import FAULT_FLAGS, STATUS_FLAGS, Flag
from arcref_gateware.flag_register import FlagRegister


def run(raised, clear):
    raised, clear = np.asarray(raised), np.asarray(clear)
    rows = Bench(FlagRegister(), ["raised", "clear"], ["flags"]).run(len(raised) + 1, raised=raised, clear=clear)
    return rows["flags"][1:]


def test_random_causes_and_clears_against_bits_in_a_list(rng):
    raised = rng.integers(0, 256, 600) & rng.integers(0, 256, 600) & rng.integers(0, 256, 600)
    clear = np.where(rng.random(600) < 0.2, rng.integers(0, 256, 600), 0)
    flags, expected = [False] * 8, []
    for causes, cleared in zip(raised.tolist(), clear.tolist(), strict=True):
        for bit in range(8):
            stays = flags[bit] and not cleared >> bit & 1 and int(FAULT_FLAGS) >> bit & 1
            flags[bit] = bool(causes >> bit & 1) or stays
        expected.append(sum(flag << bit for bit, flag in enumerate(flags)))
    assert_rows("flags", run(raised, clear), np.array(expected))


def test_each_fault_stays_alone_until_its_own_bit_is_cleared():
    for flag in FAULT_FLAGS:
        others = 0xFF & ~int(flag)
        flags = run([0, flag, 0, 0, 0, 0, 0], [0, 0, 0, others, 0, flag, 0])
        assert flags.tolist() == [0, flag, flag, flag, flag, 0, 0]


def test_status_bits_follow_the_present_state_and_no_clear_touches_them():
    for flag in STATUS_FLAGS:
        assert run([flag, 0, flag, flag, 0], [0, 0, 0xFF, flag, 0]).tolist() == [flag, 0, flag, flag, 0]


def test_a_fault_raised_in_the_clock_of_its_clearing_stays():
    for flag in FAULT_FLAGS:
        assert run([flag, flag, 0, 0], [0, flag, 0, flag]).tolist() == [flag, flag, flag, 0]


def test_a_fault_that_ended_before_the_clear_does_not_come_back():
    flag = Flag.ILLEGAL_STEP
    assert run([flag, flag, 0, 0, 0], [0, 0, flag, flag, 0]).tolist() == [flag, flag, 0, 0, 0]
