from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.position_frame import (
    COMMAND_CLEAR_FLAGS,
    FRAME_BITS,
    FRAME_FIELD,
    FRAME_FIELDS,
    FrameError,
    PositionFrame,
    crc8_autosar,
    decode_short,
    encode_clear_flags,
)

frames = st.builds(
    PositionFrame,
    angle=st.integers(0, COUNTS_PER_TURN - 1),
    homed=st.booleans(),
    flags=st.integers(0, 255).map(Flag),
    turns=st.integers(-0x8000, 0x7FFF),
    frame_counter=st.integers(0, 255),
)

EXAMPLE = PositionFrame(0x2AAAAA, True, Flag.ILLEGAL_STEP | Flag.CORRECTION_ACTIVE, -2, 7)


def test_the_fields_fill_the_frame_once_and_in_order():
    bits = [bit for field in FRAME_FIELDS for bit in range(field.high, field.low - 1, -1)]
    assert bits == list(range(FRAME_BITS - 1, -1, -1))
    assert [(f.name, f.high, f.low) for f in FRAME_FIELDS] == [
        ("angle", 63, 41),
        ("homed", 40, 40),
        ("flags", 39, 32),
        ("turns", 31, 16),
        ("frame_counter", 15, 8),
        ("crc", 7, 0),
    ]


def test_crc_check_value():
    assert crc8_autosar(b"123456789") == 0xDF


@pytest.mark.parametrize(
    ("data", "crc"),
    # Test vectors of the AUTOSAR CRC library's specification, CRC-8 with polynomial 0x2F.
    [
        ("00000000", 0x12),
        ("F20183", 0xC2),
        ("0FAA0055", 0xC6),
        ("00FF5511", 0x77),
        ("332255AABBCCDDEEFF", 0x11),
        ("926B55", 0x33),
        ("FFFFFFFF", 0x6C),
    ],
)
def test_crc_vectors_of_autosar(data, crc):
    assert crc8_autosar(bytes.fromhex(data)) == crc


def test_a_frame_bit_by_bit():
    word = int.from_bytes(EXAMPLE.encode(), "big")
    assert word >> 41 == 0x2AAAAA
    assert word >> 40 & 1 == 1
    assert word >> 32 & 0xFF == 0b1000_0010
    assert word >> 16 & 0xFFFF == 0xFFFE
    assert word >> 8 & 0xFF == 7
    assert word & 0xFF == crc8_autosar(EXAMPLE.encode()[:7])


@given(frames)
def test_decode_gives_back_what_encode_took(frame):
    assert PositionFrame.decode(frame.encode()) == frame


@given(frames)
def test_short_frames_are_the_beginning_of_the_long_one(frame):
    data = frame.encode()
    after_24, after_32 = decode_short(data[:3]), decode_short(data[:4])
    assert (after_24.angle, after_24.homed, after_24.flags) == (frame.angle, frame.homed, None)
    assert (after_32.angle, after_32.homed, after_32.flags) == (frame.angle, frame.homed, frame.flags)


@given(st.integers(-(1 << 47), (1 << 47) - 1))
def test_the_position_of_a_frame_is_the_encoder_s_modulo_65536_turns(position):
    frame = PositionFrame.of_position(position)
    assert (frame.position - position) % (65536 * COUNTS_PER_TURN) == 0
    assert -0x8000 * COUNTS_PER_TURN <= frame.position < 0x8000 * COUNTS_PER_TURN


def test_position_just_below_zero():
    frame = PositionFrame.of_position(-1)
    assert (frame.turns, frame.angle, frame.position) == (-1, COUNTS_PER_TURN - 1, -1)


@given(frames)
def test_every_single_wrong_bit_is_found(frame):
    data = int.from_bytes(frame.encode(), "big")
    for bit in range(FRAME_BITS):
        with pytest.raises(FrameError, match="CRC"):
            PositionFrame.decode((data ^ 1 << bit).to_bytes(8, "big"))


def test_every_error_of_up_to_three_bits_is_found():
    # The CRC is linear, so an error is missed in one frame just when it is missed in every frame.
    single = []
    for bit in range(FRAME_BITS):
        wrong = (1 << bit).to_bytes(8, "big")
        single.append(crc8_autosar(wrong[:7]) ^ crc8_autosar(bytes(7)) ^ wrong[7])
    for count in (1, 2, 3):
        for syndromes in combinations(single, count):
            total = 0
            for syndrome in syndromes:
                total ^= syndrome
            assert total != 0


@pytest.mark.parametrize("idle", [bytes(8), b"\xff" * 8])
def test_a_line_stuck_low_or_high_is_no_frame(idle):
    with pytest.raises(FrameError, match="CRC"):
        PositionFrame.decode(idle)


@pytest.mark.parametrize("length", [0, 3, 7, 9])
def test_wrong_length(length):
    with pytest.raises(FrameError, match=f"8 bytes, there are {length}"):
        PositionFrame.decode(bytes(length))


@pytest.mark.parametrize("length", [0, 2, 5, 8])
def test_wrong_short_length(length):
    with pytest.raises(FrameError, match=f"3 or 4 bytes, there are {length}"):
        decode_short(bytes(length))


@pytest.mark.parametrize(
    ("name", "value"),
    [("angle", COUNTS_PER_TURN), ("angle", -1), ("turns", 0x8000), ("turns", -0x8001), ("frame_counter", 256)],
)
def test_a_value_its_field_cannot_hold(name, value):
    values = {"angle": 0, "homed": False, "flags": Flag(0), "turns": 0, "frame_counter": 0} | {name: value}
    with pytest.raises(ValueError, match=f"{name} is {value}, it must lie in"):
        PositionFrame(**values).encode()


def test_field_limits():
    assert (FRAME_FIELD["turns"].smallest, FRAME_FIELD["turns"].largest) == (-32768, 32767)
    assert (FRAME_FIELD["angle"].smallest, FRAME_FIELD["angle"].largest) == (0, COUNTS_PER_TURN - 1)


@given(st.integers(0, 255))
def test_clear_flags_command(mask):
    command = encode_clear_flags(mask)
    assert command[:2] == bytes([COMMAND_CLEAR_FLAGS, mask])
    assert command[2:7] == bytes(5)
    assert command[7] == crc8_autosar(command[:7])


@pytest.mark.parametrize("mask", [-1, 256])
def test_clear_flags_mask_must_be_a_byte(mask):
    with pytest.raises(ValueError, match="0 .. 255"):
        encode_clear_flags(mask)
