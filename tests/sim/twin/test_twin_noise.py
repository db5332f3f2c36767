"""A bad cable between host and gateware: no wrong value, and the link works at the next packet."""

import os
import random as standard_random
import time

import numpy as np
import pytest
from twin_truth import assert_counts, wait_until_homed

from arcref import Encoder
from arcref.instrument.snapshot import Snapshot
from arcref.link import link
from arcref.link.packet import Kind, Packet
from arcref.link.registers import MAGIC, REGISTERS
from arcref_sim.twin.noisy_wire import noisy_wire


def test_noise_brings_no_wrong_value(make_twin, random):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        assert encoder.identity.sample_rate_hz == 8e8
        twin.call(setattr, twin, "change_bytes", noisy_wire(1, 1e-3))
        for _ in range(150):
            value = int(random.integers(0, 1 << 16))
            encoder.registers.strobe_delay = value
            assert encoder.registers.strobe_delay == value
            snapshot: Snapshot = encoder.snapshot()
            assert_counts(twin, round(snapshot.time_s * 8e8), snapshot.raw_position)
        encoder.registers.strobe_delay = 0
        twin.call(setattr, twin, "change_bytes", noisy_wire(2, 2e-4))
        twin.set_strobe(50_000)
        captures = encoder.capture(1500)
        assert_counts(twin, captures["time_samples"], captures["raw_position_counts"])
        assert np.array_equal(captures["position_counts"], twin.rom.correct(captures["raw_position_counts"]))
        # What was lost on the wire shows as a gap of unknown length, and nowhere else is a capture missing.
        step = np.diff(np.round(captures["time_samples"] / (8e8 / 50_000)).astype(int))
        assert np.array_equal(step != 1, captures["lost_before"][1:] == -1)
        assert (captures["lost_before"][1:] != 0).any()


NUMBER = 1_000_000 if os.environ.get("ARCREF_LONG") else 30_000


def test_random_bytes_change_nothing_and_the_next_packet_is_obeyed(make_twin):
    rng = standard_random.Random(8)
    with make_twin() as twin, Encoder(twin.port) as encoder:
        writable = [r.name for r in REGISTERS.registers if r.access.name == "WRITE"]
        before = {name: encoder.registers.read(name) for name in writable}
        link_of_host, requests = encoder.registers._link, []
        send = link_of_host._send
        obeyed = encoder.registers.link_state
        link_of_host._send = lambda wire, what: (requests.append(what), send(wire, what))
        for _ in range(NUMBER // 500):
            link_of_host._port.write(rng.randbytes(500))
            assert encoder.registers.magic == MAGIC
        assert {name: encoder.registers.read(name) for name in writable} == before
        sent = len(requests) + 1  # with the one that asked for `obeyed`
        # Every request was obeyed, those right behind noise too; the last one may have been repeated for its answer.
        assert sent <= (encoder.registers.link_state - obeyed) % 65536 < sent + link.ATTEMPTS
        assert encoder.registers.packets_refused > 0


def test_packets_cut_short_or_doubled_cost_only_themselves(make_twin):
    rng = standard_random.Random(9)
    with make_twin() as twin, Encoder(twin.port) as encoder:
        address = REGISTERS["strobe_delay"].address.to_bytes(2, "little")
        port = encoder.registers._link._port
        for number in range(60):
            wire = Packet(Kind.WRITE, 200 + number % 50, address + bytes([number, 1])).encode()
            cut = rng.randrange(1, len(wire) - 1)
            port.write(b"\0" + wire[:cut] + wire[:cut] + b"\0")
            encoder.registers.strobe_delay = number
            assert encoder.registers.strobe_delay == number
            port.write(wire + wire)
            assert encoder.registers.strobe_delay == 256 + number


def test_a_host_is_patient_with_a_slow_instrument(make_twin):
    """Ten times slower than it is already, and yet every request is answered."""
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        run = twin.core.run

        def slowly(changes, sent):
            time.sleep(0.05)
            return run(changes, sent)

        twin.call(setattr, twin.core, "run", slowly)
        assert encoder.registers.magic == MAGIC
        snapshot = encoder.snapshot()
        assert_counts(twin, round(snapshot.time_s * 8e8), snapshot.raw_position)
        assert link.ANSWER_TIMEOUT_S * link.ATTEMPTS >= 1.0


@pytest.mark.parametrize("pause_s", [0.05])
def test_a_twin_that_sleeps_wakes_with_the_next_byte(make_twin, pause_s):
    with make_twin(sleep_after_s=pause_s) as twin, Encoder(twin.port) as encoder:
        standard_random.seed(1)
        for _ in range(5):
            before = twin.status().time_s
            time.sleep(8 * pause_s)
            asleep = twin.status()
            assert asleep.sleeping
            assert asleep.time_s - before < 0.1
            assert encoder.registers.magic == MAGIC
