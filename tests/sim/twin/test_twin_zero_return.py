"""The zero-return test for instruments, on the true gateware."""

import re

import pytest

from arcref import Encoder
from arcref.angle import COUNTS_PER_TURN
from arcref_sim.twin.live_faults import add_fault

SPEED_RPS = 10.0

FAR_COUNTS = 100_000
"""Where the shaft turns back, so far past the mark that a fault can be put in before it comes again."""


def zero_return(twin, on_the_way_back=lambda: None, **options):
    """Run it across the mark and back; the twin's shaft turns as the user is asked to."""

    def turn(line):
        if line.startswith("Turn the shaft forward"):
            twin.set_speed(SPEED_RPS)
        if line.startswith("Now turn it back"):
            while twin.status().true_counts < FAR_COUNTS:
                pass
            twin.set_speed(-SPEED_RPS)
            on_the_way_back()

    with Encoder(twin.port) as encoder:
        return encoder.zero_return(revolutions=0, ask=turn, readings_per_s=1000.0, rom=twin.rom, **options)


def test_the_mark_comes_back_on_its_count(make_twin):
    with make_twin() as twin:
        result = zero_return(twin)
    assert result.passed, [check for check in result.checks if not check.passed]
    assert [(index.turn, index.direction, index.closure_error_counts) for index in result.index_passes] == [
        (0, 1, 0),
        (0, -1, 0),
    ]
    assert result.instrument.rom_readings_wrong == 0
    assert result.speed_rps == pytest.approx(SPEED_RPS, rel=0.01)
    assert result.counts < COUNTS_PER_TURN


@pytest.mark.parametrize(
    ("fault", "number", "sentence", "found"),
    [
        ("drop", 2, "every closure error is 0", "8 counts"),
        ("illegal", 3, "no illegal step", "[1-9]"),
        ("index-missing", None, "every zero mark was seen", "1 of 2; missing: turn 0 reverse"),
    ],
)
def test_a_fault_of_the_signals_fails_and_is_named(make_twin, fault, number, sentence, found):
    with make_twin() as twin:
        result = zero_return(twin, lambda: twin.call(add_fault, twin.encoder, fault, number))
    assert not result.passed
    (check,) = [check for check in result.checks if check.sentence == sentence]
    assert not check.passed
    assert re.fullmatch(found, check.found.lstrip("-"))
    assert result.instrument.faults


def test_rehome_moves_the_zero_of_the_gateware(make_twin):
    with make_twin(speed_rps=SPEED_RPS) as twin:
        with Encoder(twin.port) as encoder:
            while not encoder.snapshot().homed:
                pass
        twin.set_speed(-SPEED_RPS)
        while twin.status().true_counts > -10_000:
            pass
        result = zero_return(twin, rehome=True)
    assert result.index_passes[0].homes
    assert result.passed, [check for check in result.checks if not check.passed]
