"""The encoder's own error and the way back to the truth."""

import numpy as np
import pytest

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref_sim.graduation import GraduationError


@pytest.fixture
def wave() -> GraduationError:
    """A few arc seconds over the turn, and half of one within each line."""
    return GraduationError.from_curve(
        lambda deg: 3 * np.sin(np.radians(deg)) + 0.5 * np.sin(np.radians(4096 * deg)), knots=1 << 18
    )


def test_reading_and_truth_are_inverse(wave, random):
    reading = random.uniform(-3, 3, 5000) * COUNTS_PER_TURN
    true = wave.true_at_reading(reading)
    np.testing.assert_allclose(wave.reading_at(true), reading, atol=1e-6, rtol=0)
    np.testing.assert_allclose(wave.error_at(true), reading - true, atol=1e-6)


def test_a_row_of_counts_is_the_same_as_one_by_one(wave):
    for first in (-70_000, -1, 0, 5, COUNTS_PER_TURN - 100):
        row = wave.true_at_counts(first, 3000)
        np.testing.assert_allclose(row, wave.true_at_reading(np.arange(first, first + 3000.0)), atol=1e-6, rtol=0)


def test_the_error_is_the_curve_given(network, random):
    graduation = GraduationError.from_curve(network.evaluate)
    true = random.uniform(0, COUNTS_PER_TURN, 2000)
    error_arcsec = graduation.error_at(true) * ARCSEC_PER_COUNT
    np.testing.assert_allclose(error_arcsec, network.evaluate(true * 360 / COUNTS_PER_TURN), atol=1e-5)


def test_the_perfect_encoder_reads_the_truth():
    assert GraduationError.none().reading_at(12.75) == 12.75
    assert GraduationError.none().true_at_counts(-2, 3).tolist() == [-2, -1, 0]


def test_an_error_that_turns_back_is_refused():
    with pytest.raises(ValueError, match="too steeply"):
        GraduationError(np.where(np.arange(8192) % 2, 700.0, 0.0))
    with pytest.raises(ValueError, match="divide"):
        GraduationError(np.zeros(3))
