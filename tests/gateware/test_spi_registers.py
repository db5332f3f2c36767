"""Register commands over SPI: asked once, answered once, and never by accident."""

from functools import cache

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth_bench import Bench
from spi_lines import SpiLines, to_bytes
from test_position_spi import CLOCKS, VALUES, assert_snapshot

from arcref.position_frame import (
    COMMAND_READ_REGISTER,
    COMMAND_WRITE_REGISTER,
    FrameError,
    PositionFrame,
    RegisterFrame,
    crc8_autosar,
    encode_clear_flags,
    encode_read_register,
    encode_write_register,
)
from arcref_gateware.position_spi import PositionSpi

SOON = 40
"""Clocks of chip select high in which the registers answer, and the answer is ready for the next frame."""


def word_at(address: int) -> int:
    """What the registers of the bench hold."""
    return address * 40503 & 0xFFFF ^ 0x1234


def status_at(address: int) -> int:
    """The status with which they answer."""
    return address >> 3 & 7


class AnsweredPort(wiring.Component):
    """The SPI port with registers that answer `delay` clocks after they were asked."""

    sck: In(1)
    cs_n: In(1, init=1)
    copi: In(1)
    angle: In(23)
    homed: In(1)
    flags: In(8)
    turns: In(16)
    delay: In(16)
    cipo: Out(1)
    clear_flags: Out(8)
    valid: Out(1)
    write: Out(1)
    address: Out(16)
    write_word: Out(16)

    def elaborate(self, platform):
        m = Module()
        m.submodules.port = port = PositionSpi()
        registers = port.registers
        m.d.comb += [getattr(port, name).eq(getattr(self, name)) for name in ("sck", "cs_n", "copi", *VALUES)]
        m.d.comb += [getattr(self, name).eq(getattr(port, name)) for name in ("cipo", "clear_flags")]
        m.d.comb += [
            getattr(self, name).eq(getattr(registers, name)) for name in ("valid", "write", "address", "write_word")
        ]
        waits, asked = Signal(17), Signal()
        address = Signal(16)
        m.d.sync += registers.done.eq(0)
        with m.If(registers.valid):
            m.d.sync += [waits.eq(self.delay), asked.eq(1), address.eq(registers.address)]
        with m.Elif(asked & (waits == 0)):
            m.d.sync += [
                registers.done.eq(1),
                asked.eq(0),
                registers.status.eq(address[3:6]),
                registers.read_word.eq((address * 40503)[:16] ^ 0x1234),
            ]
        with m.Else():
            m.d.sync += waits.eq(waits - 1)
        return m


@cache
def bench() -> Bench:
    outputs = ["cipo", "clear_flags", "valid", "write", "address", "write_word"]
    return Bench(AnsweredPort(), ["sck", "cs_n", "copi", *VALUES, "delay"], outputs)


class Exchange:
    """A run: `frames` the bytes of every transfer, `asked` what reached the registers, and how frames are checked."""

    def __init__(self, lines: SpiLines, delay: int = 5):
        rows = lines.rows()
        clocks = len(rows["sck"])
        clock = np.arange(clocks)
        self.values = {
            "angle": clock * 2_654_435 % (1 << 23),
            "homed": clock // 3 & 1,
            "flags": clock * 37 & 0xFF,
            "turns": clock * 40_503 & 0xFFFF,
        }
        out = bench().run(clocks, **rows, **self.values, delay=delay)
        self.selects, self.bits = lines.selects, lines.received(out["cipo"])
        self.frames = [to_bytes(bits[:64]) if len(bits) >= 64 else b"" for bits in self.bits]
        self.clears = out["clear_flags"][out["clear_flags"] != 0].tolist()
        self.asked = [
            ("write", int(out["address"][k]), int(out["write_word"][k]))
            if out["write"][k]
            else ("read", int(out["address"][k]))
            for k in np.flatnonzero(out["valid"])
        ]

    def assert_position(self, number: int) -> None:
        """The frame is a whole position, of the clock of its chip select, and no answer."""
        assert_snapshot(self.bits[number], self.values, self.selects[number], number)
        with pytest.raises(FrameError):
            RegisterFrame.decode(self.frames[number])

    def assert_answer(self, number: int, asked: tuple) -> None:
        """The frame is the answer to what was asked, and no position."""
        kind, address, *words = asked
        command = COMMAND_READ_REGISTER if kind == "read" else COMMAND_WRITE_REGISTER
        word = words[0] if words else word_at(address)
        assert RegisterFrame.decode(self.frames[number]) == RegisterFrame(
            command, status_at(address), address, word, number & 0xFF
        )
        with pytest.raises(FrameError):
            PositionFrame.decode(self.frames[number])


def encoded(asked: tuple) -> bytes:
    kind, *arguments = asked
    return encode_read_register(*arguments) if kind == "read" else encode_write_register(*arguments)


def random_command(rng) -> tuple:
    address = int(rng.integers(1 << 16))
    return ("read", address) if rng.random() < 0.5 else ("write", address, int(rng.integers(1 << 16)))


@pytest.mark.parametrize("phase", [0.0, 0.6])
@pytest.mark.parametrize(("high", "low"), CLOCKS)
def test_reads_and_writes_are_asked_and_answered_beside_position_frames(high, low, phase, rng):
    lines = SpiLines(high, low, start=6 + phase)
    commands = [random_command(rng) for _ in range(4)]
    for command in commands:
        lines.transfer(encoded(command), gap=SOON)
        lines.transfer()
        lines.transfer()
    exchange = Exchange(lines)
    assert exchange.asked == commands
    for number, command in enumerate(commands):
        exchange.assert_position(3 * number)
        exchange.assert_answer(3 * number + 1, command)
        exchange.assert_position(3 * number + 2)


def test_every_bit_of_address_and_word_arrives():
    lines = SpiLines()
    commands = [("write", 1 << bit, 0xFFFF ^ 1 << bit) for bit in range(16)] + [("read", 0xFFFF), ("write", 0, 0)]
    for command in commands:
        lines.transfer(encoded(command), gap=SOON)
    assert Exchange(lines).asked == commands


@pytest.mark.parametrize("gap", [3, 4, 7, 12, 20])
@pytest.mark.parametrize("delay", [0, 5, 60, 480])
def test_commands_back_to_back_are_all_answered_in_their_order(gap, delay, rng):
    """Each frame brings a command, with the shortest gap on. None is lost while the registers take less than a frame.

    An answer that comes within the gap is in the next frame, else in the one after it.
    """
    lines = SpiLines(seed=int(rng.integers(1000)))
    commands = [random_command(rng) for _ in range(8)]
    for command in commands:
        lines.transfer(encoded(command), gap=gap)
    for _ in range(3):
        lines.transfer(gap=gap)
    exchange = Exchange(lines, delay)
    assert exchange.asked == commands
    answers = [number for number, frame in enumerate(exchange.frames) if _is_answer(frame)]
    assert len(answers) == len(commands)
    for number, command in zip(answers, commands, strict=True):
        exchange.assert_answer(number, command)
    assert {number - place for place, number in enumerate(answers)} <= {1, 2}
    for number in set(range(len(exchange.frames))) - set(answers):
        exchange.assert_position(number)


def _is_answer(frame: bytes) -> bool:
    try:
        RegisterFrame.decode(frame)
    except FrameError:
        return False
    return True


def test_a_command_before_the_answer_to_the_one_before_it_replaces_nothing(rng):
    lines = SpiLines()
    first, *others = [random_command(rng) for _ in range(4)]
    for command in (first, *others):
        lines.transfer(encoded(command))
    lines.transfer(gap=500)
    lines.transfer()
    lines.transfer(encoded(others[0]), gap=600)
    lines.transfer()
    exchange = Exchange(lines, delay=2400)
    assert exchange.asked == [first, others[0]], "what came meanwhile is not obeyed"
    for number in (0, 1, 2, 3, 4, 6, 7):
        exchange.assert_position(number)
    exchange.assert_answer(5, first)


def test_a_single_wrong_bit_anywhere_makes_a_register_command_void():
    lines = SpiLines()
    right = encode_write_register(0x5AA5, 0xC33C)
    for command in (encode_read_register(0x1234), right):
        for bit in range(64):
            word = int.from_bytes(command) ^ 1 << bit
            lines.transfer(word.to_bytes(8))
    lines.transfer(right)
    exchange = Exchange(lines)
    assert exchange.asked == [("write", 0x5AA5, 0xC33C)]
    assert exchange.clears == []
    for number in range(0, 128, 7):
        exchange.assert_position(number)


def test_a_command_with_something_where_zeros_belong_does_nothing():
    lines = SpiLines()
    for command, used in ((COMMAND_READ_REGISTER, 2), (COMMAND_WRITE_REGISTER, 4)):
        for place in range(used, 6):
            payload = bytearray([command, 0x12, 0x34, 0, 0, 0, 0])
            payload[1 + place] = 0x40
            lines.transfer(bytes(payload) + bytes([crc8_autosar(bytes(payload))]))
    assert Exchange(lines).asked == []


@pytest.mark.parametrize("abort_high", [False, True])
def test_chip_select_raised_at_any_bit_asks_nothing_and_leaves_the_port_ready(abort_high):
    command = ("write", 0x0084, 4000)
    lines = SpiLines()
    lengths = [*range(64), 65, 66, 72, 128]
    for bits in lengths:
        lines.transfer(encoded(command) * 2, bits=bits, gap=12, abort_high=abort_high)
    lines.transfer(encoded(command), gap=SOON)
    lines.transfer()
    exchange = Exchange(lines)
    assert exchange.asked == [command]
    exchange.assert_position(len(lengths))
    exchange.assert_answer(len(lengths) + 1, command)


def test_chip_select_raised_in_the_middle_of_an_answer_leaves_the_port_ready():
    """The answer is sent once: what was cut off is asked for again."""
    lines = SpiLines()
    lengths = [1, 7, 8, 31, 55, 56, 57, 63]
    for bits in lengths:
        lines.transfer(encode_read_register(bits), gap=SOON)
        lines.transfer(bits=bits)
        lines.transfer()
        lines.transfer(encode_read_register(0x4000 + bits), gap=SOON)
        lines.transfer()
    exchange = Exchange(lines)
    assert exchange.asked == [("read", base + bits) for bits in lengths for base in (0, 0x4000)]
    for place, bits in enumerate(lengths):
        exchange.assert_position(5 * place)
        answer = RegisterFrame(
            COMMAND_READ_REGISTER, status_at(bits), bits, word_at(bits), (5 * place + 1) & 0xFF
        ).encode()
        sent = [answer[k // 8] >> 7 - k % 8 & 1 for k in range(bits)]
        assert exchange.bits[5 * place + 1] == sent
        exchange.assert_position(5 * place + 2)
        exchange.assert_position(5 * place + 3)
        exchange.assert_answer(5 * place + 4, ("read", 0x4000 + bits))


def test_a_command_with_an_answer_is_obeyed_too():
    """A clear that goes out while an answer comes in, and a read after it."""
    lines = SpiLines()
    lines.transfer(encode_read_register(0x0020), gap=SOON)
    lines.transfer(encode_clear_flags(0x81), gap=SOON)
    lines.transfer(encode_read_register(0x0021), gap=SOON)
    lines.transfer()
    exchange = Exchange(lines)
    exchange.assert_answer(1, ("read", 0x20))
    exchange.assert_position(2)
    exchange.assert_answer(3, ("read", 0x21))
    assert exchange.clears == [0x81]


def test_noise_on_copi_asks_nothing(rng):
    lines = SpiLines()
    for _ in range(40):
        lines.transfer(rng.bytes(8))
    for start in (b"\xa6", b"\x5a", b"\xa6\0\x84\0\0\0\0", b"\x5a\0\x84\x0f\xa0\0\0"):
        for _ in range(3):
            tail = rng.bytes(8 - len(start))
            whole = start + tail
            lines.transfer(whole if whole[7] != crc8_autosar(whole[:7]) else bytes(8))
    lines.noise(200)
    lines.transfer(b"\xff" * 8)
    lines.transfer()
    exchange = Exchange(lines)
    assert exchange.asked == []
    for number in range(len(exchange.frames)):
        exchange.assert_position(number)
