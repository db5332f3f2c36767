import numpy as np
import pytest

from arcref.calibration.harmonics import harmonics
from arcref.calibration.periodogram_test import fisher_g_p, order_share, single_order_p
from arcref.error_curve import ErrorCurve

# order: amplitude in arcsec, phase in degrees
TERMS = {1: (1.5, 20.0), 2: (0.6, -100.0), 4: (0.3, 170.0), 5: (0.2, 75.0)}


def waves(angle_deg):
    return 0.7 + sum(
        amplitude * np.cos(np.radians(order * np.asarray(angle_deg) - phase))
        for order, (amplitude, phase) in TERMS.items()
    )


@pytest.mark.parametrize("faces", [11, 12, 17, 24, 36, 72])
@pytest.mark.parametrize("start_deg", [0.0, 33.3])
def test_known_waves_are_found(faces, start_deg):
    angle = start_deg + np.arange(faces) * 360 / faces
    found = harmonics(ErrorCurve(angle, waves(angle)))
    assert found.order.tolist() == list(range(1, faces // 2 + 1))
    assert found.mean_arcsec == pytest.approx(0.7, abs=1e-12)
    for order, amplitude, phase in zip(found.order, found.amplitude_arcsec, found.phase_deg, strict=True):
        expected, expected_phase = TERMS.get(int(order), (0, None))
        assert amplitude == pytest.approx(expected, abs=1e-12)
        if expected:
            assert phase == pytest.approx(expected_phase, abs=1e-9)
    assert found.power_arcsec2.sum() == pytest.approx(waves(angle).var(), rel=1e-12)
    assert found.share.sum() == pytest.approx(1)


def test_half_the_faces_order_shows_one_phase():
    angle = 10 + np.arange(24) * 15.0
    found = harmonics(ErrorCurve(angle, np.cos(np.radians(12 * angle - 120 + 40)), np.full(24, 0.5)))
    assert found.unseen_phase.tolist() == [False] * 11 + [True]
    assert found.amplitude_arcsec[-1] == pytest.approx(np.cos(np.radians(40)))
    assert found.power_arcsec2[-1] == pytest.approx(np.cos(np.radians(40)) ** 2)
    assert found.u_amplitude_arcsec[-1] == pytest.approx(0.5 / np.sqrt(24))
    assert found.u_amplitude_arcsec[:-1] == pytest.approx(np.full(11, 0.5 * np.sqrt(2 / 24)))


def test_unequal_distances_tell_fewer_orders_apart_but_these_exactly():
    angle = np.arange(30) * 10.0  # of 36 faces, six in a row were not read
    found = harmonics(ErrorCurve(angle, waves(angle)))
    assert 5 <= found.order.size < 15
    for order, (amplitude, phase) in TERMS.items():
        index = found.index(order)
        assert found.amplitude_arcsec[index] == pytest.approx(amplitude, abs=1e-9)
        assert found.phase_deg[index] == pytest.approx(phase, abs=1e-6)
    assert found.index(15) is None


def test_uncertainty_of_the_amplitudes_is_that_of_many_draws():
    random = np.random.default_rng(3)
    angle = np.sort((np.arange(24) + random.uniform(-0.3, 0.3, 24)) * 15)
    u = random.uniform(0.05, 0.2, 24)
    first = harmonics(ErrorCurve(angle, waves(angle), u))
    drawn = [harmonics(ErrorCurve(angle, waves(angle) + u * random.standard_normal(24))) for _ in range(1500)]
    for stated, name in ((first.u_cosine_arcsec, "cosine_arcsec"), (first.u_sine_arcsec, "sine_arcsec")):
        assert stated == pytest.approx(np.std([getattr(one, name) for one in drawn], axis=0), rel=0.1)


def test_an_arc_has_no_harmonics_of_the_turn():
    angle = np.arange(0.0, 41.0)
    found = harmonics(ErrorCurve(angle, waves(angle), arc_deg=(0.0, 40.0)))
    assert found.order.size == 0
    assert fisher_g_p(found) == 1.0
    assert single_order_p(found, 1) is None


@pytest.mark.parametrize("faces", [12, 23, 24])
def test_chances_are_those_of_noise(faces):
    """Among noise alone, a chance below p comes up a part p of the time: Fisher's g, and an order named beforehand."""
    random = np.random.default_rng(8)
    angle = np.arange(faces) * 360 / faces
    found = [harmonics(ErrorCurve(angle, random.standard_normal(faces))) for _ in range(1000)]
    for chances in ([fisher_g_p(one) for one in found], [single_order_p(one, 4) for one in found]):
        for p in (0.05, 0.2, 0.5):
            # Four standard deviations of a count of 1000.
            assert np.mean(np.array(chances) < p) == pytest.approx(p, abs=4 * np.sqrt(p * (1 - p) / 1000))


def test_chance_of_many_orders_keeps_its_digits():
    angle = np.arange(360) * 1.0
    found = harmonics(ErrorCurve(angle, np.random.default_rng(1).standard_normal(360)))
    assert 0 < fisher_g_p(found) < 1
    loud = harmonics(ErrorCurve(angle, np.cos(np.radians(7 * angle)) + np.random.default_rng(1).standard_normal(360)))
    # One term of the sum is left when one order has most of the power.
    share = order_share(loud, 7)
    assert share > 0.25
    assert fisher_g_p(loud) == pytest.approx(179 * (1 - share) ** 178, rel=1e-6)


def test_no_wave_at_all():
    found = harmonics(ErrorCurve(np.arange(24) * 15.0, np.zeros(24)))
    assert not found.share.any()
    assert fisher_g_p(found) == 1.0
