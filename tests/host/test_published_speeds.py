"""Speed and delay figures of Yu Hai et al. 2015, and the tower paper's claims as they were printed.

The paper's claim of real time covers the FPGA alone: its interpolator's constant delay is 419 counts at 10 r/s.
"""

import csv
from pathlib import Path

import numpy as np
import pytest

from arcref.angle import (
    ARCSEC_PER_COUNT,
    ARCSEC_PER_TURN,
    COUNTS_PER_LINE,
    COUNTS_PER_TURN,
    LINES_PER_TURN,
    counts_to_arcsec,
)
from arcref.calibration.tower_tilt import horizontal_reading_arcsec, vertical_reading_arcsec

CLAIMS = Path(__file__).parents[1] / "data" / "tower_published_claims.csv"

INTERPOLATION = 512
INPUT_LIMIT_HZ = 260e3


def lag_arcsec(delay_s, speed_rps):
    """Equation (2), mu = t_d v."""
    return delay_s * speed_rps * ARCSEC_PER_TURN


def test_signals_at_10_rps():
    assert 4 * INTERPOLATION == COUNTS_PER_LINE == 2048
    assert 10 * LINES_PER_TURN == 40_960
    assert 10 * LINES_PER_TURN * INTERPOLATION == 20_971_520
    assert 10 * COUNTS_PER_TURN == 83_886_080
    assert pytest.approx(11.9209, abs=5e-5) == 1e9 / (10 * COUNTS_PER_TURN)
    assert pytest.approx(111.85, abs=0.005) == 10 * COUNTS_PER_TURN / 0.75 / 1e6  # edges 25 % early need 112 MHz


def test_signals_at_the_interpolators_input_limit():
    speed_rps = INPUT_LIMIT_HZ / LINES_PER_TURN
    assert speed_rps == pytest.approx(63.4766, abs=5e-5)
    assert speed_rps * 60 == pytest.approx(3808.6, abs=0.05)
    assert speed_rps * 360 == pytest.approx(22_851.6, abs=0.05)
    assert pytest.approx(133.12e6) == INPUT_LIMIT_HZ * INTERPOLATION
    assert speed_rps * COUNTS_PER_TURN == pytest.approx(532_480_000)
    assert 1e9 / (speed_rps * COUNTS_PER_TURN) == pytest.approx(1.878, abs=5e-4)


@pytest.mark.parametrize(("delay_s", "limit_deg_per_s", "lag"), [(1e-6, 42.915, 12.96), (1e-5, 4.2915, 129.6)])
def test_delay_of_conversion_and_processor(delay_s, limit_deg_per_s, lag):
    """Equations (2) and (4): codes are skipped when the lag is more than a count."""
    assert ARCSEC_PER_COUNT / 3600 / delay_s == pytest.approx(limit_deg_per_s, rel=2e-5)
    assert lag_arcsec(delay_s, 10) == pytest.approx(lag)


def test_the_lag_of_one_count_at_10_rps():
    assert lag_arcsec(11.9209e-9, 10) == pytest.approx(ARCSEC_PER_COUNT, rel=1e-5)
    assert lag_arcsec(1e-6, 10) / ARCSEC_PER_COUNT == pytest.approx(83.9, abs=0.05)


def test_the_interpolators_own_delay_is_not_in_the_paper():
    lag = lag_arcsec(5e-6, 10)
    assert lag == pytest.approx(64.8)
    assert round(lag / ARCSEC_PER_COUNT) == 419
    assert counts_to_arcsec(419) == pytest.approx(lag, abs=0.1)
    assert pytest.approx(168, abs=0.5) == 10 * COUNTS_PER_TURN / 500_000  # counts for each conversion


def test_claims_of_the_tower_paper_as_printed():
    """Each as the data file has it, against the model: all agree in the digits printed."""
    lines = [line for line in CLAIMS.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    printed = {row["quantity"]: float(row["value"]) for row in csv.DictReader(lines)}
    theta_deg = np.arange(0, 360, 0.1)

    def largest(psi_arcsec, omega_deg):
        return np.abs(horizontal_reading_arcsec(theta_deg, psi_arcsec, omega_deg)).max()

    right = {
        "eps_x_range_low_at_psi_5arcmin": largest(300, 0),
        "eps_x_range_high_at_psi_5arcmin": largest(300, 90),
        "eps_x_at_psi_10arcmin_omega_90": largest(600, 90),
        "coef_at_179deg_omega_90": horizontal_reading_arcsec(179, 300, 90) / 300**2,
        "coef_at_111deg_omega_90": horizontal_reading_arcsec(111, 300, 90) / 300**2,
        "eps_y_span_over_psi": np.ptp(vertical_reading_arcsec(theta_deg, 300, 90)) / 300,
    }
    assert printed.keys() == right.keys()
    for quantity, value in printed.items():
        assert right[quantity] == pytest.approx(value, rel=1e-3 if "coef" in quantity or "span" in quantity else 0.01)
