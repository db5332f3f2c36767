"""Samples in time at an uneven speed become samples at equal angles; what the knowledge of the phase is worth."""

import numpy as np
import pytest
from made_signals import UnevenSpeed, in_time
from published_signals import LINE_COUNT, published_signals

from arcref.subdivision.equal_angle_sampling import (
    adaptive_sample_times,
    adaptive_scale_error,
    resample,
    sampling_rate_hz,
    true_phase_over_time,
)
from arcref.subdivision.phase_knowledge import (
    jitter_error_rad,
    left_with_phase_error,
    model_of_samples,
    period_scale_error_rad,
    speed_change_error_rad,
)
from arcref.subdivision.signal_correction import left_after_model
from arcref.subdivision.signal_model import SignalModel, line_phases_rad, wrapped_rad

SIGNALS = published_signals()
FINE = line_phases_rad(512)


def left_after_resampling(model: SignalModel, samples) -> float:
    volts = samples.sine_v.mean(axis=0), samples.cosine_v.mean(axis=0)
    found = model_of_samples(samples.theta_rad, volts, (1, 3, 5), model)
    return float(np.ptp(left_after_model(model, FINE, found)))


def resampled(speed: UnevenSpeed, noise_v: float = 0.0, model: SignalModel = SIGNALS):
    time, sine, cosine = in_time(model, speed, noise_v=noise_v)
    return time, resample(time, sine, cosine, np.unwrap(model.reading_rad(sine, cosine)))


def test_sampling_rate():
    assert sampling_rate_hz(1.0, LINE_COUNT) == 1_048_576
    assert sampling_rate_hz(10.0, LINE_COUNT) == 10_485_760


def test_the_limit_that_phase_knowledge_sets():
    """SCIENCE: 0.1 % of period scale 0.046, 0.5 % 0.23, 1 % 0.45, 1 % of speed change 0.23, jitter 0.1 % 0.075."""

    def left(error) -> float:
        return float(np.ptp(left_with_phase_error(SIGNALS, error)))

    assert left(np.zeros(64)) < 1e-12
    assert left(period_scale_error_rad(1e-3)) == pytest.approx(0.046, rel=0.05)
    assert left(period_scale_error_rad(5e-3)) == pytest.approx(0.23, rel=0.05)
    assert left(period_scale_error_rad(1e-2)) == pytest.approx(0.45, rel=0.05)
    assert left(speed_change_error_rad(1e-2)) == pytest.approx(0.23, rel=0.05)
    generator = np.random.default_rng(1)
    jitter = np.mean([left(jitter_error_rad(1e-3, generator)) for _ in range(200)])
    assert jitter == pytest.approx(0.075, rel=0.15)


@pytest.mark.parametrize("ripple", [0.0, 0.01, 0.1, 0.3])
def test_resampling_undoes_an_uneven_speed(ripple):
    _, samples = resampled(UnevenSpeed(60, ripple))
    assert samples.periods >= 59
    assert left_after_resampling(SIGNALS, samples) < 0.01
    if ripple:
        # The periods themselves were of very different length.
        assert np.ptp(np.diff(samples.mark_s)) > ripple / 60


def test_samples_in_time_taken_for_equal_angles_would_be_useless():
    """What resampling is for: the same samples, each period divided evenly in time by the rate of the one before."""
    speed = UnevenSpeed(60, 0.1)
    time, samples = resampled(speed)
    times = adaptive_sample_times(samples.mark_s)
    sine, cosine = SIGNALS.signals_v(speed.theta_rad(times))
    scale = adaptive_scale_error(samples.mark_s)
    one_period = [
        float(
            np.ptp(left_after_model(SIGNALS, FINE, model_of_samples(line_phases_rad(64), (s, c), (1, 3, 5), SIGNALS)))
        )
        for s, c in zip(sine, cosine, strict=True)
    ]
    expected = [float(np.ptp(left_with_phase_error(SIGNALS, period_scale_error_rad(each)))) for each in scale]
    assert np.abs(scale).max() > 0.01
    assert max(one_period) > 0.4
    assert np.mean(one_period) == pytest.approx(np.mean(expected), rel=0.15)


def test_adaptive_sampling_is_exact_at_an_even_speed():
    marks = 3.0 + 0.25 * np.arange(6)
    times = adaptive_sample_times(marks, 8)
    assert times.shape == (4, 8)
    assert times == pytest.approx(marks[1:5, np.newaxis] + 0.25 * np.arange(8) / 8)
    assert adaptive_scale_error(marks) == pytest.approx(0)


def test_the_phase_over_time_is_found_beneath_the_error_of_the_signals():
    speed = UnevenSpeed(80, 0.05)
    time, sine, cosine = in_time(SIGNALS, speed, noise_v=0.005)
    reading = np.unwrap(SIGNALS.reading_rad(sine, cosine))
    difference = wrapped_rad(true_phase_over_time(time, reading) - speed.theta_rad(time))
    difference -= np.median(difference)
    inside = difference[200:-200]
    assert np.sqrt(np.mean(inside**2)) < 5e-4  # the reading itself is off by 0.02 rad rms
    assert np.std(wrapped_rad(reading - speed.theta_rad(time))) > 0.02


@pytest.mark.parametrize("periods", [2.5, 3.4, 5.2])
def test_few_periods_at_an_even_speed(periods):
    _, samples = resampled(UnevenSpeed(periods))
    assert samples.periods >= 2
    assert left_after_resampling(SIGNALS, samples) < 0.01


def test_less_than_two_whole_periods_are_refused():
    time, sine, cosine = in_time(SIGNALS, UnevenSpeed(1.6))
    with pytest.raises(ValueError, match="at least 2 were expected"):
        resample(time, sine, cosine, np.unwrap(SIGNALS.reading_rad(sine, cosine)))


def test_a_ripple_in_step_with_the_lines_is_taken_for_an_error():
    """The limit that no resampling lifts: the same speed change in every line looks like a fault of the signals."""
    ideal = SignalModel.ideal(1.0, LINE_COUNT)
    _, samples = resampled(UnevenSpeed(60, 0.002, waves=60.0), model=ideal)
    volts = samples.sine_v.mean(axis=0), samples.cosine_v.mean(axis=0)
    found = model_of_samples(samples.theta_rad, volts, (1, 2, 3), ideal)
    false_arcsec = 0.002 * ideal.arcsec_per_rad
    assert np.ptp(found.error_arcsec(FINE)) / 2 == pytest.approx(false_arcsec, rel=0.1)
