import json
from dataclasses import replace

import numpy as np
import pytest

from arcref.calibration.fit_comparison import compare_fits, verify_fit
from arcref.calibration.fit_sections import COMPARISON_TITLE, comparison_section, fit_section
from arcref.calibration.fits.fit_names import FIT_NAMES, fit_curve
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError


@pytest.fixture(scope="module")
def second(table_1):
    """A second run of the published encoder, 5 degrees further on, with 0.35 arcsec of noise."""
    angle = table_1.angle_deg + 5
    noise = 0.35 * np.random.default_rng(3).standard_normal(24)
    return ErrorCurve(angle, fit_curve(table_1).evaluate(angle) + noise)


@pytest.fixture(scope="module")
def comparison(table_1, second):
    return compare_fits(fit_curve(replace(table_1, u_arcsec=np.full(24, 0.2))), second)


def test_every_fit_is_there_the_chosen_one_first(comparison, table_1):
    assert [fit.name for fit in comparison.fits] == list(FIT_NAMES)
    assert comparison.figures[-1].title == "no correction"
    chosen = compare_fits(fit_curve(table_1, "spline"))
    assert [fit.name for fit in chosen.fits] == ["spline", "rbf", "fourier", "gaussian-process"]


def test_figures_are_those_of_the_fits(comparison):
    turn = np.arange(0, 360, 0.25)
    there = comparison.chosen.evaluate(turn)
    for one in comparison.figures[:-1]:
        fit = one.fit
        assert one.residual_rms_arcsec == pytest.approx(np.sqrt(np.mean(fit.residual_arcsec**2)))
        assert one.leave_one_out_rms_arcsec == fit.leave_one_out_rms_arcsec
        assert one.u_largest_arcsec == pytest.approx(fit.u_arcsec(turn).max())
        assert one.difference_arcsec == pytest.approx(np.sqrt(np.mean((fit.evaluate(turn) - there) ** 2)), abs=1e-12)
    assert comparison.figures[0].difference_arcsec == 0
    assert comparison.figures[-1].residual_rms_arcsec == pytest.approx(1.316, abs=5e-4)
    assert comparison.figures[0].leave_one_out_rms_arcsec == pytest.approx(1.136, abs=5e-4)


def test_verification_counts_as_the_published_table_does(comparison, second):
    """The first reading is zero and the closing zero counts too: n = 25 for 24 readings."""
    for one in comparison.figures:
        corrected = second.error_arcsec - (one.fit.evaluate(second.angle_deg) if one.fit else 0)
        left = np.append(corrected - corrected[0], 0.0)
        assert one.verification.left_arcsec == pytest.approx(left[:-1], abs=1e-12)
        assert one.verification.statistics.n == 25
        assert one.verification.statistics.sigma_arcsec == pytest.approx(left.std(ddof=1))
        assert one.verification.statistics.peak_to_peak_arcsec == pytest.approx(np.ptp(left))
        assert one.verification.open_statistics.sigma_arcsec == pytest.approx(left[:-1].std(ddof=1))


def test_published_table_3_is_counted_right(table_1, table_3):
    """The printed residuals, given back to the fit as errors of a second run, return the printed figure 0.5264."""
    fit = fit_curve(table_1)
    encoder = replace(table_3, error_arcsec=table_3.error_arcsec + fit.evaluate(table_3.angle_deg))
    verification = verify_fit(fit, encoder)
    assert verification.statistics.sigma_arcsec == pytest.approx(0.52636, abs=5e-6)
    assert verification.statistics.peak_to_peak_arcsec == pytest.approx(2.29)
    assert verification.open_statistics.sigma_arcsec == pytest.approx(0.5291, abs=5e-5)


def test_correction_helps_the_second_run(comparison):
    untouched = comparison.figures[-1].verification.statistics.sigma_arcsec
    assert all(one.verification.statistics.sigma_arcsec < untouched / 2 for one in comparison.figures[:-1])


def test_section_and_json(comparison):
    section = comparison_section(comparison)
    assert section.title == COMPARISON_TITLE
    assert [row[0] for row in section.rows] == [one.title for one in comparison.figures]
    assert all(len(row) == len(section.columns) == 8 for row in section.rows)
    assert any("blind to an error of order 4096" in text for text in section.paragraphs)
    (plot,) = section.plots
    assert plot.startswith("<svg")
    assert comparison_section(comparison, plots=False).plots == ()
    entries = json.loads(json.dumps(comparison.to_json(), allow_nan=False))
    assert [entry["fit"] for entry in entries] == [*FIT_NAMES, None]
    assert entries[0]["verification"]["n"] == 25
    assert entries[0]["parameters"] == {"spread_deg": 15.0, "ridge": 0.0}


def test_without_a_second_run_nothing_is_verified(table_1):
    section = comparison_section(compare_fits(fit_curve(table_1)), plots=False)
    assert "second run" not in section.columns
    assert section.rows[0][3] == "-"


def test_an_arc_is_compared_where_it_was_measured():
    random = np.random.default_rng(1)
    angle = np.arange(0.0, 41.0)
    curve = ErrorCurve(angle, 0.1 * angle + 0.3 * random.standard_normal(41), np.full(41, 0.3), arc_deg=(0.0, 40.0))
    second = ErrorCurve(np.arange(-20.0, 61.0), 0.1 * np.arange(-20.0, 61.0))
    comparison = compare_fits(fit_curve(curve), second)
    assert all(one.verification.open_statistics.n == 41 for one in comparison.figures)
    assert all(one.verification.statistics.sigma_arcsec < 0.6 for one in comparison.figures[:-1])
    outside = ErrorCurve(np.array([100.0, 200.0, 300.0]), np.zeros(3))
    with pytest.raises(InputError, match="the second run has 0 readings where the first one measured, at least 2"):
        verify_fit(fit_curve(curve), outside)


def test_a_rival_that_cannot_be_fitted_is_named_and_the_others_go_on():
    # Two faces 0.002 degrees apart in every pair: the network's default spread is badly conditioned.
    angle = np.sort(np.concatenate([np.arange(12) * 30.0, np.arange(12) * 30.0 + 2e-4]))
    curve = ErrorCurve(angle, np.cos(np.radians(angle)))
    comparison = compare_fits(fit_curve(curve, "fourier", order=3))
    assert [text.partition(":")[0] for text in comparison.refused] == ["rbf"]
    assert "badly conditioned" in comparison_section(comparison, plots=False).paragraphs[-1]


@pytest.mark.parametrize(("spread_deg", "caution"), [(15, False), (25, True)])
def test_fit_section_cautions_of_a_fit_worse_than_none(table_1, spread_deg, caution):
    section = fit_section(fit_curve(table_1, spread_deg=spread_deg))
    assert any("worse by this fit than by no correction" in text for text in section.paragraphs) == caution
    assert section.plots[0].startswith("<svg")
    assert all(len(row) == 2 for row in section.rows)


def test_fit_section_names_gap_and_arc():
    angle = np.delete(np.arange(24) * 15.0, [4, 5])
    section = fit_section(fit_curve(ErrorCurve(angle, np.cos(np.radians(angle)))), plots=False)
    assert "nothing was measured in the 45 deg behind 45 deg" in section.paragraphs[-1]
    arc = ErrorCurve(np.arange(0.0, 41.0), np.zeros(41), arc_deg=(0.0, 40.0))
    assert "Only 0 .. 40 deg was measured" in fit_section(fit_curve(arc), plots=False).paragraphs[-1]
