"""The figures of Yu Hai et al., Chinese Optics 8(3) 2015 447-455, computed from their printed tables.

Where the print does not follow from the tables, the right figure is asserted and the printed one named.
"""

import numpy as np
import pytest

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref.error_statistics import ErrorStatistics
from arcref.radial_basis_network import RadialBasisNetwork, gaussian

PRINTED_SIGMA_BEFORE = 1.30


def rounded(statistics: ErrorStatistics) -> tuple:
    """Number of rows, mean and sigma to four decimals."""
    return statistics.n, round(statistics.mean_arcsec, 4), round(statistics.sigma_arcsec, 4)


def test_table_1_before_compensation(table_1):
    with_closure = table_1.statistics(with_closure=True)
    assert with_closure.n == 25
    assert with_closure.mean_arcsec == pytest.approx(0.4212, abs=5e-5)
    assert with_closure.sigma_arcsec == pytest.approx(1.2438, abs=5e-5)
    assert with_closure.peak_to_peak_arcsec == pytest.approx(5.46, abs=1e-9)
    assert rounded(table_1.statistics()) == (24, 0.4388, 1.2674)
    assert rounded(table_1.statistics(rows=slice(1, None))) == (23, 0.4578, 1.2924)


def test_no_choice_of_rows_gives_the_printed_sigma_of_table_1(table_1):
    for rows in (table_1.statistics(True), table_1.statistics(), table_1.statistics(rows=slice(1, None))):
        assert round(rows.sigma_arcsec, 2) != PRINTED_SIGMA_BEFORE


def test_table_2_after_compensation(table_2):
    statistics = table_2.statistics(with_closure=True)
    assert statistics.n == 25
    assert statistics.sigma_arcsec == pytest.approx(0.49892, abs=5e-6)  # printed 0.4989
    assert statistics.peak_to_peak_arcsec == pytest.approx(1.97)
    assert table_2.statistics().sigma_arcsec == pytest.approx(0.5097, abs=5e-5)


def test_table_3_needs_the_closure_row_that_was_not_printed(table_3):
    assert rounded(table_3.statistics()) == (24, 0.4696, 0.5291)
    closed = ErrorStatistics.of(np.append(table_3.error_arcsec, 0.0))
    assert closed.sigma_arcsec == pytest.approx(0.52636, abs=5e-6)  # printed 0.5264
    assert closed.peak_to_peak_arcsec == pytest.approx(2.29)


def test_improvement(table_1, table_2):
    ratio = table_1.statistics(True).sigma_arcsec / table_2.statistics(True).sigma_arcsec
    assert ratio == pytest.approx(2.493, abs=5e-4)
    assert PRINTED_SIGMA_BEFORE / table_2.statistics(True).sigma_arcsec == pytest.approx(2.606, abs=5e-4)


def test_resolution():
    assert COUNTS_PER_TURN == 8_388_608
    assert pytest.approx(0.154495, abs=5e-7) == ARCSEC_PER_COUNT


# spread: condition number plain and wrapped, largest weight, jump at 360 degrees of the plain network
SPREADS = {
    10: (2.4, 2.4, 2.8, -0.10),
    15: (16.9, 17.6, 4.8, -0.44),
    20: (245, 280, 34, -1.00),
    22.5: (1.2e3, 1.5e3, 141, -1.61),
    25: (6.9e3, 9.9e3, 731, -3.0),
    30: (3.3e5, 7.6e5, 3.1e4, -15.4),
    35: (2.2e7, 1.3e8, 1.9e6, -85),
}


@pytest.mark.parametrize("spread_deg", SPREADS)
def test_conditioning(table_1, spread_deg):
    plain_condition, wrapped_condition, weight, jump = SPREADS[spread_deg]
    plain = RadialBasisNetwork.fit(table_1, spread_deg, wrapped=False)
    wrapped = RadialBasisNetwork.fit(table_1, spread_deg)
    assert plain.condition_number == pytest.approx(plain_condition, rel=0.04)
    assert wrapped.condition_number == pytest.approx(wrapped_condition, rel=0.04)
    assert np.abs(plain.weight_arcsec).max() == pytest.approx(weight, rel=0.03)
    assert plain.evaluate(360 - 1e-9) - plain.evaluate(0.0) == pytest.approx(jump, rel=0.03)
    assert wrapped.evaluate(360 - 1e-9) - wrapped.evaluate(0.0) == pytest.approx(0, abs=1e-6)
    largest = np.abs(wrapped.evaluate(np.arange(0, 360, 0.05))).max()
    assert largest == pytest.approx(3.30, abs=0.007)


# spread: leave-one-out rms plain and wrapped
LEAVE_ONE_OUT = {
    5: (1.31, 1.31),
    10: (1.16, 1.16),
    15: (1.12, 1.14),
    20: (1.61, 1.70),
    22.5: (1.97, 2.15),
    30: (6.3, 3.7),
}


@pytest.mark.parametrize("spread_deg", LEAVE_ONE_OUT)
def test_leave_one_out(table_1, spread_deg):
    plain, wrapped = LEAVE_ONE_OUT[spread_deg]
    tolerance = 0.05 if spread_deg == 30 else 0.005
    assert RadialBasisNetwork.fit(table_1, spread_deg, wrapped=False).leave_one_out_rms_arcsec == pytest.approx(
        plain, abs=tolerance
    )
    assert RadialBasisNetwork.fit(table_1, spread_deg).leave_one_out_rms_arcsec == pytest.approx(wrapped, abs=tolerance)


def test_leave_one_out_of_the_best_ridge(table_1):
    assert RadialBasisNetwork.fit(table_1, 15, ridge=0.1).leave_one_out_rms_arcsec == pytest.approx(1.10, abs=0.005)


def emulated_sigma(table_1, offset_deg, runs=2000, noise_arcsec=0.35, spread_deg=15.0):
    """Sigma of many emulated verifications `offset_deg` beside the faces, float64[runs].

    The truth is the fit through Table 1. A noisy calibration, its first face taken as zero and printed to 0.01 arcsec,
    is fitted and rounded to whole counts; then a fresh noisy run verifies it, and its closure row of 0 is counted.
    """
    random = np.random.default_rng(20150803)
    centre = table_1.angle_deg
    truth = RadialBasisNetwork.fit(table_1)
    verified = centre + offset_deg
    solve = np.linalg.inv(gaussian(centre[:, np.newaxis] - centre, spread_deg))
    fit = gaussian(verified[:, np.newaxis] - centre, spread_deg) @ solve
    calibrated = truth.evaluate(centre) + noise_arcsec * random.standard_normal((runs, 24))
    calibrated = np.round(calibrated - calibrated[:, :1], 2)
    stored = np.round(calibrated @ fit.T / ARCSEC_PER_COUNT) * ARCSEC_PER_COUNT
    left = truth.evaluate(verified) - stored + noise_arcsec * random.standard_normal((runs, 24))
    left -= left[:, :1]
    return np.append(left, np.zeros((runs, 1)), axis=1).std(axis=1, ddof=1)


def test_table_2_is_the_repeatability_of_two_runs(table_1, table_2):
    sigma = emulated_sigma(table_1, 0.0)
    assert sigma.mean() == pytest.approx(0.49, abs=0.01)
    low, high = np.percentile(sigma, [2.5, 97.5])
    assert (low, high) == (pytest.approx(0.36, abs=0.02), pytest.approx(0.63, abs=0.02))
    assert low < table_2.statistics(with_closure=True).sigma_arcsec < high


@pytest.mark.parametrize("spread_deg", [10, 15, 20, 30])
def test_table_3_can_be_emulated(table_1, spread_deg):
    sigma = emulated_sigma(table_1, 5.0, spread_deg=spread_deg)
    assert sigma.mean() == pytest.approx(0.48, abs=0.015)
    low, high = np.percentile(sigma, [2.5, 97.5])
    assert (low, high) == (pytest.approx(0.35, abs=0.025), pytest.approx(0.62, abs=0.025))
    assert low < 0.5264 < high


def test_the_default_spread_of_matlab_in_degrees_is_useless(table_1):
    assert emulated_sigma(table_1, 5.0, spread_deg=1.0).mean() == pytest.approx(1.26, abs=0.03)


@pytest.mark.parametrize(("order", "seen"), [(4096, 8), (8192, 8), (16384, 8), (12288, 0)])
def test_an_error_within_the_line_looks_like_order_8_to_24_faces(order, seen):
    faces = np.arange(24) / 24
    spectrum = np.abs(np.fft.rfft(np.cos(2 * np.pi * order * faces + 0.7)))
    assert int(np.argmax(spectrum)) == seen
    assert 4096 % 24 == 16


def test_the_5_degree_test_is_blind_to_it_and_7_5_degrees_are_not():
    """The false term of order 8 that the faces leave in the ROM meets the true one of order 4096 at + 5 degrees."""
    faces_deg = np.arange(24) * 15.0

    def true_term(deg):
        return np.cos(np.radians(4096 * deg) + 0.7)

    def false_term(deg):
        return np.cos(np.radians(-8 * deg) + 0.7)

    assert np.abs(true_term(faces_deg) - false_term(faces_deg)).max() < 1e-8
    assert np.abs(true_term(faces_deg + 5) - false_term(faces_deg + 5)).max() < 1e-8
    difference = true_term(faces_deg + 7.5) - false_term(faces_deg + 7.5)
    assert np.abs(difference - 2 * true_term(faces_deg + 7.5)).max() < 1e-8
