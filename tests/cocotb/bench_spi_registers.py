"""Register commands over SPI on the core with its wire: beside position frames, cut short, broken, back to back."""

import cocotb
import numpy as np
from asynchronous_spi import FASTEST_PERIOD_PS, SpiController, Transfer, wait_ps
from core_driver import CLOCK_PERIOD_PS
from linked_core import LinkedCore

from arcref.link.packet import Kind, Packet, Status
from arcref.link.register import UNKNOWN_WORD
from arcref.link.registers import MAGIC, REGISTERS
from arcref.position_frame import (
    FrameError,
    PositionFrame,
    RegisterFrame,
    encode_read_register,
    encode_write_register,
)

DELAY = REGISTERS["strobe_delay"].address
PERIOD = REGISTERS["strobe_period"].address
MOST_FRAMES = 6
"""Frames within which an answer must have come."""


class Master:
    """An SPI master with a core; every frame it reads is checked: a position of its instant, or an answer."""

    def __init__(self, dut, seed: int, period_ps: int = FASTEST_PERIOD_PS):
        self.core, self.spi = LinkedCore(dut), SpiController(dut, period_ps)
        self.random = np.random.default_rng(seed)
        self.frames = 0

    async def transfer(self, sent: bytes = bytes(8), **more) -> RegisterFrame | None:
        """One frame; gives the answer when it was one."""
        transfer = await self.spi.transfer(sent, **more)
        number, self.frames = self.frames, self.frames + 1
        return self._answer(transfer, number)

    def _answer(self, transfer: Transfer, number: int) -> RegisterFrame | None:
        try:
            answer = RegisterFrame.decode(transfer.data)
        except FrameError:
            self.core.assert_position(transfer.data, transfer.selected_ps, number)
            return None
        assert answer.frame_counter == number & 0xFF
        try:
            PositionFrame.decode(transfer.data)
        except FrameError:
            return answer
        raise AssertionError("an answer passes for a position")

    async def ask(self, command: bytes) -> RegisterFrame:
        """Send a command, and zeros until its answer comes."""
        assert await self.transfer(command) is None
        for _ in range(MOST_FRAMES):
            await wait_ps(int(self.random.integers(3 * CLOCK_PERIOD_PS)))
            answer = await self.transfer()
            if answer is not None:
                return answer
        raise AssertionError("no answer came")

    async def read(self, address: int) -> int:
        """The word at an address."""
        answer = await self.ask(encode_read_register(address))
        assert (answer.status, answer.address) == (Status.DONE, address)
        return answer.word

    async def write(self, address: int, word: int) -> int:
        """Write a word; gives the status."""
        answer = await self.ask(encode_write_register(address, word))
        assert (answer.address, answer.word) == (address, word)
        return answer.status


@cocotb.test()
async def registers_are_read_and_written_beside_position_frames(dut):
    for period_ps in (FASTEST_PERIOD_PS, FASTEST_PERIOD_PS * 5 // 4 + 37, 3 * FASTEST_PERIOD_PS + 111):
        master = Master(dut, 1, period_ps)
        await master.core.start()
        assert await master.read(REGISTERS["magic"].address) == MAGIC
        for _ in range(4):
            word = int(master.random.integers(1 << 16))
            assert await master.write(DELAY, word) == Status.DONE
            assert await master.read(DELAY) == word
        assert await master.write(REGISTERS["magic"].address, 1) == Status.READ_ONLY
        assert await master.write(REGISTERS["gate_state"].address, 4) == Status.OUT_OF_RANGE
        assert await master.write(0x0FFF, 1) == Status.UNKNOWN_ADDRESS
        assert await master.read(0x0FFF) == UNKNOWN_WORD
        assert await master.read(DELAY) == word
        assert master.core.shown[-1][2], "the encoder was homed meanwhile"


@cocotb.test()
async def chip_select_raised_at_any_place_changes_no_register(dut):
    master = Master(dut, 2)
    await master.core.start()
    assert await master.write(DELAY, 0x1234) == Status.DONE
    command = encode_write_register(DELAY, 0x4321)
    for bits in (*range(1, 64, 3), 63, 64, 65, 66, 72, 128):
        cut_ps = None if bits > 64 else int(master.random.integers(FASTEST_PERIOD_PS))
        if bits == 64:
            bits = 63
        await master.spi.transfer(command * 2, bits, cut_ps=cut_ps)
        master.frames += 1
        await wait_ps(int(master.random.integers(20 * CLOCK_PERIOD_PS)))
        assert await master.transfer() is None, "nothing was asked"
    assert await master.read(DELAY) == 0x1234
    assert await master.write(DELAY, 0x4321) == Status.DONE
    assert await master.read(DELAY) == 0x4321


@cocotb.test()
async def chip_select_raised_within_an_answer_leaves_the_port_ready(dut):
    master = Master(dut, 3)
    await master.core.start()
    for bits in (1, 9, 24, 40, 56, 63):
        word = int(master.random.integers(1 << 16))
        assert await master.transfer(encode_write_register(DELAY, word)) is None
        await wait_ps(60 * CLOCK_PERIOD_PS)
        await master.spi.transfer(bytes(8), bits, cut_ps=int(master.random.integers(FASTEST_PERIOD_PS)))
        master.frames += 1
        assert await master.transfer() is None, "an answer is sent once"
        assert await master.read(DELAY) == word


@cocotb.test()
async def a_wrong_bit_anywhere_makes_a_register_command_void(dut):
    master = Master(dut, 4)
    await master.core.start()
    right = encode_write_register(DELAY, 0xA55A)
    for bit in range(64):
        assert await master.transfer((int.from_bytes(right, "big") ^ 1 << bit).to_bytes(8, "big")) is None
    for _ in range(8):
        assert await master.transfer(bytes([0x5A]) + bytes(master.random.bytes(7))) is None
    assert await master.read(DELAY) == 0
    assert await master.write(DELAY, 0xA55A) == Status.DONE


@cocotb.test()
async def commands_back_to_back_are_all_obeyed_and_answered_in_order(dut):
    master = Master(dut, 5)
    await master.core.start()
    asked, answers = [], []
    for number in range(24):
        word = int(master.random.integers(1 << 16))
        reads = number % 3 == 2
        asked.append((DELAY, asked[-1][1] if reads else word))
        answers.append(
            await master.transfer(encode_read_register(DELAY) if reads else encode_write_register(DELAY, word))
        )
    answers += [await master.transfer() for _ in range(3)]
    came = [(answer.address, answer.word) for answer in answers if answer is not None]
    assert came == asked
    assert all(answer.status == Status.DONE for answer in answers if answer is not None)


@cocotb.test()
async def both_doors_at_once_disturb_neither(dut):
    """Two requests always on their way over UART; a master that only sends zeros meanwhile, and then one that asks."""
    master = Master(dut, 6)
    await master.core.start()
    requests, values = [], []
    for number in range(16):
        if number % 2 == 0:
            values.append(int(master.random.integers(1 << 32)))
            payload = PERIOD.to_bytes(2, "little") + values[-1].to_bytes(4, "little")
            requests.append(Packet(Kind.WRITE, number, payload))
        else:
            requests.append(Packet(Kind.READ, number, PERIOD.to_bytes(2, "little") + bytes([2])))
    waiting = list(requests)

    def keep_two_on_their_way() -> None:
        # There is room for two packets; a third that comes before the first is obeyed would be refused.
        while waiting and len(requests) - len(waiting) - len(master.core.packets) < 2:
            master.core.send(waiting.pop(0))

    for _ in range(6):
        keep_two_on_their_way()
        assert await master.transfer() is None
    while len(master.core.packets) < len(requests):
        keep_two_on_their_way()
        word = int(master.random.integers(1 << 16))
        assert await master.write(DELAY, word) == Status.DONE
        assert await master.read(DELAY) == word
        assert master.frames < 400, f"the UART answered {[packet.number for packet in master.core.packets]}"
    assert [packet.number for packet in master.core.packets] == list(range(16))
    assert all(packet.payload[0] == Status.DONE for packet in master.core.packets)
    read = [int.from_bytes(packet.payload[3:], "little") for packet in master.core.packets[1::2]]
    assert read == values
