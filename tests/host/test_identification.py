"""The ways to identify the signals: that they agree where they must, and what noise does to each."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from published_signals import LINE_COUNT, published_signals

from arcref.input_error import InputError
from arcref.subdivision.identification.heydemann_ellipse import fit_ellipse
from arcref.subdivision.identification.identification import PeriodSamples
from arcref.subdivision.identification.identification_names import METHODS, identify
from arcref.subdivision.identification.least_squares import design_matrix, least_squares
from arcref.subdivision.identification.particle_swarm import (
    CORRECTED,
    PRINTED,
    SumOfSquares,
    SwarmSettings,
    coefficients_of,
    inertia,
    swarm_search,
)
from arcref.subdivision.identification.swarm_convergence import CONVERGED_V, swarm_convergence
from arcref.subdivision.identification.swarm_identification import channel_of_swarm
from arcref.subdivision.signal_correction import left_after_model, left_without
from arcref.subdivision.signal_model import SignalModel, line_phases_rad

SIGNALS = published_signals()
THETA = line_phases_rad(64)
FINE = line_phases_rad(256)
ORDERS = (1, 3, 5)
COLUMNS = design_matrix(THETA, ORDERS)


def samples(noise_v: float = 0.0, seed: int = 0) -> PeriodSamples:
    noise = noise_v * np.random.default_rng(seed).standard_normal((2, 64))
    sine, cosine = SIGNALS.signals_v(THETA)
    return PeriodSamples(THETA, sine + noise[0], cosine + noise[1], LINE_COUNT)


def same_signals(one: SignalModel, other: SignalModel) -> float:
    """Largest rms difference of the two channels, in volts."""
    both = zip(one.signals_v(FINE), other.signals_v(FINE), strict=True)
    return max(float(np.sqrt(np.mean((a - b) ** 2))) for a, b in both)


def test_least_squares_is_exact_without_noise():
    found = least_squares(samples())
    assert same_signals(found.model, SIGNALS) < 1e-14
    assert max(found.residual_rms_v) < 1e-14
    for channel, true in ((found.model.sine, SIGNALS.sine), (found.model.cosine, SIGNALS.cosine)):
        for order, wave in true.canonical.harmonics.items():
            assert channel.harmonics[order].amplitude_v == pytest.approx(wave.amplitude_v, abs=1e-14)
            turn = channel.harmonics[order].phase_rad - wave.phase_rad
            assert np.remainder(turn + 1, 2 * np.pi) - 1 == pytest.approx(0, abs=1e-11)


@given(st.lists(st.floats(-1, 1), min_size=40, max_size=90), st.integers(0, 2**32 - 1))
@settings(max_examples=30)
def test_least_squares_leaves_a_residual_orthogonal_to_the_model(start, seed):
    generator = np.random.default_rng(seed)
    theta = np.sort(generator.uniform(0, 2 * np.pi, len(start)))
    noise = generator.standard_normal((2, theta.size))
    sine, cosine = SIGNALS.signals_v(theta)
    given_samples = PeriodSamples(theta, sine + noise[0], cosine + np.array(start), LINE_COUNT)
    model = least_squares(given_samples).model
    for volts, fitted in zip((given_samples.sine_v, given_samples.cosine_v), model.signals_v(theta), strict=True):
        assert np.abs(design_matrix(theta, ORDERS).T @ (volts - fitted)).max() < 1e-9


def test_too_few_samples_are_refused():
    few = PeriodSamples(THETA[::16], *SIGNALS.signals_v(THETA[::16]), LINE_COUNT)
    with pytest.raises(InputError, match="4 samples cannot give the 7 parameters"):
        least_squares(few)
    aliased = line_phases_rad(8)
    with pytest.raises(InputError, match="do not tell the orders 1, 3, 5 apart"):
        least_squares(PeriodSamples(aliased, *SIGNALS.signals_v(aliased), LINE_COUNT))


@pytest.mark.parametrize("noise_v", [0.0, 0.005, 0.05])
def test_the_swarm_reaches_the_least_squares_optimum_and_never_less(noise_v):
    given_samples = samples(noise_v, seed=3)
    optimum, swarm = (identify(given_samples, name, ORDERS) for name in ("least-squares", "swarm"))
    assert same_signals(optimum.model, swarm.model) < CONVERGED_V
    for best, found in zip(optimum.residual_rms_v, swarm.residual_rms_v, strict=True):
        assert found >= best - 1e-12


def test_share_of_100_seeds_that_converge_grows_with_the_swarm():
    small, middle, usual = swarm_convergence(samples(0.005), (4, 10, 30))
    assert small.share < 0.2 < middle.share < 0.95 < usual.share
    assert (usual.distance_v[usual.distance_v < CONVERGED_V] < CONVERGED_V).all()
    assert max(each.least_below_v2 for each in (small, middle, usual)) < 1e-12


def test_a_small_and_short_swarm_fails_and_so_does_the_printed_rule():
    (short,) = swarm_convergence(samples(), (20,), range(20), settings=SwarmSettings(iterations=200))
    assert short.share == 0
    printed = SwarmSettings(iterations=500, inertia_rule=PRINTED)
    (as_printed,) = swarm_convergence(samples(), (40,), range(20), settings=printed)
    assert as_printed.share == 0
    (corrected,) = swarm_convergence(samples(), (40,), range(20))
    assert corrected.share == 1


def test_a_search_depends_on_its_seed_alone():
    volts = samples(0.005).sine_v
    settings_ = SwarmSettings(8, 30)
    together = swarm_search(COLUMNS, volts, [5, 6, 7], settings_)
    alone = swarm_search(COLUMNS, volts, [6], settings_)
    assert np.array_equal(together.parameters[1], alone.parameters[0])
    assert (np.diff(together.history, axis=0) <= 0).all()


def test_the_sum_of_squares_of_the_swarm_is_that_of_the_residuals():
    generator = np.random.default_rng(2)
    volts = generator.standard_normal((3, 64))
    guesses = generator.uniform(-5, 5, (3, 10, 7))
    found = SumOfSquares(COLUMNS, volts)(guesses)
    for search in range(3):
        for guess in range(10):
            residual = volts[search] - channel_of_swarm(guesses[search, guess], ORDERS).evaluate(THETA)
            assert found[search, guess] == pytest.approx(np.sum(residual**2), rel=1e-12)
    assert np.allclose(
        coefficients_of(guesses) @ COLUMNS.T,
        [[channel_of_swarm(guess, ORDERS).evaluate(THETA) for guess in search] for search in guesses],
    )


def test_the_inertia_rules():
    corrected = SwarmSettings(iterations=100, distance=(1.0, 3.0))
    printed = SwarmSettings(iterations=100, distance=(1.0, 3.0), inertia_rule=PRINTED)
    for rule in (corrected, printed):
        assert inertia(np.array([0.5, 4.0]), 50, rule) == pytest.approx([0.4, 0.9])
    just_inside = np.array([1.0 + 1e-9, 3.0 - 1e-9])
    assert inertia(just_inside, 100, corrected) == pytest.approx([0.4, 0.9], abs=1e-6)  # meets both ends
    assert inertia(just_inside, 50, corrected) == pytest.approx([0.65, 0.9], abs=1e-6)
    assert inertia(just_inside, 100, printed) == pytest.approx([0.9, 0.4], abs=1e-6)  # jumps at both
    between = np.linspace(1.01, 2.99, 50)
    assert (np.diff(inertia(between, 60, corrected)) > 0).all()
    assert (np.diff(inertia(between, 60, printed)) < 0).all()
    assert SwarmSettings().inertia_rule == CORRECTED


def test_the_ellipse_sees_offsets_and_no_harmonics():
    found = identify(samples(), "heydemann")
    assert found.model.sine.offset_v == pytest.approx(-0.0179, abs=5e-5)
    assert found.model.cosine.offset_v == pytest.approx(-0.0642, abs=5e-5)
    assert np.ptp(left_after_model(SIGNALS, line_phases_rad(4096), found.model)) == pytest.approx(0.645, abs=2e-3)


@given(
    st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.3, 4), st.floats(0.5, 2), st.floats(0.6, 2.5)),
    st.sampled_from((1, -1)),
)
def test_the_ellipse_is_exact_without_harmonics(ellipse, sense):
    x0, y0, a, ratio, apart = ellipse
    turn = sense * line_phases_rad(37) + 0.3
    x, y = x0 + a * np.sin(turn), y0 + a * ratio * np.sin(turn + apart)
    found = fit_ellipse(x, y)
    assert found == pytest.approx((x0, y0, a, a * ratio, apart), abs=1e-7 * a)


def test_what_is_no_ellipse_is_refused():
    with pytest.raises(InputError, match="no ellipse"):
        fit_ellipse(THETA, 2 * THETA)
    with pytest.raises(InputError, match="no ellipse"):
        fit_ellipse(THETA, THETA**2)


# noise of a sample, mV: least squares mean and 95 %, harmonics 3 and 5 removed, Heydemann; pp error left, arcsec
NOISE_TABLE = {
    1: (0.0039, 0.0054, 0.532, 0.646),
    2: (0.0077, None, 0.532, 0.647),
    5: (0.0191, 0.027, 0.534, 0.650),
    10: (0.038, 0.056, 0.535, 0.652),
    20: (0.082, 0.113, 0.546, 0.667),
    50: (0.19, 0.30, 0.576, 0.713),
}


@pytest.mark.parametrize("noise_mv", NOISE_TABLE)
def test_noise_table(noise_mv):
    mean, high, without, ellipse = NOISE_TABLE[noise_mv]
    left = []
    for seed in range(200):
        given_samples = samples(noise_mv * 1e-3, seed)
        full, conic = (identify(given_samples, name).model for name in ("least-squares", "heydemann"))
        each = (
            left_after_model(SIGNALS, FINE, full),
            left_without(SIGNALS, FINE, (3, 5), model=full),
            left_after_model(SIGNALS, FINE, conic),
        )
        left.append([np.ptp(error) for error in each])
    left = np.array(left)
    assert left.mean(axis=0) == pytest.approx([mean, without, ellipse], rel=0.15)
    if high is not None:
        assert np.percentile(left[:, 0], 95) == pytest.approx(high, rel=0.15)


@pytest.mark.parametrize(("noise_mv", "mean_arcsec"), [(5, 0.0191), (50, 0.19)])
def test_noise_does_the_same_to_the_swarm(noise_mv, mean_arcsec):
    # The table's swarm, 40 particles and 500 iterations, all repetitions side by side.
    many = [samples(noise_mv * 1e-3, seed) for seed in range(100)]
    channels = []
    for place in range(2):
        volts = np.stack([(each.sine_v, each.cosine_v)[place] for each in many])
        outcome = swarm_search(COLUMNS, volts, [[seed, place] for seed in range(100)], SwarmSettings(40, 500))
        channels.append([channel_of_swarm(found, ORDERS) for found in outcome.parameters])
    models = [SignalModel(*pair, LINE_COUNT) for pair in zip(*channels, strict=True)]
    left = np.mean([np.ptp(left_after_model(SIGNALS, FINE, model)) for model in models])
    assert left == pytest.approx(mean_arcsec, rel=0.15)


@pytest.mark.parametrize("periods", [4, 16, 64])
def test_averaging_periods_divides_by_their_root(periods):
    left = [
        np.ptp(left_after_model(SIGNALS, FINE, identify(samples(0.005 / np.sqrt(periods), seed)).model))
        for seed in range(150)
    ]
    assert np.mean(left) == pytest.approx(0.0195 / np.sqrt(periods), rel=0.15)


def test_every_method_has_a_name_and_gives_its_time():
    for name in METHODS:
        found = identify(samples(0.005), name, ORDERS)
        assert found.method == name
        assert found.seconds > 0
        assert found.samples == 64
