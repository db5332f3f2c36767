"""Errors within a grating line as 24 faces, and others, see them."""

from dataclasses import replace

import numpy as np
import pytest

from arcref.calibration.aliasing import aliases, exposure, exposure_at, telling_offsets
from arcref.calibration.fit_sections import aliasing_section, aliasing_warning, blind_sentences
from arcref.calibration.fits.fit_names import FIT_NAMES, fit_curve
from arcref.error_curve import ErrorCurve

SIGNAL_PERIOD_DEG = 360 / 4096


def equal(faces, start_deg=0.0):
    angle = start_deg + np.arange(faces) * 360 / faces
    return ErrorCurve(angle, np.cos(np.radians(angle)))


@pytest.mark.parametrize("faces", [7, 8, 12, 17, 23, 24, 36, 72])
@pytest.mark.parametrize("start_deg", [0.0, 12.345])
def test_seen_order_is_the_nearest_one_by_whole_turns_between_faces(faces, start_deg):
    for alias in aliases(equal(faces, start_deg), multiples=range(1, 9)):
        rest = alias.order % faces
        assert alias.order == 4096 * alias.multiple
        assert alias.seen_order == min(rest, faces - rest)
        assert alias.coherence == pytest.approx(1)


def test_24_faces_by_name():
    assert [(alias.order, alias.seen_order) for alias in aliases(equal(24))] == [
        (4096, 8),
        (8192, 8),
        (12288, 0),
        (16384, 8),
    ]


@pytest.mark.parametrize("multiple", [1, 2, 4])
def test_the_amplitude_named_is_that_of_the_error_within_the_line(multiple):
    angle = np.arange(24) * 15.0
    error = np.cos(np.radians(angle)) + 0.4 * np.cos(np.radians(4096 * multiple * angle) + 0.7)
    alias = aliases(ErrorCurve(angle, error, np.full(24, 0.1)))[multiple - 1]
    assert alias.amplitude_arcsec == pytest.approx(0.4, abs=1e-9)
    assert alias.u_amplitude_arcsec == pytest.approx(0.1 * np.sqrt(2 / 24))
    assert alias.share == pytest.approx(0.16 / 1.16, abs=1e-9)


def test_faces_read_at_scattered_phases_of_the_line_see_no_order():
    random = np.random.default_rng(0)
    curve = equal(24)
    read = curve.angle_deg + random.uniform(0, SIGNAL_PERIOD_DEG, 24)
    scattered = aliases(replace(curve, angle_deg=read))
    assert [alias.seen_order for alias in scattered] == [None] * 4
    fit = fit_curve(replace(curve, angle_deg=read))
    assert aliasing_warning(fit) is None
    assert "no single order" in aliasing_section(fit).rows[0]


def test_readings_better_known_than_the_faces_angles_decide():
    random = np.random.default_rng(0)
    curve = equal(24)
    near = curve.angle_deg[:, np.newaxis] + random.normal(0, 0.02 * SIGNAL_PERIOD_DEG, (24, 4))
    near[3, 2] = np.nan
    first = aliases(curve, near)[0]
    assert first.seen_order == 8
    assert 0.95 < first.coherence < 0.999
    far = curve.angle_deg[:, np.newaxis] + random.uniform(0, SIGNAL_PERIOD_DEG, (24, 4))
    assert aliases(curve, far)[0].seen_order is None


def test_an_arc_is_not_looked_at():
    curve = ErrorCurve(np.arange(0.0, 41.0), np.zeros(41), arc_deg=(0.0, 40.0))
    assert {alias.seen_order for alias in aliases(curve)} == {None}
    assert aliasing_warning(fit_curve(curve)) is None
    assert aliasing_section(fit_curve(curve)).rows == ()


# Offset in degrees: part of an error of order 4096, 8192, 16384 that a second run of 24 faces shows.
SHOWN = {
    2.5: (2.0, 1.0, 1.0),
    5.0: (0.0, 3**0.5, 3**0.5),
    7.5: (2.0, 2.0, 2.0),
    10.0: (0.0, 3**0.5, 3**0.5),
    5 + 158.203125 / 3600: (2.0, 1.735, 1.729),
}


@pytest.mark.parametrize("offset_deg", SHOWN)
def test_what_a_second_run_shows(table_1, offset_deg):
    """+5 deg is blind to order 4096, not to 8192; 7.5 deg, and 5 deg with half a signal period, double it."""
    fit = fit_curve(table_1, "fourier", order=8)
    found = [exposure(fit, order, offset_deg) for order in (4096, 8192, 16384)]
    assert found == pytest.approx(SHOWN[offset_deg], abs=5e-4)
    assert exposure(fit, 12288, offset_deg) == pytest.approx(0, abs=1e-9)
    # The network follows order 8 to one percent between the faces.
    network = [exposure(fit_curve(table_1), order, offset_deg) for order in (4096, 8192, 16384)]
    assert network == pytest.approx(SHOWN[offset_deg], abs=0.02)


@pytest.mark.parametrize("name", FIT_NAMES)
def test_exposure_is_what_a_second_run_then_finds(name):
    """A calibration with an error within the line, a second run beside it: what is left has the amplitude foretold."""
    random = np.random.default_rng(9)
    angle = np.sort((np.arange(24) + random.uniform(-0.1, 0.1, 24)) * 15)
    angle = np.round(angle / SIGNAL_PERIOD_DEG) * SIGNAL_PERIOD_DEG
    second_deg = angle + 5 + 0.3 * SIGNAL_PERIOD_DEG
    phases = np.linspace(0, 2 * np.pi, 12, endpoint=False)[:, np.newaxis]

    def error(deg):
        return 0.3 * np.cos(np.radians(4096 * deg) + phases)

    fit = fit_curve(ErrorCurve(angle, np.cos(np.radians(angle)), np.full(24, 0.01)), name)
    left = error(second_deg) - error(angle) @ fit.weights(second_deg).T
    left = left - left.mean(axis=1, keepdims=True)
    found = np.sqrt(2 * np.mean(left**2)) / 0.3
    assert exposure_at(fit, 4096, second_deg) == pytest.approx(found, rel=1e-9)


def test_the_best_extra_angle_for_24_faces(table_1):
    fit = fit_curve(table_1)
    rows = telling_offsets(fit, aliases(table_1))
    assert [round(offset, 4) for offset, _ in rows[:2]] == [7.5, 5.0439]
    assert min(rows[0][1][0], rows[0][1][1], rows[0][1][3]) > 1.97
    worst = {round(offset, 4): factors[0] for offset, factors in rows}
    assert worst[5.0] < 0.02


def test_table_2_stands_out_at_order_8(table_1, table_2, table_3):
    """42 % of Table 2 is of order 8, where an error of order 4096 would be: suggestive, no proof."""
    second, third, first = (aliases(table)[0] for table in (table_2, table_3, table_1))
    assert second.amplitude_arcsec == pytest.approx(0.459, abs=5e-4)
    assert second.share == pytest.approx(0.42, abs=0.005)
    assert second.p == pytest.approx(0.004, abs=5e-4)
    assert third.amplitude_arcsec == pytest.approx(0.350, abs=5e-4)
    assert first.amplitude_arcsec == pytest.approx(0.759, abs=5e-4)
    assert first.share == pytest.approx(0.19, abs=0.005)
    text = " ".join(aliasing_section(fit_curve(table_2)).paragraphs)
    assert "largest order of this curve is 8" in text
    assert "(Fisher's g test) is 0.045" in text


def test_re_mounting_brings_the_burnt_in_wave_back():
    """Electrical phase at face 1 shifted by s between calibration and check: amplitude 2 A sin(s / 2) at order 8."""
    angle = np.arange(24) * 15.0
    for shift_arcsec in (0, 20, 50, 158.2):
        shift = 2 * np.pi * shift_arcsec / (SIGNAL_PERIOD_DEG * 3600)
        burnt_in = 0.3 * np.cos(np.radians(4096 * angle) + 0.7)
        checked = 0.3 * np.cos(np.radians(4096 * angle) + 0.7 + shift)
        left = ErrorCurve(angle, checked - burnt_in)
        assert (aliases(left)[0].amplitude_arcsec or 0) == pytest.approx(2 * 0.3 * np.sin(shift / 2), abs=1e-9)


def test_the_warning_says_order_amplitude_and_the_angle_that_tells(table_1):
    warning = aliasing_warning(fit_curve(replace(table_1, u_arcsec=np.full(24, 0.2))))
    assert "An error of order 4096, 8192, 16384 (within a grating line) looks like order 8 to these faces" in warning
    assert "where 0.759 (u 0.058) arcsec of the curve stand, 19 % of its power" in warning
    assert "every face 7.5 deg further on shows it at 1.98 times its amplitude or more" in warning


def test_faces_that_see_a_constant_only_get_no_warning_but_are_told():
    fit = fit_curve(equal(8))
    assert aliasing_warning(fit) is None
    section = aliasing_section(fit)
    assert {row[1] for row in section.rows} == {"a constant"}
    assert "only a fine scan shows it" in section.paragraphs[0]


@pytest.mark.parametrize(("offset_deg", "blind"), [(5, True), (10, True), (7.5, False), (2.5, False), (0, True)])
def test_a_second_run_that_is_blind_is_named(table_1, offset_deg, blind):
    second = ErrorCurve(table_1.angle_deg + offset_deg, table_1.error_arcsec)
    sentences = blind_sentences(fit_curve(table_1), second)
    assert bool(sentences) == blind
    if blind:
        assert "order 4096 (seen as 8)" in sentences[0]
        assert ("8192" in sentences[0]) == (offset_deg == 0)


def test_sections_are_whole(table_1):
    section = aliasing_section(fit_curve(table_1))
    assert all(len(row) == len(section.columns) for row in section.rows)
    assert [row[0] for row in section.rows] == ["4096", "8192", "12288", "16384"]
    assert [row[5] for row in section.rows] == ["1.98 x", "1.98 x", "0.00 x", "1.98 x"]
