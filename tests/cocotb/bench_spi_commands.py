"""Commands over SPI: a whole and right command clears flags, also while their cause is there, and nothing else does."""

import cocotb
import numpy as np
from asynchronous_spi import FASTEST_PERIOD_PS, SpiController, assert_frame_of_a_word, play_beside, wait_ps
from core_driver import CLOCK_PERIOD_PS, CoreDriver
from stimulus import lines, mark, rest, ride, strobes

from arcref.flags import FAULT_FLAGS, Flag
from arcref.position_frame import COMMAND_CLEAR_FLAGS, crc8_autosar, encode_clear_flags

RAISED = FAULT_FLAGS & ~Flag.ROM_FAULT
"""Every fault that the lines can raise."""


async def raise_all_faults(driver: CoreDriver) -> None:
    """From reset, bring every fault flag up that the lines can raise."""
    spacing = max(driver.samples_per_word, 2)
    count = np.concatenate([rest(-9, 9), ride(-9, 2100, -8, samples_per_count=1)])
    z = mark(count) | mark(count, 2052) | mark(count, 40)
    strobe = strobes(len(count), [19 + spacing * number for number in range(20)])
    states = lines(count, z=z, strobe=strobe)
    states[4] ^= 3
    await driver.reset(int(lines(-9)), strobe_delay=1000)
    await driver.play(states)
    await driver.check()
    assert Flag(driver.read("flags")) & FAULT_FLAGS == RAISED


def at_rest(driver: CoreDriver):
    """Pieces of a shaft that stands still where `raise_all_faults` left it."""
    while True:
        yield np.full(32 * driver.samples_per_word, driver.samples[-1])


def faults(driver: CoreDriver) -> Flag:
    return Flag(driver.read("flags")) & FAULT_FLAGS


async def send(driver: CoreDriver, data: bytes, bits: int = 64, **more):
    """Send one frame while the shaft rests, and let it act; returns the transfer."""

    async def sending():
        transfer = await SpiController(driver.dut).transfer(data, bits, **more)
        await wait_ps(12 * CLOCK_PERIOD_PS)
        return transfer

    transfer = await play_beside(driver, sending(), at_rest(driver))
    await driver.check(flags=False)
    return transfer


def framed(*payload: int) -> bytes:
    """Seven bytes and their CRC."""
    return bytes(payload) + bytes([crc8_autosar(bytes(payload))])


@cocotb.test()
async def command_clears_the_flags_of_its_mask_and_no_other(dut):
    driver = CoreDriver(dut)
    await raise_all_faults(driver)
    left = RAISED
    before = {name: driver.read(name) for name in ("illegal_steps", "closure_error", "index_count", "raw_position")}
    for number, flag in enumerate(Flag):
        transfer = await send(driver, encode_clear_flags(flag))
        assert_frame_of_a_word(driver, transfer, number)
        left &= ~flag
        assert faults(driver) == left
    assert {name: driver.read(name) for name in before} == before
    await raise_all_faults(driver)
    await send(driver, encode_clear_flags(0xFF))
    assert faults(driver) == 0


@cocotb.test()
async def clearing_starts_the_search_for_the_extremes_again(dut):
    driver = CoreDriver(dut)
    await raise_all_faults(driver)
    await send(driver, encode_clear_flags(FAULT_FLAGS & ~Flag.CLOSURE_ERROR & ~Flag.EDGE_SPACING_LIMIT))
    assert driver.read("shortest_edge_spacing") == 1
    assert driver.read("largest_closure_error") == 40
    await send(driver, encode_clear_flags(Flag.CLOSURE_ERROR | Flag.EDGE_SPACING_LIMIT))
    assert driver.read("shortest_edge_spacing") > 1000
    assert driver.read("largest_closure_error") == 0
    await driver.play(lines(ride(-8, 30, samples_per_count=3)))
    await driver.check(flags=False)
    assert driver.read("shortest_edge_spacing") == 3


@cocotb.test()
async def flag_is_up_again_while_its_cause_is_there_and_down_when_it_is_gone(dut):
    driver = CoreDriver(dut)
    await driver.reset(0)

    def shaken():
        while True:
            yield np.arange(32 * driver.samples_per_word) % 2 * 3

    async def commanding():
        for _ in range(3):
            await SpiController(dut).transfer(encode_clear_flags(0xFF))
            await wait_ps(12 * CLOCK_PERIOD_PS)
            assert faults(driver) == Flag.ILLEGAL_STEP

    await play_beside(driver, commanding(), shaken())
    await driver.check()
    await send(driver, encode_clear_flags(0xFF))
    assert faults(driver) == 0
    assert driver.read("illegal_steps") > 0


@cocotb.test()
async def fault_at_any_clock_about_a_clearing_is_not_lost(dut):
    driver = CoreDriver(dut)
    words = driver.samples_per_word
    too_many = [5 + max(words, 2) * number for number in range(20)]
    kept = set()
    for clocks in range(496, 524):
        # Too many strobes: a fault that does not come again, so its fall tells when the clearing was.
        await driver.reset(0, strobe_delay=1000)
        await driver.play(lines(rest(2, 60 * words), strobe=strobes(60 * words, too_many)))
        await driver.play(np.full(12 * words, 3))
        clearing = cocotb.start_soon(SpiController(dut).transfer(encode_clear_flags(0xFF)))
        await driver.play(np.full(clocks * words, 3))
        await driver.play(np.full(60 * words, 0))
        await clearing
        flags, steps = driver.per_word("flags"), driver.per_word("illegal_steps")
        fault = int(np.flatnonzero(np.diff(steps))[-1]) + 1
        cleared = int(np.flatnonzero(flags & Flag.CAPTURE_OVERRUN)[-1]) + 1
        assert np.all(flags[fault:cleared] & Flag.ILLEGAL_STEP)
        assert np.all((flags[max(fault, cleared) :] & Flag.ILLEGAL_STEP != 0) == (cleared <= fault))
        kept.add(np.sign(cleared - fault))
    assert kept == {-1, 0, 1}


@cocotb.test()
async def wrong_or_cut_commands_clear_nothing(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(22)
    await raise_all_faults(driver)
    right = encode_clear_flags(0xFF)
    wrong = [(int.from_bytes(right, "big") ^ 1 << bit).to_bytes(8, "big") for bit in range(64)]
    wrong += [bytes(random.bytes(8)) for _ in range(8)] + [bytes(8), bytes([0xFF] * 8)]
    wrong += [framed(COMMAND_CLEAR_FLAGS, 0xFF, *(int(place == i) for place in range(5))) for i in range(5)]
    wrong += [framed(command, 0xFF, 0, 0, 0, 0, 0) for command in (0, 0xC0, 0xFF, 0x41, 0xC3)]
    for data in wrong:
        await send(driver, data)
        assert faults(driver) == RAISED, data.hex()
    for bits in (1, 8, 16, 56, 63, 65, 72, 128):
        await send(driver, right * 2, bits)
        await send(driver, right * 2, min(bits, 63), cut_ps=int(random.integers(0, FASTEST_PERIOD_PS)))
        assert faults(driver) == RAISED
    await send(driver, right)
    assert faults(driver) == 0


@cocotb.test()
async def command_acts_with_the_shortest_gap_to_the_next_frame(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(23)
    for place in range(12):
        await raise_all_faults(driver)

        async def pair(place=place):
            await wait_ps(place * CLOCK_PERIOD_PS // 12 + 1)
            spi = SpiController(dut)
            await spi.transfer(encode_clear_flags(Flag.ILLEGAL_STEP))
            await spi.transfer(bytes(random.bytes(8)))
            return await spi.transfer(bytes(8))

        transfer = await play_beside(driver, pair(), at_rest(driver))
        assert transfer.frame.flags & FAULT_FLAGS == RAISED & ~Flag.ILLEGAL_STEP


@cocotb.test()
async def reading_clears_nothing(dut):
    driver = CoreDriver(dut)
    await raise_all_faults(driver)
    names = ("illegal_steps", "closure_error", "largest_closure_error", "index_count", "shortest_edge_spacing")
    before = [driver.read(name) for name in names]
    for data in (bytes(8), bytes([0xFF] * 8), bytes([0xAA] * 8)):
        for bits in (64, 24, 32, 7):
            await send(driver, data, bits)
            assert faults(driver) == RAISED
            assert [driver.read(name) for name in names] == before
    await driver.check()
