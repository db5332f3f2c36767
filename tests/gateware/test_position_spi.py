"""SPI: every frame is one snapshot, whole and right, at any clock, phase and abort."""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench
from spi_lines import SpiLines, to_bytes

from arcref.flags import Flag
from arcref.position_frame import PositionFrame, decode_short
from arcref_gateware.position_spi import LOWEST_CLOCK_RATIO, PositionSpi

VALUES = ("angle", "homed", "flags", "turns")


@cache
def bench() -> Bench:
    return Bench(PositionSpi(), ["sck", "cs_n", "copi", *VALUES, "rst"], ["cipo", "clear_flags"])


def run(lines: SpiLines, values=None, **controls):
    """Bits read in each transfer, `clear_flags` by clock, and the values that were shown by clock.

    Without `values` every input changes at every clock, so that no two clocks can be mixed unseen.
    """
    rows = lines.rows()
    clocks = len(rows["sck"])
    if values is None:
        clock = np.arange(clocks)
        values = {
            "angle": clock * 2_654_435 % (1 << 23),
            "homed": clock // 3 & 1,
            "flags": clock * 37 & 0xFF,
            "turns": clock * 40_503 & 0xFFFF,
        }
    out = bench().run(clocks, **rows, **values, **controls)
    assert not out["cipo"][:5].any(), "CIPO is 0 while chip select is high"
    return lines.received(out["cipo"]), out["clear_flags"], values


def frame_at(values, clock, counter) -> PositionFrame:
    """The frame that shows the values of one clock."""
    angle, homed, flags, turns = (int(values[name][clock]) for name in VALUES)
    return PositionFrame(angle, bool(homed), Flag(flags), turns - (turns >> 15 << 16), counter & 0xFF)


def assert_snapshot(bits, values, select, counter):
    """The frame is that of one single clock, at chip select or up to four clocks after it."""
    frame = PositionFrame.decode(to_bytes(bits[:64]))
    candidates = [frame_at(values, int(np.ceil(select)) + late, counter) for late in range(-1, 4)]
    assert frame in candidates, f"{frame} is none of {candidates}"


CLOCKS = [(4, 4), (4.5, 4.5), (5.25, 5.25), (6.5, 6.5), (3, 5), (5, 4), (4, 9), (16, 4)]
"""High and low time of SCK, in word clocks: 8, 9, 10.5 and 13 word clocks a bit, and unequal halves."""


@pytest.mark.parametrize("phase", [0.0, 0.5, 0.99])
@pytest.mark.parametrize(("high", "low"), CLOCKS)
def test_a_frame_is_one_snapshot_at_every_clock_and_phase(high, low, phase):
    lines = SpiLines(high, low, start=6 + phase, pad=0.9)
    for _ in range(2):
        lines.transfer(gap=3.6)
    bits, clears, values = run(lines)
    for number, read in enumerate(bits):
        assert_snapshot(read, values, lines.selects[number], number)
    assert not clears.any()


@pytest.mark.parametrize(("high", "low"), [(4, 4), (3, 5), (13, 6)])
def test_each_bit_stays_until_sck_falls(high, low):
    lines = SpiLines(high, low, start=6.4, pad=0.1 - high)
    lines.transfer()
    bits, _, values = run(lines)
    assert_snapshot(bits[0], values, lines.selects[0], 0)


@pytest.mark.parametrize("seed", range(4))
def test_edges_that_the_synchroniser_sees_a_clock_late_spoil_nothing(seed):
    lines = SpiLines(LOWEST_CLOCK_RATIO / 2, LOWEST_CLOCK_RATIO / 2, start=6.2 + seed / 4, doubt=0.3, seed=seed)
    for _ in range(3):
        lines.transfer(gap=4)
    bits, _, values = run(lines)
    for number, read in enumerate(bits):
        assert_snapshot(read, values, lines.selects[number], number)


def test_a_frame_aborted_at_any_bit_leaves_the_next_one_right(rng):
    """Chip select rises while SCK is high or low, as it comes."""
    lines = SpiLines()
    for bits in range(64):
        lines.transfer(bits=bits, gap=3, abort_high=bits > 0 and rng.random() < 0.5)
        lines.transfer(gap=3)
    read, clears, values = run(lines)
    for number in range(64):
        assert len(read[2 * number]) == number
        assert_snapshot(read[2 * number + 1], values, lines.selects[2 * number + 1], 2 * number + 1)
        whole = int(np.ceil(lines.selects[2 * number]))
        starts = [frame_at(values, whole + late, 2 * number).encode() for late in range(-1, 4)]
        assert any(read[2 * number] == list(map(int, f"{int.from_bytes(start):064b}"[:number])) for start in starts)
    assert not clears.any()


@pytest.mark.parametrize("gap", [3, 3.01, 3.5, 4, 50])
def test_frames_back_to_back_count_up_and_are_all_right(gap):
    lines = SpiLines(start=5.4)
    for _ in range(8):
        lines.transfer(gap=gap)
    bits, _, values = run(lines)
    for number, read in enumerate(bits):
        assert_snapshot(read, values, lines.selects[number], number)


def test_the_frame_counter_goes_on_at_256():
    lines = SpiLines()
    for _ in range(255):
        lines.transfer(bits=0)
    for _ in range(3):
        lines.transfer()
    bits, _, _ = run(lines)
    assert [PositionFrame.decode(to_bytes(read)).frame_counter for read in bits[255:]] == [255, 0, 1]


@pytest.mark.parametrize("count", [24, 32])
def test_a_master_may_stop_after_24_or_32_bits(count):
    lines = SpiLines(start=5.7)
    for _ in range(5):
        lines.transfer(bits=count)
    bits, _, values = run(lines)
    for number, read in enumerate(bits):
        frame = decode_short(to_bytes(read))
        clock = int(np.ceil(lines.selects[number]))
        shown = [frame_at(values, clock + late, 0) for late in range(-1, 4)]
        assert (frame.angle, frame.homed) in [(one.angle, one.homed) for one in shown]
        assert count == 24 or (frame.angle, frame.flags) in [(one.angle, one.flags) for one in shown]


def test_more_than_64_clocks_read_zeros():
    lines = SpiLines()
    lines.transfer(bits=64 + 70)
    lines.transfer()
    bits, _, values = run(lines)
    assert_snapshot(bits[0], values, lines.selects[0], 0)
    assert not any(bits[0][64:])
    assert_snapshot(bits[1], values, lines.selects[1], 1)


@pytest.mark.parametrize("fill", [0, 1])
def test_fields_at_their_ends_keep_to_their_places(fill):
    lines = SpiLines()
    lines.transfer()
    full = {"angle": (1 << 23) - 1, "homed": 1, "flags": 0xFF, "turns": 0xFFFF}
    for name in VALUES:
        values = {other: full[other] if (other == name) == bool(fill) else 0 for other in VALUES}
        bits, _, _ = run(lines, values)
        assert_snapshot(bits[0], {other: np.full(99, value) for other, value in values.items()}, lines.selects[0], 0)


def test_clocks_and_data_without_chip_select_do_nothing():
    lines = SpiLines()
    for number in range(4):
        lines.noise(60 + number)
        lines.transfer()
    bits, clears, values = run(lines)
    for number, read in enumerate(bits):
        assert_snapshot(read, values, lines.selects[number], number)
    assert not clears.any()


def test_cipo_is_0_while_chip_select_is_high():
    lines = SpiLines()
    lines.transfer(bits=9, gap=40)
    lines.noise(50)
    full = {"angle": (1 << 23) - 1, "homed": 1, "flags": 0xFF, "turns": 0xFFFF}
    rows = lines.rows()
    cipo = bench().run(len(rows["sck"]), **rows, **full)["cipo"]
    selected = np.concatenate((np.zeros(3), 1 - rows["cs_n"]))[: len(cipo)]
    assert not cipo[(selected == 0) & (np.concatenate(([0, 0], 1 - rows["cs_n"]))[: len(cipo)] == 0)].any()
    assert cipo.any()


def test_reset_in_the_middle_of_a_frame_leaves_the_port_ready():
    lines = SpiLines()
    lines.transfer(bits=40)
    lines.transfer()
    bits, clears, values = run(lines, rst=[0] * 150 + [1, 1, 0])
    assert PositionFrame.decode(to_bytes(bits[1])).frame_counter in (0, 1)
    assert_snapshot(bits[1], values, lines.selects[1], PositionFrame.decode(to_bytes(bits[1])).frame_counter)
    assert not clears.any()
