"""How the readings of a polygon run lie in series.

A series is one round in one direction: every face once, and then, if the operator did so, the first face again, the
closing reading.
"""

from dataclasses import dataclass

import numpy as np

FORWARD, BACKWARD = 1, -1


@dataclass(frozen=True, eq=False)
class PolygonSeries:
    """How n readings of a polygon lie in series; face 0 is the one that was read first.

    `angle_deg`: float64[faces], the encoder's angle at each face, first that of face 0; `face`: int[n];
    `reading_of_face`: int[series, faces], which reading each series has of a face; `closing_reading`: int[series], the
    reading of its first face again, -1 for none; `first_reading`: int[series]; `round`, `direction`: of each series.
    """

    angle_deg: np.ndarray
    face: np.ndarray
    reading_of_face: np.ndarray
    first_reading: np.ndarray
    closing_reading: np.ndarray
    round: tuple[int, ...]
    direction: tuple[int, ...]

    @property
    def theta_deg(self) -> np.ndarray:
        """How far from face 0 each face stands, float64[faces]."""
        return self.angle_deg - self.angle_deg[0]

    @property
    def weight(self) -> np.ndarray:
        """Of each series in the mean, float64[series]: both directions count alike, whatever their number."""
        direction = np.array(self.direction)
        return 1.0 / (np.array([(direction == own).sum() for own in direction]) * len(set(self.direction)))
