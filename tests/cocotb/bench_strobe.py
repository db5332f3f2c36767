"""The strobe: it captures the position at its due sample, at any speed and delay, and never a wrong one."""

import cocotb
import numpy as np
from core_driver import CoreDriver
from stimulus import hold_steps, lines, mark, random_walk, rest, ride, strobes

from arcref.flags import FAULT_FLAGS, Flag
from arcref_gateware.pending_strobes import PENDING_STROBES
from arcref_gateware.strobe_delay import STROBE_DELAY_BITS

LONGEST_DELAY = (1 << STROBE_DELAY_BITS) - 1


def delays(samples_per_word: int) -> list[int]:
    """Delays at the borders of words, of the short chain and of the strobes that wait."""
    borders = [words * samples_per_word + more for words in (0, 1, 2, 3, 4, 5, 6, 7, 9, 40) for more in (-1, 0, 1)]
    return sorted({delay for delay in borders if delay >= 0} | {2, 3, 250, 1000})


async def capture_truly(driver: CoreDriver, count, rises, delay: int, *, start: int = -40) -> None:
    """Home, then run through `count` with strobes at its samples `rises`: each is captured at its due sample."""
    homing = np.concatenate([rest(start, 5), ride(start, 3, int(count[0]), samples_per_count=1)])
    begin = len(homing)
    true = np.concatenate([homing, count, rest(int(count[-1]), delay + driver.samples_per_word)])
    states = lines(true, z=mark(true), strobe=strobes(len(true), begin + np.asarray(rises)))
    await driver.reset(int(states[0]), strobe_delay=delay)
    await driver.play(states)
    await driver.check()
    captured = driver.captured()
    assert list(captured["capture_time"]) == [begin + rise + delay for rise in rises]
    assert np.array_equal(captured["capture_raw"], true[captured["capture_time"]])
    assert not driver.read("flags") & FAULT_FLAGS & ~Flag.EDGE_SPACING_LIMIT


def spread(random, samples: int, least: int, most: int) -> list[int]:
    """Samples of strobes, `least` to `most` apart, in `samples` samples."""
    places = np.cumsum(random.integers(least, most, samples // least, endpoint=True))
    return places[places < samples].tolist()


@cocotb.test()
async def position_at_the_due_sample_is_captured_at_every_speed_and_delay(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(9)
    speeds = (0, 1, 1.5, 2, 3.7, 60)
    for number, delay in enumerate(delays(driver.samples_per_word)):
        samples_per_count = speeds[number % len(speeds)]
        direction = 1 - 2 * (number // len(speeds) % 2)
        count = ride(0, 700, samples_per_count=samples_per_count)[:700] if samples_per_count else rest(5, 700)
        # No more wait at once than may.
        least = max(2 * driver.samples_per_word, delay // 14 + 1)
        rises = spread(random, len(count), least, least + 30) or [3]
        await capture_truly(driver, direction * count, rises, delay, start=-40 * direction)


@cocotb.test()
async def strobe_before_a_reset_leaves_no_trace_in_the_one_after(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    for delay in (5 * words, 12 * words + 1):
        for rise in range(1, 2 * delay + 10):
            for first in (2, rise):
                true = ride(-1, rise + 2 * delay, samples_per_count=1)
                await driver.reset(int(lines(-1)), strobe_delay=delay)
                await driver.play(lines(true[: first + 8 * words], strobe=strobes(first + 8 * words, [first])))
            await driver.check()
            await driver.reset(int(lines(-1)), strobe_delay=delay)
            await driver.play(lines(true, strobe=strobes(len(true), [rise])))
            await driver.check()
            assert list(driver.captured()["capture_time"]) == [rise + delay]


@cocotb.test()
async def slot_is_used_again_after_the_word_counter_has_gone_round(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    delay = 20 * words
    # A waiting strobe is known by the low bits of its word, which come again this much later, in the same slot.
    period = 1 << STROBE_DELAY_BITS
    early = [words * (10 + 30 * slot) for slot in range(PENDING_STROBES)]
    late = [rise + period + words * (20 - slot) for slot, rise in enumerate(early)]
    true = np.concatenate([ride(0, 600 * words), rest(600 * words, period - 900 * words), ride(600 * words, 5, 900)])
    await driver.reset(int(lines(0)), strobe_delay=delay)
    await driver.play(lines(true, strobe=strobes(len(true), early + late)))
    await driver.check()
    assert list(driver.captured()["capture_time"]) == [rise + delay for rise in early + late]


@cocotb.test()
async def one_strobe_a_word_is_captured_in_bursts(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(10)
    words = driver.samples_per_word
    # A strobe needs a low sample before it: with one sample a word, every second word is the most there can be.
    spacing = max(words, 2)
    for delay in range(5 * words):
        for place in range(words):
            count = random_walk(random, 3, 60 * words, (0.2, 0.1, 0.7))
            rises = [place + 1 + spacing * i for i in range(40 * words // spacing)]
            await capture_truly(driver, count, rises, delay)


@cocotb.test()
async def sixteen_strobes_wait_and_one_more_is_refused(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    for delay in (40 * words, 40 * words + 1, 300):
        for number in (PENDING_STROBES, PENDING_STROBES + 1, PENDING_STROBES + 3):
            true = ride(-3, 500, samples_per_count=1.5)
            spacing = max(words, 2)
            rises = [60 + words + spacing * i for i in range(number)]
            await driver.reset(int(lines(-3)), strobe_delay=delay)
            await driver.play(lines(true, z=mark(true), strobe=strobes(len(true), rises)))
            await driver.check()
            captured = driver.captured()
            assert list(captured["capture_time"]) == [rise + delay for rise in rises[:PENDING_STROBES]]
            assert np.array_equal(captured["capture_raw"], true[captured["capture_time"]])
            refused = bool(driver.read("flags") & Flag.CAPTURE_OVERRUN)
            assert refused == (number > PENDING_STROBES)


@cocotb.test()
async def strobes_closer_than_the_delay_are_all_captured_while_sixteen_wait(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(11)
    for delay in (160, 333):
        # Always 15 or 16 on the way: slots are used again as soon as they are free.
        count = hold_steps(random_walk(random, 3, 3000, (0.3, 0.1, 0.6)), random, 2)
        room = 3 * driver.samples_per_word
        rises = list(range(5, len(count), -(-(delay + room) // PENDING_STROBES)))
        await capture_truly(driver, count, rises, delay)


@cocotb.test()
async def two_strobes_due_in_one_word_raise_overrun_and_capture_the_first(dut):
    driver = CoreDriver(dut)
    if driver.samples_per_word < 4:
        return  # two rising edges need a low sample between them, so they do not fit in a word of two
    for delay in (0, 3, 18, 50):
        shift = -delay % 4
        true = ride(-3, 300, samples_per_count=1)
        rises = [80 + shift, 82 + shift]
        await driver.reset(int(lines(-3)), strobe_delay=delay)
        await driver.play(lines(true, z=mark(true), strobe=strobes(len(true), rises)))
        await driver.check()
        assert list(driver.captured()["capture_time"]) == [rises[0] + delay]
        assert driver.read("flags") & Flag.CAPTURE_OVERRUN


@cocotb.test()
async def any_strobes_whatever_are_captured_as_the_golden_model_says(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(12)
    for delay in (0, 1, 5, 18, 21, 64, 400):
        for chance in (0.02, 0.5):
            true = random_walk(random, 0, 1200 * driver.samples_per_word, (0.2, 0.1, 0.7))
            strobe = random.random(len(true)) < chance
            await driver.reset(int(lines(0)), strobe_delay=delay)
            await driver.play(lines(true, z=mark(true, 40, 2), strobe=strobe))
            await driver.check()
            captured = driver.captured()
            homed = driver.per_word("homed")[captured["word"]].astype(bool)
            assert np.all(strobe[captured["capture_time"] - delay])
            position = true[np.minimum(captured["capture_time"], len(true) - 1)]
            assert np.array_equal(captured["capture_raw"], np.where(homed, position - 40, position - true[0]))


@cocotb.test()
async def longest_delays_capture_the_position_then(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(13)
    for delay in (LONGEST_DELAY, LONGEST_DELAY - driver.samples_per_word)[: driver.samples_per_word]:
        rises = sorted(random.choice(np.arange(100, 900, 5), PENDING_STROBES, replace=False).tolist())
        # The shaft homes, stands still through all the strobes, and moves again as they fall due.
        homing = np.concatenate([rest(-40, 5), ride(-40, 3, 30, samples_per_count=1)])
        true = np.concatenate([homing, rest(30, delay - len(homing)), ride(30, 1000, samples_per_count=1)])
        states = lines(true, z=mark(true), strobe=strobes(len(true), rises))
        await driver.reset(int(states[0]), strobe_delay=delay)
        await driver.play(states)
        await driver.check()
        captured = driver.captured()
        assert list(captured["capture_time"]) == [rise + delay for rise in rises]
        assert np.array_equal(captured["capture_raw"], true[captured["capture_time"]])
        assert len(set(captured["capture_raw"])) == PENDING_STROBES
        assert not driver.read("flags") & Flag.CAPTURE_OVERRUN


@cocotb.test()
async def delay_may_be_changed_while_no_strobe_waits(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(14)
    await driver.reset(int(lines(0)))
    played, expected = 0, []
    for delay in (0, 33, 1, 250, 7, 64, 0):
        dut.strobe_delay.value = delay
        driver.model.strobes.delay = delay
        count = played + ride(0, 400, samples_per_count=1)
        rises = spread(random, 100, max(2 * driver.samples_per_word, delay // 14 + 1), 40)
        await driver.play(lines(count, strobe=strobes(len(count), [20 + rise for rise in rises])))
        expected += [played + 20 + rise + delay for rise in rises]
        await driver.check()
        played = len(driver.samples)
        assert list(driver.captured()["capture_time"]) == expected
