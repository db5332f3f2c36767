"""The comparison itself: a core that differed from the golden model in one entry of any record would be noticed."""

import cocotb
import pytest
from core_driver import CoreDriver
from stimulus import lines, mark, ride, strobes


async def short_run(driver: CoreDriver) -> None:
    """A run with positions, states and captures, not compared yet."""
    count = ride(-40, 60, -60, samples_per_count=1)
    states = lines(count, z=mark(count), strobe=strobes(len(count), range(20, 200, 20)))
    await driver.reset(int(states[0]), strobe_delay=3)
    await driver.play(states)


@cocotb.test()
async def one_wrong_value_in_any_record_is_noticed(dut):
    driver = CoreDriver(dut)
    for record in ("positions", "status", "captures"):
        for field in (0, 1):  # the word, and the first of its values
            await short_run(driver)
            await driver.check()
            entry = list(getattr(driver, record)[2])
            entry[field] += 1
            getattr(driver, record)[2] = tuple(entry)
            with pytest.raises(AssertionError, match=record):
                await driver.check()


@cocotb.test()
async def one_missing_or_extra_entry_in_any_record_is_noticed(dut):
    driver = CoreDriver(dut)
    for record in ("positions", "status", "captures"):
        for change in (lambda entries: entries.pop(), lambda entries: entries.append(entries[-1])):
            await short_run(driver)
            change(getattr(driver, record))
            with pytest.raises(AssertionError, match=record):
                await driver.check()


@cocotb.test()
async def one_sample_that_the_model_sees_otherwise_is_noticed(dut):
    driver = CoreDriver(dut)
    for sample in (30, 77, 150):
        await short_run(driver)
        driver.samples[sample] ^= 1
        with pytest.raises(AssertionError, match="positions"):
            await driver.check()
