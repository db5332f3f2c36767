"""The encoder made up as it goes gives what the one planned beforehand gives, and knows where it is."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.faults import slip
from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.square_waves import SquareWaves
from arcref_sim.twin.live_encoder import LiveEncoder
from arcref_sim.twin.live_motion import LiveMotion

RATE_HZ = 8e8
WORDS = 1 << 11


def live(start=-5000.5, speed_rps=10.0, **options) -> LiveEncoder:
    return LiveEncoder(LiveMotion(start, speed_rps), RATE_HZ, 4, **options)


def samples_of(encoder: LiveEncoder, pieces: int) -> np.ndarray:
    return np.concatenate([encoder.next_piece(WORDS)[0].changes.to_samples() for _ in range(pieces)])


@pytest.mark.parametrize("speed_rps", [10.0, -3.7, 60.0])
@pytest.mark.parametrize("waves", [SquareWaves(), SquareWaves(delay_ns=5000, a_duty=0.45), SquareWaves(jitter_ns=0.5)])
def test_one_speed_gives_the_samples_of_a_planned_motion(speed_rps, waves):
    error = GraduationError(20 * np.sin(np.arange(64)))
    encoder = live(-5000.5 if speed_rps > 0 else 5000.5, speed_rps, graduation=error, waves=waves, seed=3)
    duration_s = 40 * WORDS * 4 / RATE_HZ
    motion = Motion(encoder.motion.start_counts).constant_speed(speed_rps, duration_s)
    planned = SyntheticEncoder(motion, RATE_HZ, error, waves, seed=3).whole().changes.to_samples()
    made = samples_of(encoder, 40)
    if waves.jitter_ns:
        # Another row of random numbers: the same edges, each within its jitter.
        assert np.mean(made != planned) < 0.2
        return
    differing = np.flatnonzero(made != planned)
    # An edge that falls on a sample to the last digit may be seen one sample apart.
    assert len(differing) <= 2
    assert np.array_equal(encoder.ideal_count_at(np.arange(100, len(made), 1001)) & 3, counts_of(made)[100::1001])


def counts_of(samples) -> np.ndarray:
    return np.array([2, 3, 1, 0])[samples & 3]


def test_a_change_of_speed_keeps_the_place_and_the_truth():
    random = np.random.default_rng(5)
    encoder = live()
    for _ in range(60):
        encoder.set_speed(random.uniform(-40, 40), random.choice([None, 1e5, 1e6, 1e7]))
        for _ in range(3):
            piece, _ = encoder.next_piece(WORDS)
            assert np.abs(np.diff(piece.count)).max(initial=0) <= 1
            at = piece.count_sample[1:]
            near = encoder.ideal_count_at(at)
            # At an edge itself the count may be that on either side.
            assert np.abs(near - piece.count[1:]).max(initial=0) <= 1
            middle = (at[:-1] + at[1:]) // 2
            middle = middle[np.diff(at) > 4]
            assert np.array_equal(encoder.ideal_count_at(middle), piece.count_at(middle))


def test_an_acceleration_through_standstill_reaches_its_speed():
    motion = LiveMotion(0.0, 10.0)
    motion.set_speed(1.0, -10.0, 20.0)
    assert motion.speed_rps_at(1.5) == pytest.approx(0.0, abs=1e-9)
    assert motion.speed_rps_at(2.5) == pytest.approx(-10.0)
    assert motion.true_counts_at(1.5) == pytest.approx(12.5 * COUNTS_PER_TURN)
    assert motion.true_counts_at(2.0) == pytest.approx(10 * COUNTS_PER_TURN)


def test_a_shaft_at_rest_makes_no_edge():
    encoder = live(speed_rps=0.0)
    for _ in range(5):
        assert len(encoder.next_piece(WORDS)[0].changes.time) == 1
    encoder.set_speed(10.0)
    assert len(encoder.next_piece(WORDS)[0].changes.time) > 100


def test_a_slip_stays_for_ever():
    clean, slipped = live(), live()
    slipped.add_faults(slip(WORDS * 4 + 100, 2))
    for piece in range(6):
        first, second = (encoder.next_piece(WORDS)[0].changes.to_samples() for encoder in (clean, slipped))
        assert np.array_equal(first[200:] ^ second[200:], np.full(len(first) - 200, 3 if piece else 0))


def test_a_missing_zero_mark_and_one_too_many():
    for direction in (1, -1):
        encoder = live(-1000.5 * direction, 10.0 * direction)
        encoder.next_piece(4)
        encoder.drop_next_zero_mark()
        encoder.add_zero_mark(3000)
        samples = samples_of(encoder, 8)
        place = np.flatnonzero(samples & 4)
        assert len(place)
        true = encoder.motion.true_counts_at((place + 16) / RATE_HZ)
        assert np.all(np.abs(true - 2000 * direction) < 20)
        assert np.all(samples[place] & 3 == 3), "it stands in the gate state"


def test_strobes_come_at_their_rate_and_bursts_right_after_one_another():
    encoder = live()
    encoder.strobes.set_rate(0, 50_000)
    rises = [rise for _ in range(100) for rise in encoder.next_piece(WORDS)[1]]
    assert np.all(np.abs(np.diff(rises) - RATE_HZ / 50_000) <= 1)
    encoder.strobes.set_rate(encoder.sample, 50_000, is_random=True)
    rises = np.array([rise for _ in range(400) for rise in encoder.next_piece(WORDS)[1]])
    assert len(rises) == pytest.approx(400 * WORDS * 4 * 50_000 / RATE_HZ, rel=0.3)
    assert np.std(np.diff(rises)) > 0.5 * RATE_HZ / 50_000
    encoder.strobes.set_rate(0, 0)
    encoder.strobes.burst(encoder.sample, 700, 4)
    piece, rises = encoder.next_piece(WORDS)
    strobe = piece.changes.to_samples() >> 3 & 1
    assert np.array_equal(np.flatnonzero(np.diff(strobe, prepend=0) == 1) + piece.changes.start, rises)
    assert len(rises) == 700


@pytest.mark.parametrize("rate_hz", [-1.0, 3e8])
def test_strobes_that_would_meet_are_refused(rate_hz):
    with pytest.raises(ValueError, match="must lie in 0 .. 2e"):
        live().strobes.set_rate(0, rate_hz)
