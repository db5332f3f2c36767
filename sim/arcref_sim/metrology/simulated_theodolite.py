"""A simulated theodolite run: a plane mirror on the encoder, seen over an arc by an autocollimating theodolite.

Wang Tao et al., Acta Optica Sinica 38(5) 2018 0512001. The printed equations (1) and (3) to (6) hold for an axis whose
azimuth delta is counted counter-clockwise from OY, seen from above, whatever the text says; see SCIENCE, part TH.
"""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import counts_to_deg
from arcref_sim.metrology.face_view import rotated
from arcref_sim.metrology.known_encoder import KnownEncoder


@dataclass(frozen=True)
class TheodoliteConditions:
    """How a run is carried out.

    The arc goes from `first_deg` to `last_deg` of true angle from the start in steps of `step_deg`; `start_deg`:
    encoder reading there. `alpha_deg`: angle of the encoder's axis to OZ; `delta_deg`: azimuth of its projection, in
    the printed equations' sense; `omega_deg`: elevation of the mirror's normal at the start.
    `azimuth_zero_deg`: what the theodolite's circle reads at the start; `zenith_index_arcsec`: its zenith reading less
    the true one; `drift_arcsec`: by how much the azimuth drifts over the run; `missing`: readings left out, never the
    first; `rounds`: how often the arc is gone through, each from its first angle on, the circle set within
    `circle_scatter_arcsec`.
    """

    alpha_deg: float = 0.0
    delta_deg: float = 0.0
    omega_deg: float = 0.0
    first_deg: float = 0.0
    last_deg: float = 40.0
    step_deg: float = 1.0
    start_deg: float = 0.0
    setting_scatter_arcsec: float = 2.0
    azimuth_noise_arcsec: float = 0.0
    zenith_noise_arcsec: float = 0.0
    azimuth_zero_deg: float = 0.0
    zenith_index_arcsec: float = 0.0
    drift_arcsec: float = 0.0
    missing: int = 0
    rounds: int = 1
    circle_scatter_arcsec: float = 60.0

    @property
    def angles_deg(self) -> np.ndarray:
        """Nominal angles from the start, both ends included."""
        steps = int(np.floor((self.last_deg - self.first_deg) / self.step_deg + 1e-9))
        return self.first_deg + self.step_deg * np.arange(steps + 1)


@dataclass(frozen=True)
class TheodoliteReadings:
    """The rows of a run, all [rows]: `round` from 1; `count` of the encoder; what the theodolite reads."""

    round: np.ndarray
    count: np.ndarray
    azimuth_deg: np.ndarray
    zenith_deg: np.ndarray
    true_deg: np.ndarray = field(repr=False)

    @property
    def reading_deg(self) -> np.ndarray:
        """The encoder's reading."""
        return counts_to_deg(self.count)

    def columns(self) -> dict[str, np.ndarray]:
        """The columns of the run file, in its order; `round` only when there is more than one."""
        names = ("reading_deg", "azimuth_deg", "zenith_deg") + (("round",) if np.any(self.round > 1) else ())
        return {name: getattr(self, name) for name in names}


def simulate_theodolite(
    encoder: KnownEncoder, conditions: TheodoliteConditions, rng: np.random.Generator
) -> TheodoliteReadings:
    """The readings of a run, the encoder turning clockwise as it counts up."""
    c = conditions
    readings = c.angles_deg.size
    round_number = np.repeat(np.arange(c.rounds), readings)
    stopped_deg = c.start_deg + np.tile(c.angles_deg, c.rounds)
    stopped_deg = stopped_deg + c.setting_scatter_arcsec / 3600.0 * rng.standard_normal(stopped_deg.size)
    true_deg = encoder.true_deg(stopped_deg, direction=1)
    rotation_deg = true_deg - float(encoder.true_deg(c.start_deg))
    azimuth_deg, elevation_deg = mirror_direction(rotation_deg, c.alpha_deg, c.delta_deg, c.omega_deg)
    azimuth_noise, zenith_noise = rng.standard_normal((2, true_deg.size)) / 3600.0
    drift_deg = c.drift_arcsec / 3600.0 * np.linspace(0.0, 1.0, true_deg.size)
    circle_deg = c.circle_scatter_arcsec / 3600.0 * np.append(0.0, rng.standard_normal(c.rounds - 1))
    azimuth_deg = azimuth_deg + c.azimuth_zero_deg + circle_deg[round_number] + drift_deg
    azimuth_deg = azimuth_deg + c.azimuth_noise_arcsec * azimuth_noise
    zenith_deg = 90.0 + elevation_deg + c.zenith_index_arcsec / 3600.0 + c.zenith_noise_arcsec * zenith_noise
    lost = rng.choice(np.arange(1, true_deg.size), c.missing, replace=False)
    kept = np.setdiff1d(np.arange(true_deg.size), lost)
    rows = (round_number + 1, encoder.count(true_deg, direction=1), azimuth_deg, zenith_deg, true_deg)
    return TheodoliteReadings(*(values[kept] for values in rows))


def mirror_direction(rotation_deg, alpha_deg: float, delta_deg: float, omega_deg: float):
    """Azimuth (clockwise, turns kept) and elevation in degrees of the mirror's normal after a clockwise turn.

    By Rodrigues' formula about the axis, then by the tilt omega of the frame at the start.
    """
    alpha, delta, omega = np.radians([alpha_deg, delta_deg, omega_deg])
    axis = np.array([-np.sin(alpha) * np.sin(delta), np.sin(alpha) * np.cos(delta), np.cos(alpha)])
    rotation_deg = np.asarray(rotation_deg, float)
    normal = rotated(np.array([0.0, 1.0, 0.0]), axis, -np.radians(rotation_deg))
    x, y, z = np.moveaxis(normal, -1, 0)
    y, z = y * np.cos(omega) - z * np.sin(omega), y * np.sin(omega) + z * np.cos(omega)
    azimuth_deg = np.degrees(np.arctan2(x, y))
    # The nearest turn: an axis close to plumb keeps the azimuth near the angle turned.
    azimuth_deg = azimuth_deg + 360.0 * np.round((rotation_deg - azimuth_deg) / 360.0)
    return azimuth_deg, np.degrees(np.arcsin(z))
