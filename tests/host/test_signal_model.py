"""The signal model: any parameters, either sense of the cosine, and its inverse."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from published_signals import published_signals

from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel, line_phases_rad, wrapped_rad

small = st.floats(-0.04, 0.04)
phases = st.floats(-10, 10)


@st.composite
def signals(draw) -> SignalModel:
    """Signals with every fault, of either sense, beginning anywhere."""
    start, amplitude = draw(phases), draw(st.floats(0.1, 10))
    sign = draw(st.sampled_from((1, -1)))
    channels = []
    for quarter in (0.0, sign * np.pi / 2):
        waves = {1: Harmonic(amplitude * (1 + draw(small)), start + quarter + draw(small))}
        for order in draw(st.lists(st.integers(2, 9), max_size=3, unique=True)):
            waves[order] = Harmonic(amplitude * draw(small), draw(phases))
        channels.append(ChannelModel(amplitude * draw(small), waves))
    return SignalModel(*channels, draw(st.sampled_from((2048, 4096, 16384))))


@given(signals())
def test_the_reading_grows_with_the_true_phase(model):
    theta = line_phases_rad(256)
    reading = np.unwrap(model.reading_rad(*model.signals_v(theta)))
    assert (np.diff(reading) > 0).all()
    assert reading[-1] - reading[0] < 2 * np.pi
    assert abs(model.error_arcsec(line_phases_rad()).mean()) < 1e-9 * model.period_arcsec


@given(signals())
def test_the_error_over_the_reading_is_the_error_over_the_true_phase(model):
    theta = line_phases_rad(200)
    reading = model.reading_rad(*model.signals_v(theta))
    at_reading = model.error_at_reading_arcsec(reading)
    assert at_reading == pytest.approx(model.error_arcsec(theta), abs=1e-10 * model.period_arcsec)
    again = wrapped_rad(model.true_phase_rad(reading) - model.mean_error_rad - theta)
    assert again == pytest.approx(0, abs=1e-10)


@given(signals())
def test_canonical_channels_and_json_are_the_same_signals(model):
    theta = line_phases_rad(50)
    for channel in (model.sine, model.cosine):
        size = channel.canonical.fundamental.amplitude_v
        assert channel.canonical.evaluate(theta) == pytest.approx(channel.evaluate(theta), abs=1e-12 * size)
        assert all(wave.amplitude_v >= 0 for wave in channel.canonical.harmonics.values())
        assert ChannelModel.from_json(channel.to_json()) == channel
        step = 1e-6
        slope = (channel.evaluate(theta + step) - channel.evaluate(theta - step)) / (2 * step)
        assert channel.derivative(theta) == pytest.approx(slope, abs=1e-6 * size)


@pytest.mark.parametrize("sign", [1, -1])
def test_ideal_signals_have_no_error(sign):
    model = SignalModel.ideal(2.0, cosine_sign=sign)
    assert model.cosine_sign == sign
    assert np.abs(model.error_arcsec(line_phases_rad(512))).max() < 1e-11
    assert model.cosine.evaluate(0.0) == pytest.approx(sign * 2.0)


def test_signals_that_turn_back_have_no_inverse():
    folded = ChannelModel(0.0, {1: Harmonic(1.0, 0.0), 3: Harmonic(0.9, 0.0)})
    model = SignalModel(folded, ChannelModel(0.0, {1: Harmonic(1.0, np.pi / 2)}))
    with pytest.raises(ValueError, match="does not grow"):
        model.true_phase_rad(line_phases_rad(64))


def test_a_channel_without_its_signal_is_refused():
    with pytest.raises(ValueError, match="order 1 among them"):
        ChannelModel(0.0, {3: Harmonic(1.0, 0.0)})
    with pytest.raises(ValueError, match="order 1 among them"):
        ChannelModel(0.0, {0: Harmonic(1.0, 0.0), 1: Harmonic(1.0, 0.0)})


def test_the_published_amplitudes_below_zero_are_the_same_signals():
    model = published_signals()
    same = SignalModel(model.sine.canonical, model.cosine.canonical, model.line_count)
    assert same.cosine_sign == model.cosine_sign
    theta = line_phases_rad(64)
    assert same.error_arcsec(theta) == pytest.approx(model.error_arcsec(theta), abs=1e-12)
