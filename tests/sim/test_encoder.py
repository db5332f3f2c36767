"""The synthetic encoder: every edge there, every state legal, the truth consistent, pieces without seams."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref_gateware.golden.signal_changes import QUADRATURE_STATE
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.square_waves import SquareWaves, ZeroMark

RATE_HZ = 800e6
BACK_AND_FORTH = Motion(-500.5).ramp(10, 2e-5).constant_speed(10, duration_s=3e-5).ramp(-20, 5e-5).standstill(1e-6)
CONVERTER = SquareWaves(conversion_interval_ns=2000, shortest_edge_spacing_ns=5)


def counts_from_lines(piece) -> np.ndarray:
    """What a counter makes of the lines: the count after each change, from 0."""
    number = QUADRATURE_STATE[piece.changes.state & 3].astype(int)
    step = (np.diff(number) + 1) % 4 - 1
    assert step.max(initial=0) <= 1
    return np.concatenate(([0], np.cumsum(step)))


@pytest.mark.parametrize(
    "waves",
    [
        SquareWaves(),
        SquareWaves(a_duty=0.6, b_duty=0.45, phase_error_deg=-20),
        SquareWaves(jitter_ns=0.5),
        SquareWaves(jitter_ns=20, shortest_edge_spacing_ns=1.25),
        CONVERTER,
    ],
    ids=["ideal", "duty and phase", "jitter", "much jitter", "converter"],
)
def test_lines_follow_the_count(waves, network):
    graduation = GraduationError.from_curve(network.evaluate)
    piece = SyntheticEncoder(BACK_AND_FORTH, RATE_HZ, graduation, waves).whole()
    seen = counts_from_lines(piece) + piece.count[0]
    np.testing.assert_array_equal(seen, piece.count_at(piece.changes.time))


def test_the_number_of_edges_is_the_way():
    encoder = SyntheticEncoder(Motion(0.5).constant_speed(10, turns=0.01), RATE_HZ)
    piece = encoder.whole()
    assert piece.count[-1] == int(encoder.true_angle_at(piece.changes.end - 1))
    assert np.all(np.diff(piece.count) == 1)
    spacing = np.diff(piece.count_sample)[1:]
    assert set(spacing.tolist()) == {9, 10}  # 9.54 samples from edge to edge


def test_the_ideal_count_is_the_reading_rounded_down(network):
    graduation = GraduationError.from_curve(network.evaluate)
    encoder = SyntheticEncoder(BACK_AND_FORTH, RATE_HZ, graduation)
    sample = np.arange(0, encoder.number_of_samples, 7)
    reading = graduation.reading_at(encoder.true_angle_at(sample))
    count = encoder.whole().count_at(sample)
    assert np.all(np.abs(reading - count - 0.5) <= 0.5 + 1e-6)


def test_samples_at_count_are_those_of_the_stream():
    encoder = SyntheticEncoder(Motion(-20.5).constant_speed(5, turns=1e-5).constant_speed(-5, turns=1e-5), RATE_HZ)
    piece = encoder.whole()
    forward, back = encoder.samples_at_count(7)
    assert piece.count_at([forward - 1, forward]).tolist() == [6, 7]
    assert piece.count_at([back - 1, back]).tolist() == [7, 6]
    assert encoder.samples_at_count(10_000) == []


@pytest.mark.parametrize("width", [1, 2, 3, 4, 0.5, 2.7])
@pytest.mark.parametrize("speed_rps", [10, -10])
def test_z_is_as_wide_as_told_and_round_count_0(width, speed_rps):
    start = -50.5 if speed_rps > 0 else 50.5
    mark = ZeroMark(width_states=width)
    encoder = SyntheticEncoder(Motion(start).constant_speed(speed_rps, turns=1e-5), RATE_HZ, zero_mark=mark)
    samples = encoder.whole().changes.to_samples()
    high = np.flatnonzero(samples & 4)
    reading = encoder.true_angle_at(high)
    assert reading.min() >= 0.5 - width / 2 - 1e-6
    assert reading.max() <= 0.5 + width / 2 + 1e-6
    assert abs(len(high) - width * RATE_HZ / (10 * COUNTS_PER_TURN)) <= 1
    assert 7 in samples[high]  # the gate state is among them
    assert np.all(np.diff(high) == 1)


def test_z_comes_each_turn_but_where_it_is_missing():
    mark = ZeroMark(width_states=2, missing_turns=frozenset({1}), extra_counts=(COUNTS_PER_TURN // 2,))
    marks = mark.intervals(-10, 3.0 * COUNTS_PER_TURN)
    assert (marks.mean(axis=1) - 0.5).tolist() == [0, COUNTS_PER_TURN // 2, 2 * COUNTS_PER_TURN, 3 * COUNTS_PER_TURN]
    with pytest.raises(ValueError, match="overlap"):
        ZeroMark(width_states=4, extra_counts=(3,)).intervals(-10, 10)


def test_bunched_edges_keep_their_spacing_and_come_with_conversions():
    encoder = SyntheticEncoder(Motion(0.5).constant_speed(10, turns=1e-3), RATE_HZ, waves=CONVERTER)
    piece = encoder.whole()
    spacing = np.diff(piece.count_sample[1:])
    assert spacing.min() >= 3  # 5 ns are 4 samples, less the rounding to a sample
    conversion = 1600  # samples
    in_conversion = piece.count_sample[1:] % conversion
    assert in_conversion.max() < 170 * 4 + 2  # 168 counts a conversion, then quiet


def test_a_converter_does_not_see_what_lies_between_two_conversions():
    motion = Motion(0.5).standstill(2.1e-6).constant_speed(10, duration_s=0.5e-6).constant_speed(-10, duration_s=0.5e-6)
    piece = SyntheticEncoder(motion.standstill(5e-6), RATE_HZ, waves=CONVERTER).whole()
    assert np.all(piece.count == 0)


@pytest.mark.parametrize("waves", [SquareWaves(), SquareWaves(jitter_ns=8), CONVERTER, SquareWaves(delay_ns=33.3)])
def test_pieces_are_the_run_cut_up(waves):
    encoder = SyntheticEncoder(BACK_AND_FORTH, RATE_HZ, waves=waves, zero_mark=ZeroMark(3), seed=5)
    whole = encoder.whole()
    for samples_per_piece in (4, 1004, 32768) if waves == SquareWaves() else (2004,):
        pieces = list(encoder.pieces(samples_per_piece))
        assert [piece.changes.end for piece in pieces[:-1]] == [piece.changes.start for piece in pieces[1:]]
        joined = np.concatenate([piece.changes.to_samples() for piece in pieces])
        np.testing.assert_array_equal(joined, whole.changes.to_samples())
        sample = np.arange(whole.changes.end)
        counts = np.concatenate([piece.count_at(np.arange(piece.changes.start, piece.changes.end)) for piece in pieces])
        np.testing.assert_array_equal(counts, whole.count_at(sample))


def test_a_standstill_is_one_long_state():
    pieces = list(SyntheticEncoder(Motion(2.5).standstill(1e-4), RATE_HZ).pieces(1 << 14))
    assert [len(piece.changes.time) for piece in pieces] == [1] * len(pieces)
    assert sum(piece.changes.end - piece.changes.start for piece in pieces) == 80_000


def test_faster_than_the_samples_skips_states_but_not_the_truth():
    encoder = SyntheticEncoder(Motion(0.5).constant_speed(300, turns=1e-3), RATE_HZ)  # 3.1 counts a sample
    piece = encoder.whole()
    assert piece.count[-1] == int(encoder.true_angle_at(piece.changes.end - 1))
    assert np.all(np.diff(piece.count_sample) == 1)


def test_impossible_square_waves_are_refused():
    with pytest.raises(ValueError, match="change places"):
        SquareWaves(phase_error_deg=120)
    with pytest.raises(ValueError, match="conversion interval"):
        SquareWaves(a_duty=0.6, conversion_interval_ns=2000)
