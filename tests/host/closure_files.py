"""Closure run files of a known encoder and polygon, as text, for tests."""

import numpy as np

COLUMNS = "setting,face,position_deg,autocollimator_x_arcsec"


def closure_rows(
    faces=8, settings=range(1, 9), step_deg=None, *, start_deg=0.0, noise_arcsec=0.05, sign=1, seed=1, stop_arcsec=5.0
) -> list[tuple]:
    """Rows (setting, face, position_deg, x_arcsec), the mountings within 30 arcsec of their nominal angle."""
    random = np.random.default_rng(seed)
    step_deg = 360 / faces if step_deg is None else step_deg
    deviation = np.random.default_rng(77).normal(0, 1.5, faces)
    rows = []
    for setting in settings:
        mounting = random.normal(0, 30)
        for face in range(faces):
            nominal = start_deg + face * 360 / faces + (setting - 1) * step_deg
            stop = random.normal(0, stop_arcsec)
            # reading - nominal + x = encoder error + deviation + mounting
            x = encoder_error(nominal) + deviation[face] + mounting - stop + random.normal(0, noise_arcsec)
            rows.append((setting, face + 1, float(np.mod(nominal + stop / 3600, 360.0)), sign * x))
    return rows


def encoder_error(angle_deg):
    """Error of the encoder in arcsec: orders 1, 2 and 3."""
    angle = np.radians(angle_deg)
    return 2.0 * np.sin(angle + 0.3) + 0.8 * np.sin(2 * angle) + 0.5 * np.cos(3 * angle)


def closure_text(
    rows, metadata="# faces: 8\n# setting_step_deg: 45\n# autocollimator_sign: 1\n", columns=COLUMNS
) -> str:
    """The run file."""
    lines = (f"{setting},{face},{position:.8f},{x:.4f}" for setting, face, position, x in rows)
    return metadata + columns + "\n" + "\n".join(lines) + "\n"
