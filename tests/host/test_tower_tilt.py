"""The figures of Tian Liude et al., Acta Optica Sinica 35(5) 2015 0512003, and what a fit of the tilt reaches.

Where the print is wrong the right figure is asserted and the printed one named. The rotation is SciPy's, so that the
project's own formulas are held against something else.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from arcref.calibration.tower_tilt import (
    ARCSEC_PER_RADIAN,
    UNKNOWN_AZIMUTH_U_DEG,
    fit_tilt,
    horizontal_reading_arcsec,
    vertical_reading_arcsec,
)

FINE_DEG = np.arange(0, 360, 0.1)


def rotated_normals(theta_deg, psi_arcsec, omega_deg):
    """Normals (toward, sideways, up) of the faces at theta once the shaft turned by -theta about the tilted axis."""
    theta, psi, omega = np.radians(theta_deg), psi_arcsec / ARCSEC_PER_RADIAN, np.radians(omega_deg)
    axis = np.array([np.sin(psi) * np.cos(omega), np.sin(psi) * np.sin(omega), np.cos(psi)])
    normal = np.stack([np.cos(theta), np.sin(theta), np.zeros_like(theta)], axis=-1)
    return Rotation.from_rotvec(-theta[:, np.newaxis] * axis).apply(normal).T


def readings(theta_deg, psi_arcsec, omega_deg):
    toward, sideways, up = rotated_normals(theta_deg, psi_arcsec, omega_deg)
    return np.arctan2(sideways, toward) * ARCSEC_PER_RADIAN, np.arctan2(up, toward) * ARCSEC_PER_RADIAN


def simple_horizontal(theta_deg, omega_deg):
    """f of equation (12)."""
    theta, omega = np.radians(theta_deg), np.radians(omega_deg)
    return np.sin(omega) * (1 - np.cos(theta)) * np.cos(omega - theta) + np.sin(theta) * np.cos(theta) / 2


@given(st.floats(0, 3600), st.floats(-360, 360), st.floats(-720, 720))
def test_the_exact_model_is_a_rotation_about_the_tilted_axis(psi_arcsec, omega_deg, theta_deg):
    x, y = readings(np.array([theta_deg]), psi_arcsec, omega_deg)
    assert horizontal_reading_arcsec(theta_deg, psi_arcsec, omega_deg) == pytest.approx(x[0], abs=1e-9)
    assert vertical_reading_arcsec(theta_deg, psi_arcsec, omega_deg) == pytest.approx(y[0], abs=1e-9)


@pytest.mark.parametrize(("psi_arcsec", "omega_deg"), [(300, 90), (600, 37), (1369, -120)])
def test_the_printed_component_5_lacks_a_term(psi_arcsec, omega_deg):
    """With `- S cos(omega) sin^2(theta)` restored, (3) to (5) are the rotation; without it y is off by psi."""
    psi, omega = psi_arcsec / ARCSEC_PER_RADIAN, np.radians(omega_deg)
    s, c, so, co = np.sin(psi), np.cos(psi), np.sin(omega), np.cos(omega)
    theta_deg = FINE_DEG
    cosine, sine = np.cos(np.radians(theta_deg)), np.sin(np.radians(theta_deg))
    rest = 1 - cosine
    toward = (cosine + s**2 * co**2 * rest) * cosine + (s**2 * co * so * rest + c * sine) * sine
    sideways = (s**2 * co * so * rest - c * sine) * cosine + (cosine + s**2 * so**2 * rest) * sine
    printed = (s * c * co * rest + s * so * sine) * cosine + s * c * so * rest * sine
    right = printed - s * co * sine * sine
    exact = rotated_normals(theta_deg, psi_arcsec, omega_deg)
    for component, true in zip((toward, sideways, right), exact, strict=True):
        assert np.abs(component - true).max() * ARCSEC_PER_RADIAN < 1e-9
    off = np.abs(printed - exact[2]).max() * ARCSEC_PER_RADIAN
    assert off == pytest.approx(psi_arcsec * abs(co), rel=1e-3, abs=1e-9)


def test_the_printed_matrix_2_is_no_rotation():
    """Entry (1,3) must be Lx Lz (1 - cos) + Ly sin; printed with a minus the matrix is not orthogonal."""
    axis, angle = np.array([2.0, 3.0, 6.0]) / 7, np.radians(70.0)
    matrix = Rotation.from_rotvec(axis * angle).as_matrix()
    assert matrix[0, 2] == pytest.approx(axis[0] * axis[2] * (1 - np.cos(angle)) + axis[1] * np.sin(angle))
    matrix[0, 2] -= 2 * axis[1] * np.sin(angle)
    assert np.abs(matrix @ matrix.T - np.eye(3)).max() > 0.1


@pytest.mark.parametrize(
    ("psi_arcsec", "x_off", "y_off"), [(300, 1e-6, 4e-4), (600, 1.6e-5, 3.6e-3), (1369, 4.5e-4, 0.042)]
)
def test_the_simplified_laws_12_and_13(psi_arcsec, x_off, y_off):
    x_most, y_most = 0.0, 0.0
    for omega_deg in range(0, 360, 15):
        x, y = readings(FINE_DEG, psi_arcsec, omega_deg)
        omega, theta = np.radians(omega_deg), np.radians(FINE_DEG)
        x_most = max(
            x_most, np.abs(psi_arcsec**2 / ARCSEC_PER_RADIAN * simple_horizontal(FINE_DEG, omega_deg) - x).max()
        )
        y_most = max(y_most, np.abs(psi_arcsec * (np.cos(omega - theta) - np.cos(omega)) - y).max())
    assert x_most == pytest.approx(x_off, rel=0.12)
    assert y_most == pytest.approx(y_off, rel=0.12)


def test_the_forms_of_equation_12():
    theta, omega = np.radians(FINE_DEG)[:, np.newaxis], np.radians(np.arange(0, 360, 7.0))
    f = simple_horizontal(np.degrees(theta), np.degrees(omega))
    compact = (np.sin(theta) + (1 - np.cos(theta)) * np.sin(2 * omega - theta)) / 2
    harmonic = np.sin(omega) * np.cos(theta - omega) + np.sin(2 * (theta - omega)) / 4 - np.sin(2 * omega) / 4
    assert np.abs(compact - f).max() < 1e-12
    # The order 1 and order 2 parts are those of an eccentricity and of an ellipse, against a constant of the azimuth.
    assert np.ptp(harmonic - f, axis=0).max() < 1e-12
    spectrum = 2 * np.abs(np.fft.rfft(f, axis=0)) / len(FINE_DEG)
    assert spectrum[1] == pytest.approx(np.abs(np.sin(omega)), abs=1e-9)
    assert spectrum[2] == pytest.approx(np.full(omega.size, 0.25), abs=1e-9)


def coefficient(theta_deg, omega_deg):
    return simple_horizontal(theta_deg, omega_deg) / ARCSEC_PER_RADIAN


def test_coefficients_at_omega_90():
    assert coefficient(179.0, 90.0) == pytest.approx(0.126911e-6, rel=1e-5)  # printed 0.1269e-6
    assert coefficient(111.0, 90.0) == pytest.approx(0.533714e-5, rel=1e-6)  # printed 0.5337e-5
    fine = np.arange(0, 180, 0.001)
    peak = coefficient(fine, 90.0)
    assert peak.max() == pytest.approx(0.533740e-5, rel=1e-6)
    assert fine[peak.argmax()] == pytest.approx(111.47, abs=0.005)


def largest(psi_arcsec, omega_deg):
    return np.abs(horizontal_reading_arcsec(FINE_DEG, psi_arcsec, omega_deg)).max()


def test_errors_at_5_arcmin():
    """Printed 0.11 to 0.48 over omega: these are the values at 0 and 90 deg, not the least and the largest."""
    assert largest(300, 0) == pytest.approx(0.1091, abs=5e-5)
    assert largest(300, 180) == pytest.approx(0.1091, abs=5e-5)
    assert largest(300, 45) == pytest.approx(0.4724, abs=5e-5)
    assert largest(300, 90) == pytest.approx(0.4804, abs=1e-4)
    for omega_deg in (67.5, 112.5, 247.5, 292.5):
        assert largest(300, omega_deg) == pytest.approx(0.5267, abs=5e-5)


def test_worst_and_best_azimuth():
    """Printed: worst at 90 and 270, best at 0 and 180. Worst holds for the span, not for the largest error."""
    omega_deg = np.arange(0, 360, 0.5)
    x = horizontal_reading_arcsec(FINE_DEG, 300.0, omega_deg[:, np.newaxis])
    span, most = np.ptp(x, axis=1), np.abs(x).max(axis=1)
    assert omega_deg[span.argmax()] in (90, 270)
    assert span.max() == pytest.approx(0.9607, abs=5e-5)
    assert omega_deg[span.argmin()] in (0, 180)
    assert omega_deg[most.argmin()] in (0, 180)
    assert omega_deg[most.argmax()] in (67.5, 112.5, 247.5, 292.5)
    at = np.abs(horizontal_reading_arcsec(FINE_DEG, 300.0, 67.5))
    assert FINE_DEG[at.argmax()] == pytest.approx(225, abs=0.11)
    worst = (1 + np.sqrt(2)) / 2 / ARCSEC_PER_RADIAN
    assert worst == pytest.approx(0.58522e-5, rel=1e-5)
    assert most.max() / 300**2 == pytest.approx(worst, rel=1e-5)
    assert worst / 0.5337e-5 == pytest.approx(1.097, abs=5e-4)


def test_errors_at_10_arcmin():
    assert largest(600, 90) == pytest.approx(1.9214, abs=1e-4)  # printed 1.92
    assert max(largest(600, omega_deg) for omega_deg in np.arange(0, 360, 2.5)) == pytest.approx(2.107, abs=5e-4)


def test_the_error_grows_as_the_square_of_the_tilt():
    ratio = horizontal_reading_arcsec(FINE_DEG[1:], 200.0, 50.0) / horizontal_reading_arcsec(FINE_DEG[1:], 100.0, 50.0)
    assert np.median(ratio) == pytest.approx(4, rel=1e-6)


@pytest.mark.parametrize(("psi_arcsec", "least_span"), [(300, 599.9994), (600, 1199.995)])
def test_y_peaks_at_omega_and_spans_twice_the_tilt(psi_arcsec, least_span):
    """It holds for the signed reading, not for its absolute value."""
    for omega_deg in (10.0, 90.0, 200.0, 333.0):
        y = vertical_reading_arcsec(FINE_DEG, psi_arcsec, omega_deg)
        assert FINE_DEG[y.argmax()] == pytest.approx(omega_deg)
        assert FINE_DEG[y.argmin()] == pytest.approx((omega_deg + 180) % 360)
        assert least_span - 1e-3 < np.ptp(y) < 2 * psi_arcsec + 1e-6


@given(st.floats(0.5, 3000), st.floats(-180, 180), st.floats(-2000, 2000), st.integers(3, 72))
def test_the_fit_finds_any_tilt_without_noise(psi_arcsec, omega_deg, offset_arcsec, faces):
    theta_deg = np.arange(faces) * 360.0 / faces
    tilt = fit_tilt(theta_deg, vertical_reading_arcsec(theta_deg, psi_arcsec, omega_deg) + offset_arcsec)
    assert tilt.psi_arcsec == pytest.approx(psi_arcsec, abs=1e-7)
    assert (tilt.omega_deg - omega_deg + 180) % 360 - 180 == pytest.approx(0, abs=1e-5)
    assert tilt.offset_arcsec == pytest.approx(offset_arcsec, abs=1e-7)


@pytest.mark.parametrize(("psi_arcsec", "change"), [(300, 3e-4), (600, 2.8e-3), (1369, 0.033)])
def test_the_linear_law_alone_is_a_little_off(psi_arcsec, change):
    theta = np.radians(np.arange(24) * 15.0)
    design = np.stack([np.cos(theta), np.sin(theta), np.ones(24)], axis=1)
    most = 0.0
    for omega_deg in range(0, 360, 10):
        y = vertical_reading_arcsec(np.degrees(theta), psi_arcsec, omega_deg)
        a, b, _ = np.linalg.lstsq(design, y, rcond=None)[0]
        most = max(most, abs(np.hypot(a, b) - psi_arcsec))
    assert most == pytest.approx(change, rel=0.25)


SD_PSI = {
    0.05: {8: 0.025, 12: 0.020, 24: 0.014, 36: 0.012},
    0.1: {8: 0.050, 12: 0.041, 24: 0.029, 36: 0.024},
    0.2: {8: 0.100, 12: 0.082, 24: 0.058, 36: 0.047},
}
SD_OMEGA = {
    0.05: {8: 0.0048, 12: 0.0039, 24: 0.0028, 36: 0.0023},
    0.1: {8: 0.0095, 12: 0.0078, 24: 0.0055, 36: 0.0045},
    0.2: {8: 0.019, 12: 0.016, 24: 0.011, 36: 0.0090},
}
LEFT = {8: 1.0e-4, 12: 0.8e-4, 24: 0.6e-4, 36: 0.5e-4}
"""Rms of x after correction for psi = 300 arcsec and 0.1 arcsec of noise, as the table of SCIENCE has it at 0.2."""


def simulated_fits(faces, sigma_arcsec, psi_arcsec=300.0, runs=4000, seed=5):
    random = np.random.default_rng(seed)
    theta_deg = np.arange(faces) * 360.0 / faces
    omega_deg = random.uniform(-180, 180, (runs, 1))
    y = vertical_reading_arcsec(theta_deg, psi_arcsec, omega_deg) + random.normal(0, sigma_arcsec, (runs, faces))
    tilt = fit_tilt(theta_deg, y)
    left = tilt.horizontal_arcsec(theta_deg) - horizontal_reading_arcsec(theta_deg, psi_arcsec, omega_deg)
    return tilt, np.mod(tilt.omega_deg - omega_deg[:, 0] + 180, 360) - 180, left


@pytest.mark.parametrize("faces", [8, 12, 24, 36])
@pytest.mark.parametrize("sigma_arcsec", [0.05, 0.1, 0.2])
def test_uncertainty_of_the_tilt(faces, sigma_arcsec):
    """sd(psi) = sigma sqrt(2/n), sd(omega) = that over psi; by Monte Carlo, and as the fit itself states it."""
    tilt, omega_off, left = simulated_fits(faces, sigma_arcsec)
    assert tilt.psi_arcsec.std() == pytest.approx(SD_PSI[sigma_arcsec][faces], rel=0.06)
    assert omega_off.std() == pytest.approx(SD_OMEGA[sigma_arcsec][faces], rel=0.06)
    assert tilt.psi_arcsec.std() == pytest.approx(sigma_arcsec * np.sqrt(2 / faces), rel=0.05)
    assert np.sqrt(np.mean(tilt.u_psi_arcsec**2)) == pytest.approx(SD_PSI[sigma_arcsec][faces], rel=0.06)
    assert np.sqrt(np.mean(tilt.u_omega_deg**2)) == pytest.approx(SD_OMEGA[sigma_arcsec][faces], rel=0.06)
    assert np.sqrt(np.mean(left**2)) == pytest.approx(LEFT[faces] * sigma_arcsec / 0.1, rel=0.25)


@pytest.mark.parametrize("psi_arcsec", [300.0, 600.0, 1369.0])
def test_what_is_left_of_x_after_correction_is_below_a_thousandth(psi_arcsec):
    """0.1 arcsec of noise in y, 24 faces: the correction is free; the horizontal reading's own noise remains."""
    _, _, left = simulated_fits(24, 0.1, psi_arcsec)
    assert np.sqrt(np.mean(left**2, axis=1)).max() < 0.001
    assert np.abs(left[:300]).max() < {300.0: 1.1e-3, 600.0: 2.0e-3}.get(psi_arcsec, 5e-3)


@pytest.mark.parametrize(("pyramid_arcsec", "sd_psi", "worst"), [(1, 0.28, 0.001), (3, 0.89, 0.003), (5, 1.46, 0.0045)])
def test_tilts_of_the_faces_themselves_do_little(pyramid_arcsec, sd_psi, worst):
    tilt, _, left = simulated_fits(24, pyramid_arcsec)
    assert tilt.psi_arcsec.std() == pytest.approx(sd_psi, rel=0.06)
    assert np.median(np.abs(left).max(axis=1)) < worst


def test_roll_acts_in_the_first_order():
    """1 arcmin of roll at psi = 300 arcsec: 0.087 arcsec; 5 arcmin: 0.436, as much as the tilt's own effect."""
    y = vertical_reading_arcsec(FINE_DEG, 300.0, 90.0)
    for roll_arcmin, amplitude in ((1, 0.087), (5, 0.436)):
        x = np.sin(np.radians(roll_arcmin / 60)) * y
        assert np.ptp(x) / 2 == pytest.approx(amplitude, abs=5e-4)
        assert np.abs(np.fft.rfft(x))[2] < 1e-5 * np.abs(np.fft.rfft(x))[1]  # it looks like eccentricity


@pytest.mark.parametrize(("psi_arcsec", "off"), [(300, 0.007), (600, 0.054), (1369, 0.64)])
def test_a_linear_scale_reads_the_tangent_of_twice_the_angle(psi_arcsec, off):
    def on_scale(arcsec):
        return np.tan(2 * arcsec / ARCSEC_PER_RADIAN) / 2 * ARCSEC_PER_RADIAN

    y = vertical_reading_arcsec(FINE_DEG, psi_arcsec, 180.0)
    x = horizontal_reading_arcsec(FINE_DEG, psi_arcsec, 67.5)
    assert np.abs(on_scale(y) - y).max() == pytest.approx(off, rel=0.1)
    assert np.abs(on_scale(x) - x).max() <= 1.2e-3


def test_three_angles_leave_no_degree_of_freedom():
    theta_deg = np.array([0.0, 120.0, 240.0])
    tilt = fit_tilt(theta_deg, vertical_reading_arcsec(theta_deg, 300.0, 40.0) + [0.1, 0, -0.1])
    assert tilt.degrees_of_freedom == 0
    assert np.isnan([tilt.u_psi_arcsec, tilt.u_omega_deg, tilt.sigma_arcsec]).all()
    assert tilt.psi_arcsec == pytest.approx(300, abs=0.2)


def test_an_azimuth_that_noise_hides_is_not_more_certain_than_unknown():
    random = np.random.default_rng(3)
    tilt = fit_tilt(np.arange(24) * 15.0, random.normal(0, 1.0, (200, 24)) * 1e-3)
    assert tilt.u_omega_deg.max() <= UNKNOWN_AZIMUTH_U_DEG
    assert fit_tilt(np.arange(24) * 15.0, np.zeros(24)).psi_arcsec == 0


@pytest.mark.parametrize("theta_deg", [[0.0, 90.0], [0.0, 90.0, 360.0, 450.0]])
def test_a_tilt_needs_three_angles(theta_deg):
    with pytest.raises(ValueError, match="three different angles"):
        fit_tilt(np.array(theta_deg), np.zeros(len(theta_deg)))
