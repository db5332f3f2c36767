"""Theodolite run files of a known axis, mirror and encoder, as text, for tests."""

import numpy as np

from arcref.calibration.theodolite_model import MirrorGeometry

COLUMNS = "reading_deg,azimuth_deg,zenith_deg"
PUBLISHED = (6.7348, 129.3174, -1.6617)


def encoder_error(theta_deg):
    """Error of the encoder in arcsec."""
    return 2.0 * np.sin(np.radians(9 * np.asarray(theta_deg)))


def theodolite_rows(
    angles=PUBLISHED, theta_deg=range(41), *, noise_arcsec=0.3, north_deg=0.0, start_deg=0.0, direction=1, seed=1
) -> list[tuple]:
    """Rows (reading_deg, azimuth_deg, zenith_deg); `start_deg`: encoder reading at theta = 0."""
    random = np.random.default_rng(seed)
    theta = np.asarray(theta_deg, float)
    geometry = MirrorGeometry.from_angles(*angles)
    azimuth = np.degrees(geometry.azimuth_rad(np.radians(theta))) + north_deg
    zenith = 90 + np.degrees(geometry.elevation_rad(np.radians(theta)))
    azimuth = azimuth + noise_arcsec / 3600 * random.standard_normal(theta.size)
    zenith = zenith + noise_arcsec / 3600 * random.standard_normal(theta.size)
    reading = start_deg + direction * theta + encoder_error(theta) / 3600
    return list(zip(np.mod(reading, 360.0).tolist(), np.mod(azimuth, 360.0).tolist(), zenith.tolist(), strict=True))


STATED = "# u_azimuth_arcsec: 0.3\n# u_zenith_arcsec: 0.3\n"


def theodolite_text(rows, metadata=STATED, columns=COLUMNS) -> str:
    """The run file."""
    lines = (",".join(f"{value:.8f}" for value in row) for row in rows)
    return metadata + columns + "\n" + "\n".join(lines) + "\n"
