"""The optics of the synthetic encoder: what two heads cancel, what the signals do, and the square waves they end in."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion
from arcref_sim.optics.grating_disc import GratingDisc
from arcref_sim.optics.optical_encoder import Interpolator, OpticalEncoder

IDEAL = SignalModel.ideal()
ANGLES = np.linspace(0, 360, 20_011)

FAULTY = SignalModel(
    ChannelModel(0.004, {1: Harmonic(1.0, 0.0), 3: Harmonic(0.005, 0.3), 5: Harmonic(0.001, -0.2)}),
    ChannelModel(-0.003, {1: Harmonic(0.997, np.pi / 2 + 0.002), 3: Harmonic(0.004, 1.9), 5: Harmonic(0.001, 1.2)}),
)


def test_one_head_shows_eccentricity_and_two_cancel_every_odd_order():
    disc = GratingDisc(eccentricity_um=4.0, harmonics=((3, 0.5, 20.0), (5, 0.4, 50.0)))
    one = OpticalEncoder(disc, IDEAL, (30.0,)).error_arcsec(ANGLES)
    # 4 um of 95 mm are 8.685 arcsec.
    assert np.abs(one).max() == pytest.approx(8.685, abs=0.9)
    assert np.abs(OpticalEncoder(disc, IDEAL, (30.0, 210.0)).error_arcsec(ANGLES)).max() < 1e-9


def test_even_orders_stay_whole():
    disc = GratingDisc(eccentricity_um=4.0, ellipse_arcsec=1.5, ellipse_deg=10.0, harmonics=((4, 0.5, 20.0),))
    error = OpticalEncoder(disc, IDEAL).error_arcsec(ANGLES)
    angle = np.radians(ANGLES)
    expected = 1.5 * np.sin(2 * angle + np.radians(10)) + 0.5 * np.sin(4 * angle + np.radians(20))
    assert np.abs(error - expected).max() < 1e-9


def test_an_eccentric_disc_weakens_the_sum_of_the_heads():
    disc = GratingDisc(eccentricity_um=20.0)
    encoder = OpticalEncoder(disc, IDEAL)
    amplitude = np.hypot(*encoder.signals_v(ANGLES))
    least = np.cos(2 * np.pi * disc.eccentricity_arcsec / (1296000 / 4096))
    assert amplitude.min() == pytest.approx(least, rel=1e-4)
    assert amplitude.max() == pytest.approx(1.0)
    with pytest.raises(ValueError, match="too eccentric"):
        OpticalEncoder(GratingDisc(eccentricity_um=36.4), IDEAL).error_arcsec(ANGLES)


def test_on_a_perfect_disc_the_error_is_that_of_the_signals():
    encoder = OpticalEncoder(GratingDisc(), FAULTY)
    line_deg = np.linspace(0, 360, 401)
    expected = FAULTY.error_arcsec(np.radians(line_deg))
    assert np.abs(encoder.error_arcsec(777 * 360 / 4096 + line_deg / 4096) - expected).max() < 1e-6
    # The count is zero where the signals' own phase is the mean of their error.
    at_reading = FAULTY.error_at_reading_arcsec(np.radians(line_deg) + FAULTY.mean_error_rad)
    within = encoder.within_line_arcsec(line_deg)
    assert np.ptp(within - at_reading) < 1e-6


def test_the_straight_pieces_of_the_square_waves_follow_the_optics():
    rng = np.random.default_rng(1)
    disc = GratingDisc(3.0 * 30, 2.0, 40.0, 1.0, 70.0, ((4, 0.5, 0.0),), 0.02 * rng.standard_normal(4096))
    encoder = OpticalEncoder(disc, FAULTY)
    graduation = encoder.graduation()
    reading = rng.uniform(0, COUNTS_PER_TURN, 20_000)
    exact = encoder.true_deg(reading * (360 / COUNTS_PER_TURN)) * (COUNTS_PER_TURN / 360)
    assert np.abs(graduation.true_at_reading(reading) - exact).max() * 0.1545 < 0.005
    same = np.floor(graduation.reading_at(exact + 0.5)) == encoder.count((exact + 0.5) * 360 / 2**23)
    assert same.mean() > 0.98


@pytest.mark.parametrize("conversion_rate_hz", [0.0, 40e6])
def test_hysteresis_holds_the_count_until_the_shaft_has_come_back(conversion_rate_hz):
    """There and back over 200 counts: in reverse each count is left 5 counts later."""
    chip = Interpolator(conversion_rate_hz=conversion_rate_hz, hysteresis_counts=5.0)
    motion = Motion(0.5).ramp(0.05, 1e-7).constant_speed(0.05, turns=200 / COUNTS_PER_TURN)
    motion = motion.constant_speed(-0.05, turns=150 / COUNTS_PER_TURN)
    encoder = SyntheticEncoder(motion, 100e6, waves=chip.waves())
    piece = encoder.whole()
    sample = np.arange(0, encoder.number_of_samples, 997)
    true = encoder.true_angle_at(sample)
    highest = np.maximum.accumulate(true)
    expected = np.clip(highest, true, true + 5.0)
    lag = 0.05 * COUNTS_PER_TURN / conversion_rate_hz if conversion_rate_hz else 0.0
    off = piece.count_at(sample) - np.floor(expected)
    assert np.abs(off).max() <= 1 + lag
    assert np.mean(off == 0) > 0.95
    assert piece.count_at(sample[-1]) - true[-1] == pytest.approx(5.0, abs=1.1)


def test_without_hysteresis_nothing_changes():
    motion = Motion(0.5).constant_speed(0.05, turns=1e-5).constant_speed(-0.05, turns=1e-5)
    one, other = (
        SyntheticEncoder(motion, 100e6, waves=Interpolator(hysteresis_counts=h).waves()).whole() for h in (0.0, 1e-9)
    )
    assert np.array_equal(one.count, other.count)
    with pytest.raises(ValueError, match="hysteresis"):
        Interpolator(hysteresis_counts=-1.0).waves()
