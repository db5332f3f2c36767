"""The disc: where its lines stand, and how it sits on the shaft."""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import LINES_PER_TURN

ARCSEC_PER_RAD = np.degrees(1.0) * 3600.0


@dataclass(frozen=True, eq=False)
class GratingDisc:
    """A disc of 4096 lines.

    `radius_mm`: of the grating's middle; `eccentricity_um`, towards `eccentricity_deg`: the grating's middle off the
    shaft's axis, a single head then errs by eccentricity / radius with order 1; `ellipse_arcsec`, `ellipse_deg`: order
    2 of the disc's shape; `harmonics`: further (order, arcsec, deg) of the graduation; `line_error_arcsec`:
    float64[4096], where each line stands, or None. A positive error makes the reading too large.
    """

    radius_mm: float = 95.0
    eccentricity_um: float = 0.0
    eccentricity_deg: float = 0.0
    ellipse_arcsec: float = 0.0
    ellipse_deg: float = 0.0
    harmonics: tuple[tuple[int, float, float], ...] = ()
    line_error_arcsec: np.ndarray | None = field(default=None, repr=False)

    @property
    def eccentricity_arcsec(self) -> float:
        """Amplitude of the error that eccentricity makes in one head."""
        return self.eccentricity_um / (self.radius_mm * 1000.0) * ARCSEC_PER_RAD

    def line_offset_arcsec(self, disc_deg) -> np.ndarray:
        """How far the lines are off at places of the disc, of any shape."""
        angle = np.radians(np.mod(disc_deg, 360.0))
        terms = (
            (1, self.eccentricity_arcsec, self.eccentricity_deg),
            (2, self.ellipse_arcsec, self.ellipse_deg),
            *self.harmonics,
        )
        offset = np.zeros(np.shape(angle))
        for order, amplitude, phase_deg in terms:
            if amplitude:
                offset += amplitude * np.sin(order * angle + np.radians(phase_deg))
        if self.line_error_arcsec is not None:
            # A head sees many lines at once, so from line to line the error changes smoothly.
            place = angle * (LINES_PER_TURN / (2 * np.pi))
            offset += np.interp(place, np.arange(LINES_PER_TURN), self.line_error_arcsec, period=LINES_PER_TURN)
        return offset
