"""The encoder of the simulated runs is what it says: reading, truth and count agree at every angle."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder


@pytest.fixture
def encoder():
    terms = (Harmonic(1, 40.0, 20.0), Harmonic(8, 1.5, -70.0), Harmonic.within_line(2, 0.4, 10.0))
    return KnownEncoder(terms, lambda angle_deg: 0.1 * np.cos(np.radians(angle_deg)), 0.3, 0.1)


def test_the_error_is_the_sum_of_its_terms():
    encoder = KnownEncoder((Harmonic(2, 3.0, 30.0), Harmonic.within_line(1, 1.0, 0.0)))
    within_line = np.sin(np.radians(4096 * 30.0))
    assert encoder.error_arcsec([0.0, 30.0]) == pytest.approx([1.5, 3.0 + within_line])
    assert encoder.error_arcsec(360.0 / 4096 / 4) == pytest.approx(1.5 + 1.0, abs=0.003), "a quarter of a line"


@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_reading_and_true_angle_are_inverse_to_each_other(direction, encoder, random):
    true_deg = random.uniform(-400.0, 800.0, 1000)
    back = encoder.true_deg(encoder.reading_deg(true_deg, direction), direction)
    assert np.abs(back - true_deg).max() * 3600 < 1e-8


def test_forward_and_reverse_differ_by_the_hysteresis(encoder):
    angle_deg = np.array([0.0, 90.0, 270.0])
    difference = (encoder.reading_deg(angle_deg, 1) - encoder.reading_deg(angle_deg, -1)) * 3600
    assert difference == pytest.approx([-0.3, -0.4, -0.2])
    assert difference == pytest.approx(encoder.return_error_arcsec(angle_deg))


def test_the_count_is_the_reading_rounded_down(encoder, random):
    true_deg = random.uniform(0.0, 360.0, 1000)
    behind = encoder.reading_deg(true_deg) * COUNTS_PER_TURN / 360 - encoder.count(true_deg)
    assert behind.min() >= 0
    assert behind.max() < 1
    assert behind.mean() == pytest.approx(0.5, abs=0.05)


def test_the_truth_holds_what_evaluates_the_error_anew():
    encoder = KnownEncoder((Harmonic(3, 0.7, 15.0),))
    truth = encoder.truth()
    (term,) = truth["harmonics"]
    again = term["amplitude_arcsec"] * np.sin(np.radians(term["order"] * np.arange(360) + term["phase_deg"]))
    assert truth["error_arcsec"] == pytest.approx(again, abs=1e-6)
