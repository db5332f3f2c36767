"""Too fast for the samples: the edge-spacing flag is up before the first count is lost, and the loss is flagged."""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import SAMPLE_NS, SAMPLE_S, encoder_run

from arcref.flags import Flag
from arcref_sim.motion import Motion
from arcref_sim.square_waves import SquareWaves

WORDS = 6000


def first_word(flags: np.ndarray, flag: Flag) -> int:
    """The first word that shows `flag`; one past the end when none does."""
    up = np.flatnonzero(flags & flag)
    return int(up[0]) if len(up) else len(flags)


async def run_until_loss(driver: CoreDriver, states, count) -> tuple[int, int, int]:
    """Play a run; returns the words of the edge-spacing flag, the first false position and the illegal-step flag."""
    await driver.reset(int(states[0]))
    await driver.play(states)
    await driver.check()
    shown, flags = driver.per_word("raw_position"), driver.per_word("flags")
    true = (count - count[0])[driver.samples_per_word - 1 :: driver.samples_per_word][: len(shown)]
    false = np.flatnonzero(shown[: len(true)] != true)
    assert len(false), "nothing was lost: the run is not fast enough to show anything"
    return first_word(flags, Flag.EDGE_SPACING_LIMIT), int(false[0]), first_word(flags, Flag.ILLEGAL_STEP)


@cocotb.test()
async def ramp_beyond_three_counts_a_sample_is_flagged_before_and_as_counts_are_lost(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    for from_speed, to_speed in ((0.0, 3.6), (0.0, -3.6), (0.4, 3.2), (-0.95, -5.0)):
        # Far from the zero mark, so that flags of the index have no part in it.
        motion = Motion(1e6).ramp(to_speed, duration_s, from_speed_rps=from_speed)
        limit, lost, illegal = await run_until_loss(driver, *encoder_run(motion))
        assert limit < lost
        assert illegal <= lost
        assert driver.read("illegal_steps") > 0


@cocotb.test()
async def ramp_with_jitter_is_flagged_before_and_as_counts_are_lost(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    waves = SquareWaves(jitter_ns=0.05 * SAMPLE_NS)
    for seed in range(3):
        motion = Motion(1e6).ramp(3.5, duration_s, from_speed_rps=0.2)
        limit, lost, illegal = await run_until_loss(driver, *encoder_run(motion, waves=waves, seed=seed))
        assert limit < lost
        assert illegal <= lost


@cocotb.test()
async def flags_stay_up_when_the_speed_is_low_again(dut):
    driver = CoreDriver(dut)
    quarter_s = WORDS * driver.samples_per_word * SAMPLE_S / 4
    motion = Motion(1e6).ramp(3.5, quarter_s).ramp(0.0, quarter_s).constant_speed(0.1, quarter_s)
    await run_until_loss(driver, *encoder_run(motion))
    assert driver.read("flags") & Flag.EDGE_SPACING_LIMIT
    assert driver.read("flags") & Flag.ILLEGAL_STEP
    assert driver.read("shortest_edge_spacing") == 1


@cocotb.test()
async def speeds_that_the_samples_carry_with_margin_raise_nothing(dut):
    driver = CoreDriver(dut)
    duration_s = WORDS * driver.samples_per_word * SAMPLE_S
    for speed in (0.1, 0.333, 0.5, -0.5):
        states, _ = encoder_run(Motion(1e6).constant_speed(speed, duration_s))
        await driver.reset(int(states[0]))
        await driver.play(states)
        await driver.check()
        assert not driver.per_word("flags").max() & ~(Flag.LAST_DIRECTION_REVERSE | Flag.CORRECTION_ACTIVE)
        assert driver.read("shortest_edge_spacing") == int(1 / abs(speed))


@cocotb.test()
async def illegal_steps_are_each_counted_and_stop_at_the_top(dut):
    driver = CoreDriver(dut)
    # Every sample changes both lines: nothing is counted, not even in a remembered direction.
    samples = 66_000 if driver.samples_per_word > 1 else 3_000
    await driver.reset(0)
    await driver.play(np.arange(samples) % 2 * 3)
    await driver.check()
    assert driver.read("illegal_steps") == min(samples - 1, 0xFFFF)
    assert not driver.positions
