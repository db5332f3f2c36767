"""Polygon runs made up for tests of budget, Monte Carlo and report: a known encoder, read with known noise."""

import numpy as np

from arcref.calibration.tower_tilt import horizontal_reading_arcsec, vertical_reading_arcsec


def polygon_run_text(
    faces=24, rounds=4, directions=(1,), noise_arcsec=0.2, seed=1, psi_arcsec=None, omega_deg=40.0, y_noise_arcsec=0.1,
    drift_arcsec=0.0, return_arcsec=0.0, first_deg=0.0, certificate=True, metadata=(),
    harmonics=((1, 2.0), (2, 1.0), (3, 0.7)),
) -> str:  # fmt: skip
    """A run file. `drift_arcsec`: over each round; `return_arcsec`: forward minus backward, a constant."""
    random = np.random.default_rng(seed)
    theta = 360.0 / faces * np.arange(faces)
    angle = first_deg + theta
    error = sum(size * np.sin(np.radians(order * angle) + order) for order, size in harmonics)
    deviation = np.round(random.normal(0.0, 1.5, faces), 2)
    deviation[0] = 0.0
    lines = [f"# {key}: {value}" for key, value in (("faces", faces), *metadata)]
    columns = ["round", "direction", "position_deg"]
    columns += ["face_deviation_arcsec"] * certificate + ["autocollimator_x_arcsec"]
    columns += ["autocollimator_y_arcsec"] * (psi_arcsec is not None)
    lines.append(",".join(columns))
    for number in range(1, rounds + 1):
        for direction in directions:
            for step in range(faces + 1):
                face = direction * step % faces
                x = error[face] + (deviation[face] if certificate else 0.0)
                x += random.normal(0.0, noise_arcsec) + drift_arcsec * step / faces + direction * return_arcsec / 2
                position = angle[face] + (360.0 * direction if step == faces else 0.0)
                row = [number, direction, f"{position:.6f}"]
                row += [f"{deviation[face]:.2f}"] * certificate
                if psi_arcsec is not None:
                    x += horizontal_reading_arcsec(theta[face], psi_arcsec, omega_deg)
                    y = vertical_reading_arcsec(theta[face], psi_arcsec, omega_deg) + random.normal(0.0, y_noise_arcsec)
                    row += [f"{x:.4f}", f"{y:.4f}"]
                else:
                    row.append(f"{x:.4f}")
                lines.append(",".join(map(str, row)))
    return "\n".join(lines) + "\n"


STATED = (
    ("u_face_certificate_arcsec", 0.10),
    ("u_autocollimator_arcsec", 0.08),
    ("u_autocollimator_roll_arcmin", 0.5),
    ("u_eccentric_mounting_arcsec", 0.03),
    ("u_interpolation_arcsec", 0.05),
)
"""All that a run with y readings must state for its budget to be complete."""
