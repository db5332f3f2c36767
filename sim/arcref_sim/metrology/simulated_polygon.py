"""A simulated polygon run: an encoder of known error turns a polygon before an autocollimator, and all is written down.

The shaft turns clockwise, seen from above, while the encoder counts up, and face after face comes round against the
direction in which the polygon is numbered. With x positive towards OY the error is then
e = (a - a1) - (b - b1) + (c - c1); see SCIENCE, part TW, and `arcref_sim.metrology.face_view`.
"""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import counts_to_deg
from arcref_sim.metrology.face_view import face_view, tilted_axis
from arcref_sim.metrology.known_encoder import KnownEncoder
from arcref_sim.metrology.polygon_artefact import PolygonArtefact

ARCMIN_PER_RAD = np.degrees(1.0) * 60.0


@dataclass(frozen=True)
class Autocollimator:
    """The autocollimator: noise of one reading in x and y, its roll, its scale, and the direction of its x.

    `y_noise_arcsec` None: it has no y. `roll_arcmin`: x reads x cos(roll) + y sin(roll). `scale_error`: x reads
    (1 + scale_error) x. `sign`: +1 when x grows towards OY, -1 when it falls. `offset_arcsec`: x and y of face 1 at
    the start, as aligned.
    """

    x_noise_arcsec: float = 0.0
    y_noise_arcsec: float | None = 0.0
    roll_arcmin: float = 0.0
    scale_error: float = 0.0
    sign: int = 1
    offset_arcsec: tuple[float, float] = (0.0, 0.0)

    def readings(self, x_arcsec, y_arcsec, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """What it reads of faces that stand at true directions x and y."""
        x, y = self.sign * (x_arcsec + self.offset_arcsec[0]), y_arcsec + self.offset_arcsec[1]
        roll = self.roll_arcmin / ARCMIN_PER_RAD
        x_noise, y_noise = rng.standard_normal((2, *np.shape(x)))
        x_read = (1 + self.scale_error) * (x * np.cos(roll) + y * np.sin(roll)) + self.x_noise_arcsec * x_noise
        return x_read, y * np.cos(roll) - x * np.sin(roll) + (self.y_noise_arcsec or 0.0) * y_noise


@dataclass(frozen=True)
class PolygonConditions:
    """How a run is carried out.

    Each round goes through all faces and ends at its first face a turn later; with `backward` each is followed by one
    in reverse. `start_deg`: encoder reading at face 1. `setting_scatter_arcsec`: how closely the shaft is stopped at
    each position. `tilt_arcsec` (psi) towards `tilt_azimuth_deg` (omega) is the tower tilt. `drift_arcsec`: by how much
    x has drifted after one round. `eccentricity_mm`, towards `eccentricity_deg`: the polygon's middle off the axis, so
    that the beam wanders over the faces. `missing`: readings left out, never the first of a series.
    """

    rounds: int = 1
    backward: bool = False
    start_deg: float = 0.0
    setting_scatter_arcsec: float = 2.0
    tilt_arcsec: float = 0.0
    tilt_azimuth_deg: float = 0.0
    drift_arcsec: float = 0.0
    eccentricity_mm: float = 0.0
    eccentricity_deg: float = 0.0
    missing: int = 0


@dataclass(frozen=True)
class PolygonReadings:
    """The rows of a run, all [rows].

    `face`: from 0; `round`: from 1; `direction`: +1 or -1; `count`: what the encoder shows, turns kept;
    `true_deg`: the shaft's true angle, on the encoder's own scale; `autocollimator_...`: what was read.
    """

    face: np.ndarray
    round: np.ndarray
    direction: np.ndarray
    count: np.ndarray
    face_deviation_arcsec: np.ndarray
    autocollimator_x_arcsec: np.ndarray
    autocollimator_y_arcsec: np.ndarray
    true_deg: np.ndarray = field(repr=False)

    @property
    def position_deg(self) -> np.ndarray:
        """The encoder's reading."""
        return counts_to_deg(self.count)

    def columns(self, *, counts: bool = False, certificate: bool = True, y: bool = True) -> dict[str, np.ndarray]:
        """The columns of the run file, in its order."""
        columns = {"count": self.count} if counts else {"position_deg": self.position_deg}
        if certificate:
            columns["face_deviation_arcsec"] = self.face_deviation_arcsec
        columns["autocollimator_x_arcsec"] = self.autocollimator_x_arcsec
        if y:
            columns["autocollimator_y_arcsec"] = self.autocollimator_y_arcsec
        return columns | {"round": self.round, "direction": self.direction}

    def where(self, rows) -> "PolygonReadings":
        """The rows that an index or a mask chooses."""
        return PolygonReadings(**{name: values[rows] for name, values in vars(self).items()})


def simulate_polygon(
    encoder: KnownEncoder,
    polygon: PolygonArtefact,
    autocollimator: Autocollimator,
    conditions: PolygonConditions,
    rng: np.random.Generator,
) -> PolygonReadings:
    """The readings of a run without any mistake of the operator."""
    step, round_number, direction = _order_of_faces(polygon.faces, conditions)
    stopped_deg = conditions.start_deg + step * (360.0 / polygon.faces)
    stopped_deg += conditions.setting_scatter_arcsec / 3600.0 * rng.standard_normal(step.size)
    true_deg = encoder.true_deg(stopped_deg, direction)
    start_deg = float(encoder.true_deg(conditions.start_deg))
    face = step % polygon.faces
    rotation_deg = true_deg - start_deg
    x, y = face_view(
        polygon.azimuth_deg[face],
        polygon.pyramid_arcsec[face],
        rotation_deg,
        tilted_axis(conditions.tilt_arcsec, conditions.tilt_azimuth_deg),
    )
    x = x + beam_walk_mm(rotation_deg, conditions) * polygon.slope_arcsec_per_mm[face]
    x = x + conditions.drift_arcsec * np.arange(step.size) / polygon.faces
    x_read, y_read = autocollimator.readings(x, y, rng)
    readings = PolygonReadings(
        face=face,
        round=round_number,
        direction=direction,
        count=encoder.count(true_deg, direction),
        face_deviation_arcsec=polygon.certificate_arcsec[face],
        autocollimator_x_arcsec=x_read,
        autocollimator_y_arcsec=y_read,
        true_deg=true_deg,
    )
    return readings.where(np.sort(_kept(readings, conditions.missing, rng)))


def beam_walk_mm(rotation_deg, conditions: PolygonConditions) -> np.ndarray:
    """How far beside a face's middle the beam stands when the polygon sits off the axis."""
    return conditions.eccentricity_mm * np.sin(np.radians(conditions.eccentricity_deg - rotation_deg))


def _order_of_faces(faces: int, conditions: PolygonConditions) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Steps of the shaft from face 1, round and direction of each row; a series closes at the face it began with."""
    one_way = np.arange(faces + 1)
    series = [(one_way, 1), (one_way[::-1], -1)] if conditions.backward else [(one_way, 1)]
    rows = [(steps, number + 1, way) for number in range(conditions.rounds) for steps, way in series]
    step = np.concatenate([steps for steps, _, _ in rows])
    return step, np.repeat([row[1] for row in rows], faces + 1), np.repeat([row[2] for row in rows], faces + 1)


def _kept(readings: PolygonReadings, missing: int, rng: np.random.Generator) -> np.ndarray:
    """The rows that are left when `missing` of them are lost; the ends of each series stay."""
    rows = np.arange(readings.face.size)
    series = 2 * readings.round + readings.direction
    ends = np.append(True, np.diff(series) != 0) | np.append(np.diff(series) != 0, True)
    return np.setdiff1d(rows, rng.choice(rows[~ends], missing, replace=False))
