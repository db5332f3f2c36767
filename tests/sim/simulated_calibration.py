"""A calibration from the simulated run file on, by the functions that the command uses, and the truth beside it."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.fits.fit_names import DEFAULT_FIT, fit_curve
from arcref.calibration.polygon_reduction import reduce_polygon
from arcref.calibration.polygon_run import PolygonRun, read_polygon_run
from arcref.correction_rom import CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref_sim.metrology.known_encoder import Harmonic, KnownEncoder
from arcref_sim.metrology.operator_mistakes import MISTAKES
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.run_file_text import run_file_text
from arcref_sim.metrology.simulated_polygon import Autocollimator, PolygonConditions, PolygonReadings, simulate_polygon

ORDERS = (1, 2, 3, 4, 8)
WHOLE_AMPLITUDE_ARCSEC = 3.0

# Prime, so that every place within a count, a grating line and a cell of the tables has its turn.
_ANGLES = 16381

NAMED = {
    "sign": "the sign of x seems to be flipped",
    "arcmin": "x seems to be in minutes of arc",
    "order": "faces in the wrong order",
    "skip": "was skipped",
    "jump": "was skipped",
    "clockwise": "was it turned clockwise for counter-clockwise",
    "certificate-order": "counted clockwise for counter-clockwise",
    "certificate-shift": "face 1 of the run seems to be the one whose deviation stands at face",
    "certificate-slip": "the polygon seems to have jumped one face|a line of it was lost or doubled",
}
"""What must be said of each mistake of the operator, as regular expressions.

In a single round a slip in the certificate and a polygon that jumped look the same.
"""


@dataclass(frozen=True)
class SimulatedCalibration:
    """A simulated polygon run with everything random drawn from `seed`; noise is that of one reading."""

    seed: int
    faces: int = 24
    rounds: int = 4
    backward: bool = False
    noise_arcsec: float = 0.2
    deviation_arcsec: float = 2.0
    certificate_error_arcsec: float = 0.0
    tilt_arcsec: float = 0.0
    sign: int = 1
    mistake: str | None = None
    conditions: dict = field(default_factory=dict)

    @property
    def encoder(self) -> KnownEncoder:
        """Harmonics 1, 2, 3, 4, 8 of 3 arcsec in all, shared out and turned at random."""
        rng = np.random.default_rng([self.seed, 10])
        amplitudes = WHOLE_AMPLITUDE_ARCSEC * rng.dirichlet(np.ones(len(ORDERS)))
        phases = rng.uniform(0, 360, len(ORDERS))
        terms = zip(ORDERS, amplitudes.tolist(), phases.tolist(), strict=True)
        return KnownEncoder(tuple(Harmonic(*term) for term in terms))

    @property
    def tilt_azimuth_deg(self) -> float:
        """Where the tilt leans to."""
        return float(np.random.default_rng([self.seed, 12]).uniform(0, 360))

    def readings(self) -> PolygonReadings:
        """The run as the operator took it."""
        rng = np.random.default_rng([self.seed, 11])
        artefact = PolygonArtefact.random(
            rng,
            self.faces,
            deviation_arcsec=self.deviation_arcsec,
            certificate_error_arcsec=self.certificate_error_arcsec,
        )
        conditions = PolygonConditions(
            rounds=self.rounds,
            backward=self.backward,
            tilt_arcsec=self.tilt_arcsec,
            tilt_azimuth_deg=self.tilt_azimuth_deg,
            **self.conditions,
        )
        autocollimator = Autocollimator(self.noise_arcsec, self.noise_arcsec, sign=self.sign)
        readings = simulate_polygon(self.encoder, artefact, autocollimator, conditions, rng)
        return MISTAKES[self.mistake](readings, self.faces, rng)[0] if self.mistake else readings

    def write(self, path: Path) -> Path:
        """The run file, all that is known stated in it."""
        metadata = {
            "encoder_serial": f"SIM-{self.seed}",
            "faces": self.faces,
            "autocollimator_sign": f"{self.sign:+d}",
            "u_face_certificate_arcsec": self.certificate_error_arcsec,
            "u_autocollimator_arcsec": 0.0,
            "u_autocollimator_roll_arcmin": 0.0,
            "u_eccentric_mounting_arcsec": 0.0,
            "u_temperature_arcsec": 0.0,
            "u_interpolation_arcsec": 0.0,
        }
        path.write_text(run_file_text(metadata, self.readings().columns()), encoding="utf-8")
        return path

    def run(self, folder: Path) -> PolygonRun:
        """The run as it is read back from its file."""
        return read_polygon_run(self.write(folder / "run.csv"))

    def curve(self, folder: Path) -> ErrorCurve:
        """The reduced curve."""
        reduction = reduce_polygon(self.run(folder))
        return ErrorCurve(reduction.angle_deg, reduction.error_arcsec)

    def rom(self, folder: Path, fit: str = DEFAULT_FIT) -> CorrectionRom:
        """The ROM made of it."""
        return CorrectionRom.from_fit(fit_curve(self.curve(folder), fit).evaluate)


def corrected_errors_arcsec(rom: CorrectionRom, encoder: KnownEncoder) -> np.ndarray:
    """Error of the corrected angle about its mean, the shaft standing at angles all over the turn."""
    true_deg = np.arange(_ANGLES) * (360.0 / _ANGLES)
    corrected = rom.correct(encoder.count(true_deg)) * ARCSEC_PER_COUNT
    error = corrected - true_deg * 3600.0
    return error - error.mean()


def rms(values) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(np.square(values))))
