"""The SPI port: every frame is whole and holds one word's state, at any clock, phase and gap, and after any abort."""

from dataclasses import replace

import cocotb
import numpy as np
from asynchronous_spi import FASTEST_PERIOD_PS, SpiController, assert_frame_of_a_word, play_beside, wait_ps
from core_driver import CLOCK_PERIOD_PS, CoreDriver
from stimulus import lines, mark, random_walk, rest

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.position_frame import FRAME_BITS, decode_short
from arcref_gateware.position_spi import LOWEST_CLOCK_RATIO


def moving(driver: CoreDriver, random, chances=(0.1, 0.1, 0.8), start: int = -30):
    """Pieces of an endless motion that homes soon, and goes to and fro over the turn's seam."""
    count = start
    while True:
        walk = random_walk(random, count, 64 * driver.samples_per_word, chances)
        count = int(walk[-1])
        yield lines(walk, z=mark(walk))
        chances = chances[::-1] if abs(count) > 300 and (count > 0) == (chances[2] > chances[0]) else chances


async def read_frames(driver: CoreDriver, spi: SpiController, random, number: int, *, longest_gap_ps: int = 0) -> list:
    """Read `number` whole frames with random gaps; returns the transfers."""
    transfers = []
    for _ in range(number):
        await wait_ps(int(random.integers(0, longest_gap_ps, endpoint=True)))
        transfers.append(await spi.transfer(bytes(random.bytes(8)), lead_ps=int(random.integers(0, 9000))))
    return transfers


@cocotb.test()
async def frames_hold_one_words_state_at_every_clock_and_phase(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(16)
    assert FASTEST_PERIOD_PS == LOWEST_CLOCK_RATIO * CLOCK_PERIOD_PS
    for ratio in (8, 8.001, 8.37, 9, 10.5, 16, 33.3, 150):
        await driver.reset(int(lines(-30)))
        spi = SpiController(dut, int(ratio * CLOCK_PERIOD_PS))
        frames = 14 if ratio < 20 else 2
        reading = read_frames(driver, spi, random, frames, longest_gap_ps=5 * CLOCK_PERIOD_PS)
        transfers = await play_beside(driver, reading, moving(driver, random))
        await driver.check()
        for number, transfer in enumerate(transfers):
            assert_frame_of_a_word(driver, transfer, number)
    assert any(transfer.frame.homed for transfer in transfers)


@cocotb.test()
async def frames_are_corrected_and_count_turns_across_the_seam(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(17)
    await driver.reset(int(lines(-30)))
    homing = np.concatenate([np.arange(-30, 20), rest(20, 10500 * driver.samples_per_word)])
    await driver.play(lines(homing, z=mark(homing)))
    reading = read_frames(driver, SpiController(dut), random, 30, longest_gap_ps=3 * CLOCK_PERIOD_PS)
    transfers = await play_beside(driver, reading, moving(driver, random, (0.0, 0.3, 0.7), start=20))
    await driver.check()
    for number, transfer in enumerate(transfers):
        assert_frame_of_a_word(driver, transfer, number)
    assert all(transfer.frame.flags & Flag.CORRECTION_ACTIVE for transfer in transfers)


@cocotb.test()
async def back_to_back_frames_are_whole_and_the_counter_goes_round(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(18)
    await driver.reset(int(lines(-30)))

    async def empty_frames():
        # Frames without a clock are frames, too: they bring the counter near its end.
        for _ in range(250):
            await SpiController(dut).transfer(bits=0, lead_ps=int(random.integers(0, 8000)))
        return await read_frames(driver, SpiController(dut), random, 12)

    transfers = await play_beside(driver, empty_frames(), moving(driver, random))
    await driver.check()
    for number, transfer in enumerate(transfers):
        assert_frame_of_a_word(driver, transfer, 250 + number)
    assert [transfer.frame.frame_counter for transfer in transfers][5:8] == [255, 0, 1]


@cocotb.test()
async def abort_at_any_bit_leaves_the_next_frame_whole(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(19)
    await driver.reset(int(lines(-30)))

    async def reading():
        transfers = []
        for bits in random.permutation(np.append(np.arange(FRAME_BITS + 1), [65, 70, 200])).tolist():
            spi = SpiController(dut, FASTEST_PERIOD_PS + int(random.integers(0, 9000)))
            cut_ps = int(random.integers(0, spi.period_ps))
            await spi.transfer(bytes(random.bytes(8)), bits, cut_ps=cut_ps)
            transfers.append(await spi.transfer(bytes(random.bytes(8)), lead_ps=int(random.integers(0, 8000))))
        return transfers

    transfers = await play_beside(driver, reading(), moving(driver, random))
    await driver.check()
    for number, transfer in enumerate(transfers):
        assert_frame_of_a_word(driver, transfer, 2 * number + 1)


@cocotb.test()
async def short_frames_of_24_and_32_bits_hold_the_same_state(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(20)
    await driver.reset(int(lines(-30)))
    await driver.play(lines(np.arange(-30, 30 * driver.samples_per_word)))

    async def reading():
        return [await SpiController(dut).transfer(bits=24 + 8 * (number % 2)) for number in range(12)]

    transfers = await play_beside(driver, reading(), moving(driver, random))
    await driver.check()
    for transfer in transfers:
        frame = decode_short(transfer.data)
        words = driver.words_shown_after(transfer.selected_ps)
        angle, homed, flags = (driver.per_word(name)[words] for name in ("position", "homed", "flags"))
        shown = list(zip(angle % COUNTS_PER_TURN, homed, flags, strict=True))
        assert (frame.angle, frame.homed) in [entry[:2] for entry in shown]
        assert frame.flags is None or (frame.angle, frame.homed, frame.flags) in shown


@cocotb.test()
async def output_is_zero_after_the_last_bit_and_between_frames(dut):
    driver = CoreDriver(dut)
    random = np.random.default_rng(21)
    await driver.reset(int(lines(-30)))

    async def reading():
        transfers = []
        for _ in range(4):
            transfers.append(await SpiController(dut).transfer(bytes([0xFF] * 16), FRAME_BITS + 40))
            for _ in range(20):
                assert int(dut.spi_cipo.value) == 0
                await wait_ps(1700)
        return transfers

    transfers = await play_beside(driver, reading(), moving(driver, random))
    await driver.check()
    for number, transfer in enumerate(transfers):
        assert not any(transfer.bits[FRAME_BITS:])
        assert_frame_of_a_word(driver, replace(transfer, bits=transfer.bits[:FRAME_BITS]), number)
