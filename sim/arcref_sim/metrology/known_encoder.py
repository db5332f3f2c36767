"""An encoder whose error is known at every angle: harmonics of the turn and of a grating line, or a given curve."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arcref.angle import COUNTS_PER_TURN, LINES_PER_TURN

ARCSEC_PER_DEG = 3600.0

# The error changes by far less than its argument, so each step gains three digits or more.
_STEPS_TO_INVERT = 12


@dataclass(frozen=True)
class Harmonic:
    """One term of the error: `amplitude_arcsec * sin(order * angle + phase_deg)`; `order` in cycles a turn."""

    order: int
    amplitude_arcsec: float
    phase_deg: float

    @classmethod
    def within_line(cls, order: int, amplitude_arcsec: float, phase_deg: float) -> "Harmonic":
        """A term of the error within a grating line, `order` in cycles a line."""
        return cls(order * LINES_PER_TURN, amplitude_arcsec, phase_deg)


@dataclass(frozen=True)
class KnownEncoder:
    """The encoder: reading = true angle + error(true angle) - direction * hysteresis / 2.

    `curve`: a further error in arcsec as a function of the true angle in degrees (array in, array out), or None.
    `hysteresis_arcsec`: forward reading less reverse reading is minus this, so the encoder lags behind its shaft;
    `hysteresis_variation_arcsec` is added to it times sin(angle), because a lag that is the same at every angle
    vanishes when each series counts from its own first face.
    """

    harmonics: tuple[Harmonic, ...] = ()
    curve: Callable[[np.ndarray], np.ndarray] | None = None
    hysteresis_arcsec: float = 0.0
    hysteresis_variation_arcsec: float = 0.0

    def error_arcsec(self, true_deg) -> np.ndarray:
        """The error, the mean of both directions, at true angles in degrees; an array of the same shape."""
        true_deg = np.asarray(true_deg, float)
        total = np.zeros(true_deg.shape)
        for term in self.harmonics:
            # The turn is taken off first: a high order times many turns would cost digits of the phase.
            phase = np.radians(np.mod(true_deg, 360.0) * term.order + term.phase_deg)
            total += term.amplitude_arcsec * np.sin(phase)
        return total if self.curve is None else total + self.curve(np.mod(true_deg, 360.0))

    def return_error_arcsec(self, true_deg) -> np.ndarray:
        """Forward reading less reverse reading at the same true angle."""
        return -(self.hysteresis_arcsec + self.hysteresis_variation_arcsec * np.sin(np.radians(true_deg)))

    def reading_deg(self, true_deg, direction=0) -> np.ndarray:
        """The reading at true angles, turns kept, not rounded; `direction` +1 forward, -1 reverse, 0 the mean."""
        true_deg = np.asarray(true_deg, float)
        error_arcsec = self.error_arcsec(true_deg) + 0.5 * direction * self.return_error_arcsec(true_deg)
        return true_deg + error_arcsec / ARCSEC_PER_DEG

    def true_deg(self, reading_deg, direction=0) -> np.ndarray:
        """The true angle at which the encoder reads `reading_deg`: the inverse of `reading_deg`."""
        reading_deg = np.asarray(reading_deg, float)
        true_deg = reading_deg
        for _ in range(_STEPS_TO_INVERT):
            true_deg = true_deg - (self.reading_deg(true_deg, direction) - reading_deg)
        return true_deg

    def count(self, true_deg, direction=0) -> np.ndarray:
        """The count that the encoder shows at true angles, turns kept, int64: a count begins at its own reading."""
        return np.floor(self.reading_deg(true_deg, direction) * (COUNTS_PER_TURN / 360.0)).astype(np.int64)

    @property
    def within_line_amplitude_arcsec(self) -> float:
        """Sum of the amplitudes of the terms within a grating line: the error there is no larger."""
        return float(sum(term.amplitude_arcsec for term in self.harmonics if term.order >= LINES_PER_TURN))

    def truth(self) -> dict:
        """All there is to know, ready for JSON: the terms, and the error at every degree of the turn."""
        angle_deg = np.arange(360)
        return {
            "error": "reading - true angle = sum of amplitude_arcsec * sin(order * angle + phase_deg), and the curve",
            "harmonics": [
                {"order": term.order, "amplitude_arcsec": term.amplitude_arcsec, "phase_deg": term.phase_deg}
                for term in self.harmonics
            ],
            "hysteresis_arcsec": self.hysteresis_arcsec,
            "hysteresis_variation_arcsec": self.hysteresis_variation_arcsec,
            "angle_deg": angle_deg.tolist(),
            "error_arcsec": np.round(self.error_arcsec(angle_deg), 6).tolist(),
        }
