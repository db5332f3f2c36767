"""The instrument of a board with its test generator, link and core together, in Verilator, turned by the host."""

from pathlib import Path

import numpy as np
import pytest

from arcref import Encoder
from arcref.angle import COUNTS_PER_TURN
from arcref.flags import FAULT_FLAGS
from arcref_sim.twin.twin import Twin
from arcref_sim.twin.twin_core import CompiledTwin
from arcref_sim.twin.twin_instrument import TwinInstrument

SPEED_RPS = 45.0  # edges at least two samples apart
BAUD = 25_000_000
BUILDS = Path(__file__).parents[3] / "build" / "verilated"


@pytest.fixture(scope="module")
def compiled(rom):
    return CompiledTwin.of(TwinInstrument(rom, 4, word_clock_hz=200e6, baud=BAUD), BUILDS)


@pytest.fixture
def twin(rom, compiled):
    with Twin(rom, compiled=compiled) as instrument:
        yield instrument


@pytest.mark.parametrize("speed_rps", [0.0, 10.0, -10.0])
def test_no_fault_stands_before_anything_happened(rom, compiled, speed_rps):
    with Twin(rom, compiled=compiled, speed_rps=speed_rps) as instrument, Encoder(instrument.port) as encoder:
        assert not encoder.flags & FAULT_FLAGS
        assert encoder.registers.illegal_steps == 0


def test_a_turn_forward_and_back_with_nothing_wired(twin):
    with Encoder(twin.port) as encoder:
        assert encoder.identity.has_test_generator
        result = encoder.zero_return(
            revolutions=1, generator_speed_rps=SPEED_RPS, rom=twin.rom, readings_per_s=1000.0, ask=lambda line: None
        )
        assert encoder.registers.generator_control == 0
    assert result.passed, [check for check in result.checks if not check.passed]
    assert [(index.turn, index.direction, index.closure_error_counts) for index in result.index_passes] == [
        (0, 1, 0),
        (1, 1, 0),
        (1, -1, 0),
        (0, -1, 0),
    ]
    assert result.instrument.driven_by == "test generator"
    assert result.instrument.rom_readings_wrong == 0
    assert result.speed_rps == pytest.approx(SPEED_RPS, rel=1e-3)
    assert result.counts >= 2 * COUNTS_PER_TURN


@pytest.mark.parametrize(
    ("fault", "sentences"),
    [
        ("dropped_edge", {"every closure error is 0"}),
        ("doubled_step", {"every closure error is 0", "no illegal step"}),
        ("missing_index", {"every zero mark was seen"}),
        ("wide_index", {"every closure error is 0"}),
    ],
)
def test_a_fault_of_the_generator_is_found(twin, fault, sentences):
    with Encoder(twin.port) as encoder:
        result = encoder.zero_return(
            revolutions=0,
            generator_speed_rps=SPEED_RPS,
            generator_fault=fault,
            readings_per_s=1000.0,
            ask=lambda line: None,
        )
    assert not result.passed
    failed = {check.sentence for check in result.checks if not check.passed}
    assert failed >= sentences


def test_captures_of_the_generator_come_with_nothing_wired(twin):
    with Encoder(twin.port) as encoder:
        rate = 1 << 28
        encoder.registers.generator_rate = rate
        encoder.registers.generator_control = 1
        captures = encoder.capture(20)
    time = captures["time_samples"].astype(np.int64)
    spacing = np.diff(time)
    assert set(spacing) <= {4 * 2**15 + 1, 4 * 2**15 - 3}
    counts = np.diff(captures["raw_position_counts"].astype(np.int64))
    assert counts == pytest.approx(spacing * rate / 2**32, abs=1)


def test_the_encoder_is_counted_while_the_generator_is_off(twin):
    with Encoder(twin.port) as encoder:
        twin.set_speed(10.0)
        first = encoder.snapshot()
        second = encoder.snapshot()
        assert second.raw_position > first.raw_position
        encoder.registers.generator_control = 1
        stood = {encoder.snapshot().raw_position for _ in range(3)}
        assert len(stood) == 1
