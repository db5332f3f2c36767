"""Tolerance of the tower tilt, published and by its formula, and the screws that take the tilt away."""

import csv
from pathlib import Path

import numpy as np
import pytest

from arcref.calibration.tilt_adjustment import AdjustingScrews, adjustment_sentences, screw_turns
from arcref.calibration.tilt_tolerance import COEFFICIENT, GRADES, LARGEST_COEFFICIENT, TiltTolerance
from arcref.calibration.tower_tilt import (
    ARCSEC_PER_RADIAN,
    fit_tilt,
    horizontal_reading_arcsec,
    vertical_reading_arcsec,
)

PUBLISHED = Path(__file__).parents[1] / "data" / "tower_tolerance_grades.csv"

BY_FORMULA = (124.96, 176.72, 249.91, 353.43, 558.82, 790.30, 1368.84)
BY_LARGEST_ERROR = (119.3, 168.8, 238.7, 337.5, 533.7, 754.7, 1307.2)


def tilt_of(psi_arcsec, omega_deg):
    theta_deg = np.arange(24) * 15.0
    return fit_tilt(theta_deg, vertical_reading_arcsec(theta_deg, psi_arcsec, omega_deg))


def test_the_table_is_the_published_one():
    rows = [line for line in PUBLISHED.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    published = {
        int(row["precision_grade"]): (
            float(row["required_accuracy_pm_arcsec"]),
            float(row["required_pyramidal_error_arcsec"]),
        )
        for row in csv.DictReader(rows)
    }
    assert published == GRADES


@pytest.mark.parametrize("grade", GRADES)
def test_tolerances_of_the_grades(grade):
    tolerance = TiltTolerance.of_grade(grade)
    assert tolerance.formula_arcsec == pytest.approx(BY_FORMULA[grade - 1], abs=0.005)
    assert tolerance.strict_arcsec == pytest.approx(BY_LARGEST_ERROR[grade - 1], abs=0.05)
    # The print agrees from grade 3 on, rounded up. Grade 1 is off by 15 arcsec, grade 2 by 1.3.
    agrees = tolerance.published_arcsec == np.ceil(tolerance.formula_arcsec)
    assert agrees == (grade >= 3)
    assert (140 - TiltTolerance.of_grade(1).formula_arcsec, GRADES[1][1]) == (pytest.approx(15.04, abs=0.01), 140)
    assert pytest.approx(2.39, abs=0.005) == 0.25 / (140**2 * COEFFICIENT)  # 140 gives the accuracy over 2.39, not 3


@pytest.mark.parametrize("grade", GRADES)
def test_the_tolerance_keeps_the_error_to_a_third(grade):
    tolerance = TiltTolerance.of_grade(grade)
    theta_deg = np.arange(0, 360, 0.1)
    third = tolerance.accuracy_arcsec / 3
    assert np.abs(horizontal_reading_arcsec(theta_deg, tolerance.formula_arcsec, 90.0)).max() == pytest.approx(
        third, rel=2e-4
    )
    azimuth_deg = np.arange(0, 360, 2.5)[:, np.newaxis]
    assert np.abs(horizontal_reading_arcsec(theta_deg, tolerance.strict_arcsec, azimuth_deg)).max() == pytest.approx(
        third, rel=2e-4
    )
    assert pytest.approx(0.58522e-5, rel=1e-5) == LARGEST_COEFFICIENT


@pytest.mark.parametrize("angles_deg", [(0, 120, 240), (15, 105, 195, 285), (40, 310)])
@pytest.mark.parametrize("omega_deg", [0.0, 37.0, 200.0, -91.0])
def test_the_turned_screws_take_the_tilt_away(angles_deg, omega_deg):
    """The plane through the raised screws, set upon the tilted table, stands square to the encoder's axis."""
    psi_arcsec, radius_mm = 300.0, 60.0
    turns = screw_turns(tilt_of(psi_arcsec, omega_deg), AdjustingScrews(angles_deg, radius_mm, 0.5))
    angle = np.radians(angles_deg)
    rise_mm = np.array([turn.rise_um for turn in turns]) / 1000
    design = np.stack([radius_mm * np.cos(angle), radius_mm * np.sin(angle)], axis=1)
    slope, _, rank, _ = np.linalg.lstsq(design, rise_mm, rcond=None)
    assert rank == 2
    # A plane z = p x + q y has the normal (-p, -q, 1): it must be the encoder's axis in the polygon's frame.
    omega = np.radians(omega_deg)
    assert -slope * ARCSEC_PER_RADIAN == pytest.approx(psi_arcsec * np.array([np.cos(omega), np.sin(omega)]), abs=1e-3)
    assert np.abs(design @ slope - rise_mm).max() < 1e-12
    for turn in turns:
        assert turn.turn_deg == pytest.approx(turn.rise_um / 500 * 360)


def test_the_sentences_name_screw_way_and_amount():
    screws = AdjustingScrews((0, 120, 240), 60.0, 0.5)
    tilt = tilt_of(300.0, 0.0)
    text = " ".join(adjustment_sentences(tilt, screws, 24))
    assert "towards 0.0 deg from face 1 (nearest face 1): lower that side" in text
    assert "(nearest face 13), by 145.4 um per 100 mm" in text
    assert "Screw 1 (at 0 deg): lower by 87.3 um, drive it out by 62.8 deg of turn." in text
    assert "Screw 2 (at 120 deg): raise by 43.6 um, drive it in by 31.4 deg of turn." in text
    without_pitch = " ".join(adjustment_sentences(tilt, AdjustingScrews((0, 120, 240), 60.0, None), 24))
    assert "Screw 3 (at 240 deg): raise by 43.6 um; with screw_pitch_mm stated" in without_pitch
    assert "state screw_angles_deg" in " ".join(adjustment_sentences(tilt, None, 24))


def test_a_tilt_lost_in_noise_turns_no_screw():
    random = np.random.default_rng(8)
    tilt = fit_tilt(np.arange(24) * 15.0, random.normal(0, 0.2, 24))
    text = adjustment_sentences(tilt, AdjustingScrews((0, 120, 240), 60.0, 0.5), 24)
    assert text[-1] == "The tilt is not clear of its uncertainty: there is nothing to turn."
