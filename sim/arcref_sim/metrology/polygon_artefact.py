"""A polygon as it is, and as its certificate has it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class PolygonArtefact:
    """All float64[faces].

    `deviation_arcsec`: azimuth of each face's normal less its nominal one, counter-clockwise from face 1 (whose own is
    0); `certificate_arcsec`: what the certificate says of that; `pyramid_arcsec`: elevation of each normal;
    `slope_arcsec_per_mm`: how the normal's azimuth changes along the face, as its flatness leaves it.
    """

    deviation_arcsec: np.ndarray
    certificate_arcsec: np.ndarray
    pyramid_arcsec: np.ndarray
    slope_arcsec_per_mm: np.ndarray

    @classmethod
    def random(
        cls,
        rng: np.random.Generator,
        faces: int,
        *,
        deviation_arcsec: float = 0.0,
        certificate_error_arcsec: float = 0.0,
        pyramid_arcsec: float = 0.0,
        flatness_arcsec_per_mm: float = 0.0,
    ) -> "PolygonArtefact":
        """A polygon with normally distributed deviations; each number is a standard deviation.

        Face 1 is where azimuths and certificate start, so both are 0 there and its own error is in all the others.
        """
        deviation, error, pyramid, slope = rng.standard_normal((4, faces))
        deviation, error = deviation_arcsec * deviation, certificate_error_arcsec * error
        certificate = deviation + error
        return cls(
            deviation - deviation[0],
            certificate - certificate[0],
            pyramid_arcsec * pyramid,
            flatness_arcsec_per_mm * slope,
        )

    @property
    def faces(self) -> int:
        """Number of faces."""
        return len(self.deviation_arcsec)

    @property
    def azimuth_deg(self) -> np.ndarray:
        """True azimuth of each face's normal on the polygon, float64[faces]."""
        return np.arange(self.faces) * (360.0 / self.faces) + self.deviation_arcsec / 3600.0

    def truth(self) -> dict:
        """All there is to know, ready for JSON."""
        return {
            "faces": self.faces,
            "face_deviation_arcsec": np.round(self.deviation_arcsec, 6).tolist(),
            "certificate_arcsec": np.round(self.certificate_arcsec, 6).tolist(),
            "face_pyramid_arcsec": np.round(self.pyramid_arcsec, 6).tolist(),
            "face_slope_arcsec_per_mm": np.round(self.slope_arcsec_per_mm, 6).tolist(),
        }
