"""Commands over SPI: obeyed only when whole and right, and never by accident."""

import numpy as np
import pytest
from spi_lines import SpiLines, to_bytes
from test_position_spi import CLOCKS, run

from arcref.position_frame import COMMAND_CLEAR_FLAGS, PositionFrame, crc8_autosar, encode_clear_flags


def clears_of(lines) -> list[int]:
    """The masks that were cleared, one a clock in which any was."""
    _, clears, _ = run(lines)
    return clears[clears != 0].tolist()


def sealed(payload) -> bytes:
    """Seven bytes and their right CRC."""
    return bytes(payload) + bytes([crc8_autosar(bytes(payload))])


@pytest.mark.parametrize("phase", [0.0, 0.6])
@pytest.mark.parametrize(("high", "low"), CLOCKS)
def test_a_whole_command_is_obeyed_once_at_every_clock_and_phase(high, low, phase):
    masks = [0xFF, 0x81]
    lines = SpiLines(high, low, start=6 + phase)
    for mask in masks:
        lines.transfer(encode_clear_flags(mask))
    read, clears, _ = run(lines)
    assert clears[clears != 0].tolist() == masks
    frames = [PositionFrame.decode(to_bytes(bits)) for bits in read]
    assert [frame.frame_counter for frame in frames] == [0, 1], "the frame is sent as ever"


def test_every_mask_is_passed_on_as_it_is():
    lines = SpiLines()
    masks = [1 << bit for bit in range(8)] + [0x00, 0xA5, 0x5A]
    for mask in masks:
        lines.transfer(encode_clear_flags(mask))
    assert clears_of(lines) == [mask for mask in masks if mask]


def test_a_command_acts_only_after_chip_select_has_risen():
    lines = SpiLines()
    lines.transfer(encode_clear_flags(0x44))
    _, clears, _ = run(lines)
    rise = int(np.flatnonzero(np.diff(lines.rows()["cs_n"]) == 1)[0])
    acted = np.flatnonzero(clears)
    assert len(acted) == 1
    assert rise < acted[0] < rise + 12


def test_a_single_wrong_bit_anywhere_makes_a_command_void():
    lines = SpiLines()
    for bit in range(64):
        word = int.from_bytes(encode_clear_flags(0xFF)) ^ 1 << bit
        lines.transfer(word.to_bytes(8))
    assert clears_of(lines) == []


@pytest.mark.parametrize(("high", "low"), [(4, 4), (2, 6), (3, 9)])
@pytest.mark.parametrize("phase", [0.0, 0.5])
def test_chip_select_may_rise_right_after_the_last_rising_edge(high, low, phase):
    lines = SpiLines(high, low, start=6 + phase)
    lines.transfer(encode_clear_flags(0x5A), abort_high=True)
    lines.transfer(encode_clear_flags(0x24), abort_high=True)
    assert clears_of(lines) == [0x5A, 0x24]


@pytest.mark.parametrize("gap", [0.5, 1, 2, 3])
def test_a_clock_after_chip_select_has_risen_is_no_bit_of_the_command(gap):
    """Neither the 64th bit of a command that had 63, nor a 65th that would spoil a whole one."""
    command = encode_clear_flags(0x3C)
    lines = SpiLines()
    lines.transfer(command, bits=63, gap=gap)
    lines.pulse(command[-1] & 1)
    assert clears_of(lines) == []
    lines.transfer(command, gap=gap)
    lines.pulse(1)
    assert clears_of(lines) == [0x3C]


def test_a_longer_command_whose_crc_is_right_at_its_own_end_does_nothing():
    lines = SpiLines()
    for extra in (b"\x00", b"\xc1", b"\x12\x34", bytes(8)):
        payload = bytes([COMMAND_CLEAR_FLAGS, 0xFF, 0, 0, 0, 0, 0]) + extra
        lines.transfer(payload + bytes([crc8_autosar(payload)]), bits=64 + 8 * len(extra))
    assert clears_of(lines) == []


def test_another_command_byte_with_its_right_crc_does_nothing():
    lines = SpiLines()
    for command in (0x00, 0x01, 0xFF, *(COMMAND_CLEAR_FLAGS ^ 1 << bit for bit in range(8))):
        lines.transfer(sealed([command, 0xFF, 0, 0, 0, 0, 0]))
    assert clears_of(lines) == []


def test_a_rest_that_is_not_zero_with_its_right_crc_does_nothing():
    lines = SpiLines()
    for place in range(2, 7):
        for bit in (0, 3, 7):
            payload = [COMMAND_CLEAR_FLAGS, 0xFF, 0, 0, 0, 0, 0]
            payload[place] = 1 << bit
            lines.transfer(sealed(payload))
    assert clears_of(lines) == []


@pytest.mark.parametrize("abort_high", [False, True])
def test_a_command_cut_short_or_drawn_out_does_nothing(abort_high):
    lines = SpiLines()
    for bits in (1, 8, 16, 48, 55, 56, 57, 62, 63, 65, 66, 72, 80, 128, 129):
        lines.transfer(encode_clear_flags(0xFF) + encode_clear_flags(0xFF), bits=bits, abort_high=abort_high)
    assert clears_of(lines) == []
    lines.transfer(encode_clear_flags(0x21))
    assert clears_of(lines) == [0x21], "and the next one is obeyed"


def test_a_command_in_two_halves_does_nothing():
    lines = SpiLines()
    command = encode_clear_flags(0xFF)
    for cut in (1, 4, 7):
        lines.transfer(command[:cut], bits=8 * cut)
        lines.transfer(command[cut:], bits=64 - 8 * cut)
    assert clears_of(lines) == []


def test_noise_on_copi_never_clears(rng):
    lines = SpiLines()
    for _ in range(30):
        lines.transfer(rng.bytes(8))
    for start in (b"\xc1", b"\xc1\xff", b"\xc1\xff\0\0\0\0\0"):
        for _ in range(3):
            tail = rng.bytes(8 - len(start))
            lines.transfer(start + tail if start + tail != encode_clear_flags(0xFF) else bytes(8))
    lines.transfer(b"\xff" * 8)
    lines.transfer(bytes(8))
    assert clears_of(lines) == []


def test_a_command_that_was_obeyed_is_not_obeyed_again():
    lines = SpiLines()
    lines.transfer(encode_clear_flags(0x0F), gap=30)
    lines.transfer(bits=0, gap=10)
    lines.noise(70)
    lines.transfer(bits=5, gap=10)
    lines.transfer()
    assert clears_of(lines) == [0x0F]
