"""Captures over the pseudo-terminal, each of them held against the shaft's truth."""

import os
from contextlib import contextmanager

import numpy as np
import pytest
from twin_truth import assert_captures, assert_counts, wait_until, wait_until_homed

from arcref import Encoder
from arcref.link.registers import STROBE_SOURCES
from arcref_gateware.connected_encoder import CAPTURE_DEPTH

MANY = 100_000
"""Captures of the long run."""


def pin_captures_are_those_of_the_strobes(twin, captures) -> None:
    """Every strobe from the first capture to the last has its capture, at its very sample."""
    strobes = np.array(twin.call(lambda: list(twin.strobe_samples)))
    time = captures["time_samples"]
    first = np.searchsorted(strobes, time[0])
    assert np.array_equal(time, strobes[first : first + len(time)])


@pytest.mark.parametrize("speed_rps", [10.0, -60.0])
def test_captures_at_a_rate_are_all_there_and_true(make_twin, speed_rps):
    with make_twin(speed_rps=speed_rps) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_strobe(90_000)
        captures = encoder.capture(1500)
        assert_captures(twin, captures)
        pin_captures_are_those_of_the_strobes(twin, captures)


def test_captures_while_the_speed_changes_and_at_random_instants(make_twin):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_strobe(50_000, is_random=True)
        twin.set_speed(-25.0, 5e3)
        captures = encoder.capture(1500)
        assert_captures(twin, captures)
        pin_captures_are_those_of_the_strobes(twin, captures)
        assert np.ptp(np.diff(captures["raw_position_counts"])) > 100


def test_registers_are_read_while_captures_stream(make_twin):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_strobe(60_000)
        stream, captures = encoder.stream(30.0), []
        for pair in stream:
            captures.append(pair)
            if len(captures) % 100 == 0:
                snapshot = encoder.snapshot()
                assert_counts(twin, round(snapshot.time_s * 8e8), snapshot.raw_position)
            if len(captures) == 1000:
                break
        stream.close()
        assert not any(lost for lost, _ in captures)


def test_the_timer_and_the_command_capture_without_a_pin(make_twin):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        encoder.registers.strobe_control = STROBE_SOURCES.index("timer")
        encoder.registers.strobe_period = 4001
        captures = encoder.capture(300)
        assert_captures(twin, captures)
        assert np.all(np.diff(captures["time_samples"]) == 4001 * 4)
        with started_stream(twin, encoder) as (stream, _):
            encoder.registers.strobe_control = STROBE_SOURCES.index("command")
            for _ in range(5):
                before = encoder.snapshot()
                encoder.registers.strobe_command = 1
                _, record = next(stream)
                assert record.time > before.time_s * 8e8
                assert_counts(twin, record.time, record.raw)


@contextmanager
def started_stream(twin, encoder):
    """A stream that has begun, with no capture under way: the stream, and how many captures there were."""
    encoder.registers.strobe_control = STROBE_SOURCES.index("pin")
    stream = encoder.stream(30.0)
    twin.set_strobe(5000)
    next(stream)
    twin.set_strobe(0)
    encoder.snapshot()  # long enough for the last one to be counted
    number = encoder.registers.captures
    for _ in range(number - 1):
        next(stream)
    yield stream, number
    stream.close()


def test_a_burst_at_full_word_rate_tells_exactly_how_many_were_lost(make_twin):
    burst = 2000
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        with started_stream(twin, encoder) as (stream, earlier):
            before = twin.encoder.strobes.number
            twin.burst(burst)
            pairs = [next(stream) for _ in range(CAPTURE_DEPTH)]
            wait_until(lambda: encoder.registers.captures == earlier + burst)
            lost_in_fifo = encoder.registers.captures_lost
            while len(pairs) + lost_in_fifo < burst:
                pairs.append(next(stream))
            # The next one tells what was lost after the last one kept.
            twin.burst(1)
            pairs.append(next(stream))
        assert sum(lost for lost, _ in pairs) == lost_in_fifo == burst + 1 - len(pairs)
        assert lost_in_fifo > burst - 2 * CAPTURE_DEPTH
        times, raw = (np.array([getattr(record, name) for _, record in pairs]) for name in ("time", "raw"))
        strobes = np.array(twin.call(lambda: list(twin.strobe_samples)))[before:]
        assert len(strobes) == burst + 1
        assert np.array_equal(strobes[np.searchsorted(strobes, times)], times)
        assert np.array_equal(np.diff(np.searchsorted(strobes, times)) - 1, [lost for lost, _ in pairs[1:]])
        assert_counts(twin, times, raw)


@pytest.mark.skipif(not os.environ.get("ARCREF_LONG"), reason="minutes: set ARCREF_LONG=1")
@pytest.mark.long
@pytest.mark.parametrize(("baud", "rate_hz"), [(25_000_000, 90_000), (3_000_000, 12_000)])
def test_a_hundred_thousand_captures_in_a_row_are_true(make_twin, baud, rate_hz):
    with make_twin(speed_rps=10.0, baud=baud) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_strobe(rate_hz)
        captures = encoder.capture(MANY)
        assert len(captures) == MANY
        assert_captures(twin, captures)
        pin_captures_are_those_of_the_strobes(twin, captures)
        assert np.ptp(captures["raw_position_counts"]) > 5 * 2**23
