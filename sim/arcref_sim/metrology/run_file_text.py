"""The text of a run file: metadata lines, column names, one row for each reading, as `arcref.run_file` reads it."""

import numpy as np

DECIMALS = {
    "position_deg": 8,
    "reading_deg": 8,
    "azimuth_deg": 8,
    "zenith_deg": 8,
    "face_deviation_arcsec": 4,
    "autocollimator_x_arcsec": 4,
    "autocollimator_y_arcsec": 4,
    "time_s": 11,
    "sine_v": 6,
    "cosine_v": 6,
}
"""Decimals of each column, far below a count (0.00004 deg, 0.15 arcsec); columns not named hold whole numbers."""


def run_file_text(metadata: dict[str, object], columns: dict[str, np.ndarray]) -> str:
    """The whole file; values of `metadata` that are None are left out."""
    lines = [f"# {key}: {_shown(value)}" for key, value in metadata.items() if value is not None]
    lines.append(",".join(columns))
    cells = [[f"{value:.{DECIMALS.get(name, 0)}f}" for value in values] for name, values in columns.items()]
    lines += [",".join(row) for row in zip(*cells, strict=True)]
    return "\n".join(lines) + "\n"


def _shown(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
