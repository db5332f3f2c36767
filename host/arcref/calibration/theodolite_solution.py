"""Limited-angle calibration: true angles from a theodolite's azimuths, and the encoder's error with its covariance.

The elevations tell where axis and mirror stand, the azimuths then tell the shaft's true angle. The paper puts the
encoder's reading, with its own error, for the angle while it identifies the axis; here the true angles found are put
back until nothing changes, so the encoder has no say in them. Only the datum of the azimuth circle is unknown: in each
round the mean error is zero.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from arcref.calibration.theodolite_identification import angles_by_parameters, closed_form, least_squares
from arcref.calibration.theodolite_model import MirrorGeometry

ARCSEC_PER_RAD = 3600.0 * 180.0 / np.pi

_MOST_PASSES = 30
_SETTLED_RAD = 1e-12


@dataclass(frozen=True, eq=False)
class ArcReadings:
    """Readings over an arc; leading axes (runs of a simulation) broadcast.

    `reading_rad`: float64[..., n], encoder reading from the datum, growing clockwise seen from above; `azimuth_rad`,
    `elevation_rad`: float64[..., n], of the mirror's normal, azimuths near `reading_rad` but for a constant in each
    round; `place`: int[n], which place of the arc each reading belongs to; `round`: int[n], both from 0.
    """

    reading_rad: np.ndarray
    azimuth_rad: np.ndarray
    elevation_rad: np.ndarray
    place: np.ndarray
    round: np.ndarray

    @property
    def places(self) -> int:
        """Number of places of the arc."""
        return int(self.place.max()) + 1

    @property
    def rounds(self) -> int:
        """Number of rounds."""
        return int(self.round.max()) + 1

    @cached_property
    def averaging(self) -> np.ndarray:
        """float64[places, n]: errors of the places, mean zero, from errors of the readings known but for a constant
        in each round: least squares.
        """
        n, p, r = len(self.place), self.places, self.rounds
        columns = np.zeros((n + 1, p + r))
        columns[np.arange(n), self.place] = 1.0
        columns[np.arange(n), p + self.round] = 1.0
        columns[n, :p] = 1.0
        return np.linalg.pinv(columns)[:p, :n]


@dataclass(frozen=True, eq=False)
class ArcSolution:
    """What the readings of an arc say.

    `geometry`: axis and mirror; `start`: the closed form at the encoder's readings; `datum_rad`: float64[..., rounds],
    azimuth at theta = 0; `theta_rad`: float64[..., n], true angles from the datum; `reading_error_rad`:
    float64[..., n], reading - true angle; `error_arcsec`: float64[..., places], mean zero; `elevation_residual_rad`:
    float64[..., n].
    """

    readings: ArcReadings
    geometry: MirrorGeometry
    start: MirrorGeometry
    datum_rad: np.ndarray
    theta_rad: np.ndarray
    reading_error_rad: np.ndarray
    error_arcsec: np.ndarray
    elevation_residual_rad: np.ndarray

    @property
    def elevation_sigma_arcsec(self) -> np.ndarray:
        """float64[...]: standard deviation of one elevation, from the residuals; 3 parameters were fitted."""
        freedom = self.readings.elevation_rad.shape[-1] - 3
        square = np.sum(self.elevation_residual_rad**2, axis=-1)
        return ARCSEC_PER_RAD * np.sqrt(square / freedom) if freedom > 0 else np.full(square.shape, np.nan)

    @cached_property
    def azimuth_freedom(self) -> int:
        """Degrees of freedom of the azimuths' scatter: readings beyond one for each place and one for each round."""
        readings = self.readings
        met = np.zeros((readings.places + readings.rounds, len(readings.place)))
        met[readings.place, np.arange(len(readings.place))] = 1.0
        met[readings.places + readings.round, np.arange(len(readings.place))] = 1.0
        return len(readings.place) - int(np.linalg.matrix_rank(met))

    @property
    def azimuth_sigma_arcsec(self) -> np.ndarray:
        """float64[...]: standard deviation of one azimuth from the scatter between rounds, NaN with one round.

        What the encoder itself does not repeat is in it.
        """
        freedom = self.azimuth_freedom
        if freedom < 1:
            return np.full(self.reading_error_rad.shape[:-1], np.nan)
        residual = self._round_residual_rad()
        return ARCSEC_PER_RAD * np.sqrt(np.sum(residual**2, axis=-1) / freedom)

    def sensitivity(self) -> "ArcSensitivity":
        """How parameters and errors change with each azimuth and elevation, to first order."""
        readings, theta = self.readings, self.theta_rad
        slopes = self.geometry.derivatives(theta)
        theta_by_azimuth = 1.0 / slopes.azimuth_by_theta
        theta_by_parameters = slopes.theta_by_parameters
        fitted = slopes.elevation_by_parameters
        own_round = np.eye(readings.rounds)[readings.round]  # [n, rounds]
        along_theta = slopes.elevation_by_theta * theta_by_azimuth
        # Conditions: residuals of the elevations orthogonal to `fitted`; mean error of each round zero.
        total = fitted + slopes.elevation_by_theta[..., np.newaxis] * theta_by_parameters
        by_parameters = _above(_times(fitted, total), _times(own_round, theta_by_parameters))
        by_datum = _above(
            -_times(fitted, along_theta[..., np.newaxis] * own_round),
            -_times(own_round, theta_by_azimuth[..., np.newaxis] * own_round),
        )
        unknown = np.concatenate([by_parameters, by_datum], axis=-1)
        rows = np.swapaxes(fitted, -1, -2)
        no_effect = np.zeros(rows.shape[:-2] + (readings.rounds, rows.shape[-1]))
        from_elevation = np.linalg.solve(unknown, np.concatenate([rows, no_effect], axis=-2))
        from_azimuth = np.linalg.solve(
            unknown,
            -_above(rows * along_theta[..., np.newaxis, :], own_round.T * theta_by_azimuth[..., np.newaxis, :]),
        )

        def error_by(change, of_azimuth):
            """Errors of the places, from changes of the unknowns [..., 3 + rounds, n]."""
            theta_change = theta_by_parameters @ change[..., :3, :]
            theta_change = theta_change - theta_by_azimuth[..., np.newaxis] * (own_round @ change[..., 3:, :])
            if of_azimuth:
                theta_change = theta_change + np.eye(theta.shape[-1]) * theta_by_azimuth[..., np.newaxis]
            return -readings.averaging @ theta_change

        return ArcSensitivity(
            from_elevation[..., :3, :],
            from_azimuth[..., :3, :],
            error_by(from_elevation, False),
            error_by(from_azimuth, True),
            angles_by_parameters(self.geometry),
        )

    def _round_residual_rad(self) -> np.ndarray:
        """float64[..., n]: errors of the readings less those of place and round."""
        readings = self.readings
        place = self.reading_error_rad @ readings.averaging.T
        left = self.reading_error_rad - place[..., readings.place]
        for number in range(readings.rounds):
            own = readings.round == number
            left[..., own] -= left[..., own].mean(axis=-1, keepdims=True)
        return left


@dataclass(frozen=True, eq=False)
class ArcSensitivity:
    """Changes of the result with each reading, both in rad: `parameters_by_...` float64[..., 3, n] (across, along,
    omega), `error_by_...` float64[..., places, n]; `angles_by_parameters`: float64[..., 3, 3].
    """

    parameters_by_elevation: np.ndarray
    parameters_by_azimuth: np.ndarray
    error_by_elevation: np.ndarray
    error_by_azimuth: np.ndarray
    angles_by_parameters: np.ndarray

    def parameter_covariance(self, u_elevation: float, u_azimuth: float) -> np.ndarray:
        """float64[..., 3, 3]: of across, along and omega, in the square of the unit of the uncertainties."""
        return _covariance(self.parameters_by_elevation, u_elevation) + _covariance(
            self.parameters_by_azimuth, u_azimuth
        )

    def angle_covariance(self, u_elevation: float, u_azimuth: float) -> np.ndarray:
        """float64[..., 3, 3]: of alpha, delta and omega."""
        turn = self.angles_by_parameters
        return turn @ self.parameter_covariance(u_elevation, u_azimuth) @ np.swapaxes(turn, -1, -2)

    def error_covariance(self, u_elevation: float, u_azimuth: float) -> np.ndarray:
        """float64[..., places, places]: of the errors, parameters and azimuths together."""
        return _covariance(self.error_by_elevation, u_elevation) + _covariance(self.error_by_azimuth, u_azimuth)


def solve_arc(readings: ArcReadings) -> ArcSolution:
    """Identify axis and mirror, and find the errors. NaN where the elevations fit no axis."""
    theta = readings.reading_rad
    start = closed_form(theta, readings.elevation_rad)
    own_round = np.eye(readings.rounds)[readings.round]
    share = own_round / own_round.sum(axis=0)
    geometry = start
    datum = (readings.azimuth_rad - start.azimuth_rad(theta)) @ share
    for _ in range(_MOST_PASSES):
        geometry = least_squares(theta, readings.elevation_rad, geometry)
        found = geometry.theta_rad(readings.azimuth_rad - datum[..., readings.round])
        shift = (found - readings.reading_rad) @ share
        datum = datum + shift
        change = np.abs(found - theta)
        theta = found
        if not (change > _SETTLED_RAD).any() and not (np.abs(shift) > _SETTLED_RAD).any():
            break
    error = readings.reading_rad - theta
    return ArcSolution(
        readings,
        geometry,
        start,
        datum,
        theta,
        error,
        ARCSEC_PER_RAD * (error @ readings.averaging.T),
        readings.elevation_rad - geometry.elevation_rad(theta),
    )


def _times(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    return np.swapaxes(left, -1, -2) @ right


def _above(upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
    """Both blocks one above the other, leading axes broadcast."""
    lead = np.broadcast_shapes(upper.shape[:-2], lower.shape[:-2])
    blocks = [np.broadcast_to(block, lead + block.shape[-2:]) for block in (upper, lower)]
    return np.concatenate(blocks, axis=-2)


def _covariance(sensitivity: np.ndarray, u: float) -> np.ndarray:
    return u**2 * sensitivity @ np.swapaxes(sensitivity, -1, -2)
