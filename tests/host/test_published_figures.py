"""The figures of Yu Hai et al., Chinese Optics 8(3) 2015 447-455, computed from their printed tables.

Where the print does not follow from the tables, the right figure is asserted and the printed one named.
"""

import numpy as np
import pytest

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref.error_statistics import ErrorStatistics
from arcref.radial_basis_network import RadialBasisNetwork

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
