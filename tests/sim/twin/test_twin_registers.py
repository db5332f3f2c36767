"""Every register over the pseudo-terminal against the true gateware."""

import numpy as np
from twin_truth import assert_counts, wait_until_homed

from arcref import Encoder
from arcref.instrument_error import InstrumentError
from arcref.link.link import RequestRefused
from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD, Access
from arcref.link.registers import MAGIC, REGISTERS
from arcref.position_frame import PositionFrame
from arcref_sim.spi_plan import SpiPlan


def test_every_register_is_read_and_written(make_twin, random):
    with make_twin() as twin, Encoder(twin.port) as encoder:
        assert encoder.registers.magic == MAGIC
        settings = [r for r in REGISTERS.registers if r.access is Access.WRITE]
        commands = [r for r in REGISTERS.registers if r.access is Access.COMMAND]
        for register in REGISTERS.registers:
            if register.access is not Access.COMMAND:
                value = encoder.registers.read(register.name)
                assert value == register.reset or register.access is Access.READ, register.name
        for _ in range(3):
            written = {}
            for register in settings:
                largest = register.largest if register.largest is not None else (1 << register.width) - 1
                written[register.name] = int(random.integers(0, largest + 1))
                encoder.registers.write(register.name, written[register.name])
            assert {name: encoder.registers.read(name) for name in written} == written
        for register in commands:
            if register.name != "trial":
                encoder.registers.write(register.name, 1)


def test_what_cannot_be_written_is_refused_by_the_gateware_and_changes_nothing(make_twin):
    with make_twin() as twin, Encoder(twin.port) as encoder:
        link = encoder.registers._link
        known = {address for entry in (*REGISTERS.registers, *REGISTERS.windows) for address in entry.addresses}
        before = {r.name: encoder.registers.read(r.name) for r in REGISTERS.registers if r.access is Access.WRITE}
        for address in sorted({address + 1 for address in known} - known)[:40]:
            assert link.read_words(address, 1, "read of nothing") == [UNKNOWN_WORD]
            assert refusal(link, address, [1]) is Status.UNKNOWN_ADDRESS
        for register in REGISTERS.registers:
            if register.access is Access.READ:
                assert refusal(link, register.address, [0] * register.words) is Status.READ_ONLY, register.name
        for window in REGISTERS.windows:
            assert refusal(link, window.address, [1]) is Status.NOT_NOW
        assert before == {name: encoder.registers.read(name) for name in before}


def refusal(link, address, words) -> Status | None:
    try:
        link.write_words(address, words, "write")
    except RequestRefused as refused:
        return refused.status
    except InstrumentError as error:
        raise AssertionError(f"{address:#x}: {error}") from error
    return None


def test_a_snapshot_is_the_truth_of_its_instant(make_twin):
    with make_twin(speed_rps=60.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        for speed_rps in (60.0, -60.0, 10.0, -0.5):
            twin.set_speed(speed_rps)
            snapshots = [encoder.snapshot() for _ in range(30)]
            sample = np.array([round(snapshot.time_s * 8e8) for snapshot in snapshots])
            raw = np.array([snapshot.raw_position for snapshot in snapshots])
            assert np.all(np.diff(sample) > 0)
            assert_counts(twin, sample, raw)
            assert [snapshot.position for snapshot in snapshots] == twin.rom.correct(raw).tolist()
            assert all(snapshot.homed for snapshot in snapshots)
        assert encoder.registers.index_count >= 1
        assert encoder.registers.closure_error == 0


def test_the_spi_frame_is_not_touched_by_the_uart(make_twin):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        position = encoder.position
        for counter in range(20):
            encoder.registers.strobe_period = counter
            data = twin.read_spi(SpiPlan.back_to_back(1))[0]["data"].tobytes()
            frame = PositionFrame.decode(data)
            assert (frame.position, frame.homed, frame.frame_counter) == (position, True, counter)
            assert data == PositionFrame.of_position(position, flags=frame.flags, frame_counter=counter).encode()
