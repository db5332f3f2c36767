"""Registers over the SPI pins of the true gateware, beside position frames and beside the UART."""

import threading

import numpy as np
from twin_truth import wait_until_homed

from arcref import Encoder
from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD, Access
from arcref.link.registers import REGISTERS
from arcref.position_frame import (
    FrameError,
    PositionFrame,
    RegisterFrame,
    encode_read_register,
    encode_write_register,
)
from arcref_sim.spi_plan import SpiPlan

BETWEEN_CLOCKS = 40
"""Chip select high between frames: long enough for a register's answer, a snapshot's takes one frame more."""


def ask(twin, *commands: bytes) -> list[RegisterFrame]:
    """Each command, and position frames until its answer has come; every frame is one or the other."""
    answers = []
    for command in commands:
        sent = np.zeros((4, 8), np.uint8)
        sent[0] = np.frombuffer(command, np.uint8)
        frames = twin.read_spi(SpiPlan(np.zeros(4, np.int64), sent=sent, gap=BETWEEN_CLOCKS))
        data = [frame["data"].tobytes() for frame in frames]
        found = [RegisterFrame.decode(frame) for frame in data if not is_position(frame)]
        assert len(found) == 1
        assert is_position(data[0])
        answers += found
    return answers


def is_position(frame: bytes) -> bool:
    try:
        PositionFrame.decode(frame)
    except FrameError:
        return False
    return True


def read(twin, name: str) -> int:
    register = REGISTERS[name]
    return register.decode([answer.word for answer in ask(twin, *map(encode_read_register, register.addresses))])


def test_every_setting_is_written_and_read_word_by_word(make_twin, random):
    with make_twin() as twin, Encoder(twin.port) as encoder:
        for register in REGISTERS.registers:
            if register.access is not Access.WRITE:
                continue
            value = int(random.integers(0, 1 << register.width))
            words = register.encode(value)
            answers = ask(twin, *map(encode_write_register, register.addresses, words))
            assert {answer.status for answer in answers} == {Status.DONE}
            assert read(twin, register.name) == value, register.name
            assert encoder.registers.read(register.name) == value, "the UART reads the same register"


def test_a_write_that_is_refused_says_why_and_changes_nothing(make_twin):
    with make_twin() as twin:
        for register in REGISTERS.registers:
            if register.access is Access.READ:
                (answer,) = ask(twin, encode_write_register(register.address, 0))
                assert answer.status == Status.READ_ONLY, register.name
            elif register.width < 16:
                (answer,) = ask(twin, encode_write_register(register.address, 1 << register.width))
                assert answer.status == Status.OUT_OF_RANGE, register.name
                if register.access is Access.WRITE:
                    assert read(twin, register.name) == register.reset
        for window in REGISTERS.windows:
            (answer,) = ask(twin, encode_write_register(window.address, 1))
            assert answer.status == Status.NOT_NOW
        for address in (0x000B, 0x00FE, 0x0FFF, 0xFFFF):
            (answer,) = ask(twin, encode_write_register(address, 1))
            assert answer.status == Status.UNKNOWN_ADDRESS
            (answer,) = ask(twin, encode_read_register(address))
            assert (answer.status, answer.word) == (Status.DONE, UNKNOWN_WORD)


def test_a_snapshot_over_spi_is_of_one_instant(make_twin):
    with make_twin(speed_rps=10.0) as twin:
        wait_until_homed(twin)
        for _ in range(3):
            number = read(twin, "snapshot_number")
            raw, position = read(twin, "snapshot_raw"), read(twin, "snapshot_position")
            assert position == int(twin.rom.correct(np.array([raw]))[0])
            assert read(twin, "snapshot_flags") >> 8 == 1
            time = read(twin, "snapshot_time")
            true = twin.call(lambda time=time: float(twin.encoder.ideal_count_at(time)))
            assert abs(raw - true) <= 1
        assert read(twin, "snapshot_number") == number + 1


def test_a_command_strobes_over_spi(make_twin):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        ask(twin, encode_write_register(REGISTERS["strobe_control"].address, 3))
        before = encoder.registers.captures
        ask(twin, *[encode_write_register(REGISTERS["strobe_command"].address, 1)] * 5)
        assert encoder.registers.captures == before + 5


def test_both_doors_at_once_disturb_neither(make_twin, random):
    """The UART asks without a pause, for what takes longest, while SPI writes and reads."""
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        ends = threading.Event()
        failures: list = []

        def over_uart():
            rng = np.random.default_rng(1)
            while not ends.is_set():
                value = int(rng.integers(1 << 32))
                encoder.registers.strobe_period = value
                if encoder.registers.strobe_period != value:
                    failures.append(value)
                encoder.snapshot()

        asking = threading.Thread(target=over_uart)
        asking.start()
        try:
            for _ in range(60):
                word = int(random.integers(1 << 16))
                address = REGISTERS["strobe_delay"].address
                written, got = ask(twin, encode_write_register(address, word), encode_read_register(address))
                assert (written.status, written.word) == (Status.DONE, word)
                assert (got.status, got.word) == (Status.DONE, word)
        finally:
            ends.set()
            asking.join()
        assert not failures
        assert encoder.registers.packets_refused == 0
