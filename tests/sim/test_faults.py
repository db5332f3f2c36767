"""Faults change the lines where they are put, and nothing else."""

import numpy as np
import pytest

from arcref_sim import faults
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion
from arcref_sim.square_waves import AB_OF_COUNT

RATE_HZ = 800e6
MOTION = Motion(-300.5).constant_speed(10, turns=1e-4)


def samples_with(*lists) -> tuple[np.ndarray, np.ndarray]:
    """Samples of the run with the faults, and without."""
    broken = SyntheticEncoder(MOTION, RATE_HZ, faults=tuple(fault for one in lists for fault in one)).pieces(1000)
    joined = np.concatenate([piece.changes.to_samples() for piece in broken])
    return joined, SyntheticEncoder(MOTION, RATE_HZ).whole().changes.to_samples()


def test_a_slip_moves_a_and_b_against_z():
    broken, clean = samples_with(faults.slip(2003, 1))
    np.testing.assert_array_equal(broken[:2003], clean[:2003])
    np.testing.assert_array_equal(broken & 4, clean & 4)
    count = SyntheticEncoder(MOTION, RATE_HZ).whole().count_at(np.arange(2003, len(clean)))
    np.testing.assert_array_equal(broken[2003:] & 3, AB_OF_COUNT[(count + 1) & 3])


@pytest.mark.parametrize("counts", [4, -4])
def test_a_slip_of_a_period_leaves_no_trace(counts):
    broken, clean = samples_with(faults.slip(3001, counts))
    np.testing.assert_array_equal(broken, clean)


def test_extra_pulses_add_a_whole_period():
    broken, clean = samples_with(faults.extra_pulses(2500, 2))
    np.testing.assert_array_equal(broken[2508:], clean[2508:])
    assert np.count_nonzero(np.diff(broken[2499:2509].astype(int))) >= 4


def test_line_faults_stay_in_their_places():
    broken, clean = samples_with(
        faults.glitch(995, 10), faults.dropped_pulses(4000, 4100), faults.strobe_pulses([7], 3)
    )
    assert np.all((broken ^ clean)[995:1005] == faults.A_LINE)
    assert not np.any(broken[4000:4100] & faults.A_LINE)
    assert np.flatnonzero(broken & faults.STROBE_LINE).tolist() == [7, 8, 9]
    other = np.ones(len(clean), bool)
    other[995:1005] = other[4000:4100] = other[7:10] = False
    np.testing.assert_array_equal(broken[other], clean[other])


def test_double_transitions():
    there_and_back, clean = samples_with(faults.double_transition(1500, 2))
    assert np.flatnonzero(there_and_back ^ clean).tolist() == [1500, 1501]
    for_good, _ = samples_with(faults.double_transition(1500))
    assert np.all((for_good ^ clean)[1500:] == faults.BOTH_LINES)


def test_noise_is_the_same_for_the_same_seed():
    noise = faults.noise_glitches(0, 1000, 20, seed=3)
    assert noise == faults.noise_glitches(0, 1000, 20, seed=3)
    assert noise != faults.noise_glitches(0, 1000, 20, seed=4)
    assert len({glitch.start for glitch in noise}) == 20
