"""A simulated closure run: the polygon set at several positions on the encoder, both of known error.

At setting k face f meets the autocollimator near the encoder position (f - 1) 360/n + (k - 1) step. How the polygon was
mounted anew at each setting is known only to the mounting, so each setting has an angle of its own.
"""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import counts_to_deg
from arcref_sim.metrology.face_view import face_view, tilted_axis
from arcref_sim.metrology.known_encoder import KnownEncoder
from arcref_sim.metrology.polygon_artefact import PolygonArtefact
from arcref_sim.metrology.simulated_polygon import Autocollimator


@dataclass(frozen=True)
class ClosureConditions:
    """How a run is carried out.

    `settings`: numbers of the settings, from 1, setting k turned by (k - 1) `setting_step_deg` on the encoder;
    `mounting_scatter_arcsec`: how closely each is mounted at its angle; `tilt_arcsec`: tower tilt of each mounting,
    its azimuth at random; `setting_scatter_arcsec`, `start_deg` and `missing` as in a polygon run;
    `drift_arcsec`: by how much x drifts while one setting is read; `rounds`: how often all settings are gone through,
    the polygon mounted anew each time.
    """

    settings: tuple[int, ...]
    setting_step_deg: float
    start_deg: float = 0.0
    setting_scatter_arcsec: float = 2.0
    mounting_scatter_arcsec: float = 30.0
    tilt_arcsec: float = 0.0
    drift_arcsec: float = 0.0
    missing: int = 0
    rounds: int = 1


@dataclass(frozen=True)
class ClosureReadings:
    """The rows of a run, all [rows]: `round`, `setting`, `face` from 1; `count`: what the encoder shows, turns kept."""

    round: np.ndarray
    setting: np.ndarray
    face: np.ndarray
    count: np.ndarray
    autocollimator_x_arcsec: np.ndarray
    true_deg: np.ndarray = field(repr=False)

    @property
    def position_deg(self) -> np.ndarray:
        """The encoder's reading."""
        return counts_to_deg(self.count)

    def columns(self) -> dict[str, np.ndarray]:
        """The columns of the run file, in its order; `round` only when there is more than one."""
        names = ("setting", "face", "position_deg", "autocollimator_x_arcsec")
        names += ("round",) if np.any(self.round > 1) else ()
        return {name: getattr(self, name) for name in names}


def simulate_closure(
    encoder: KnownEncoder,
    polygon: PolygonArtefact,
    autocollimator: Autocollimator,
    conditions: ClosureConditions,
    rng: np.random.Generator,
) -> ClosureReadings:
    """The readings of a run; x is the only direction that is written down."""
    numbers = np.tile(conditions.settings, conditions.rounds)
    mounting_deg = conditions.mounting_scatter_arcsec / 3600.0 * rng.standard_normal(numbers.size)
    tilt_azimuth_deg = rng.uniform(0.0, 360.0, numbers.size)
    index, face = (part.ravel() for part in np.indices((numbers.size, polygon.faces)))
    turned_deg = (numbers - 1) * conditions.setting_step_deg
    stopped_deg = conditions.start_deg + turned_deg[index] + face * (360.0 / polygon.faces)
    stopped_deg += conditions.setting_scatter_arcsec / 3600.0 * rng.standard_normal(index.size)
    true_deg = encoder.true_deg(stopped_deg, direction=1)
    rotation_deg = true_deg - (conditions.start_deg + turned_deg + mounting_deg)[index]
    axis = np.array([tilted_axis(conditions.tilt_arcsec, azimuth) for azimuth in tilt_azimuth_deg])
    x, y = face_view(polygon.azimuth_deg[face], polygon.pyramid_arcsec[face], rotation_deg, axis[index])
    x = x + conditions.drift_arcsec * face / polygon.faces
    x_read, _ = autocollimator.readings(x, y, rng)
    lost = rng.choice(index.size, conditions.missing, replace=False)
    kept = np.setdiff1d(np.arange(index.size), lost)
    rows = {
        "round": index // len(conditions.settings) + 1,
        "setting": numbers[index],
        "face": face + 1,
        "count": encoder.count(true_deg, direction=1),
        "autocollimator_x_arcsec": x_read,
        "true_deg": true_deg,
    }
    return ClosureReadings(**{name: values[kept] for name, values in rows.items()})
