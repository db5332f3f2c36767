"""The true angle and its inverse, for every kind of motion."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.motion import Motion

MOTIONS = {
    "constant speed": Motion(-100.0).constant_speed(10, turns=0.01),
    "reverse": Motion(3.25).constant_speed(-63.48, turns=0.01),
    "ramp from rest": Motion().ramp(20, 0.002),
    "ramp through zero": Motion().constant_speed(10, duration_s=1e-5).ramp(-30, 0.004),
    "ramp to rest and on": Motion().ramp(5, 1e-3).ramp(0, 1e-3).standstill(1e-4).ramp(-5, 1e-3),
    "to and fro": Motion(1e6).swing(40000, 250, cycles=2.3),
    "reverse first": Motion(-7.5).swing(-3.7, 1000, cycles=1.75),
}


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_time_is_the_inverse_of_place(motion):
    for start_s, segment in zip(motion.start_times_s, motion.segments, strict=True):
        if segment.direction == 0:
            continue
        time_s = np.linspace(0, segment.duration_s, 1001)
        counts = segment.counts_at(time_s)
        assert np.all(np.diff(counts) * segment.direction >= -1e-9)
        again = segment.counts_at(segment.time_at(counts))
        np.testing.assert_allclose(again, counts, atol=1e-6, rtol=0)
        np.testing.assert_allclose(motion.true_counts_at(start_s + time_s), counts, atol=1e-4, rtol=0)


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_segments_join(motion):
    joints = motion.start_times_s[1:]
    before, after = motion.true_counts_at(joints - 1e-12), motion.true_counts_at(joints + 1e-12)
    np.testing.assert_allclose(before, after, atol=0.01)


def test_a_ramp_covers_its_mean_speed():
    motion = Motion().ramp(20, 0.5)
    assert motion.end_counts == pytest.approx(5 * COUNTS_PER_TURN)
    assert motion.end_speed_rps == pytest.approx(20)


def test_a_swing_ends_where_it_began():
    assert Motion(123.0).swing(5000, 10).end_counts == pytest.approx(123.0, abs=1e-6)


def test_constant_speed_wants_one_length():
    with pytest.raises(ValueError, match="either a duration or a number of turns"):
        Motion().constant_speed(10)
    with pytest.raises(ValueError, match="either a duration or a number of turns"):
        Motion().constant_speed(10, 1.0, turns=3)
