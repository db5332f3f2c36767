"""Monte Carlo of a whole polygon calibration: every input of the budget drawn, reduced, fitted, rounded into the ROM.

After JCGM 101:2008 (GUM Supplement 1). The run's own readings are perturbed, `reduce_polygon` takes all repetitions at
once, and the correction that results is compared with the curve that the unperturbed run gave, which here is the truth.
How the inputs propagate is taken from nowhere, so that it checks the budget's sensitivities.
"""

from dataclasses import dataclass, replace

import numpy as np
from rich.console import Console
from rich.progress import Progress

from arcref.angle import ARCSEC_PER_COUNT, LINES_PER_TURN, arcsec_to_counts
from arcref.calibration.correction_budget import interpolation_u_arcsec
from arcref.calibration.fit_transfer import FitTransfer, line_middles_deg
from arcref.calibration.fits.curve_modes import curve_modes
from arcref.calibration.polygon_drift import drift_shape_arcsec, return_half_arcsec
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.polygon_reduction import PolygonReduction, reduce_polygon
from arcref.calibration.tower_tilt import horizontal_reading_arcsec, vertical_reading_arcsec

FEWEST_RUNS = 100

AGREEMENT = 0.05
"""How far the standard uncertainty may lie from the budget's, as a part of it, beyond twice its own scatter."""

_BLOCK = 100
"""Runs that are worked on at a time."""


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """What the runs gave.

    `u_arcsec`: rms of the error of a corrected angle about its mean, over all runs and angles; `interval_95_arcsec`:
    95 % of these errors are no larger; `budget_arcsec`: the combined standard uncertainty that it is to be compared
    with; `seed` of the random numbers; `scatter`: standard deviation of `u_arcsec` from seed to seed, as a part of it,
    found from the scatter of the runs.
    """

    runs: int
    seed: int
    u_arcsec: float
    interval_95_arcsec: float
    budget_arcsec: float
    scatter: float

    @property
    def from_budget(self) -> float:
        """By what part of the budget's it differs: 0.02 is 2 % more."""
        return self.u_arcsec / self.budget_arcsec - 1.0

    @property
    def agrees(self) -> bool:
        """True when the two differ by no more than `AGREEMENT` and twice what so few runs scatter."""
        return abs(self.from_budget) <= AGREEMENT + 2 * self.scatter

    def figures(self) -> dict:
        """The numbers for `results`, ready for JSON."""
        return {
            "runs": self.runs,
            "seed": self.seed,
            "u_arcsec": self.u_arcsec,
            "interval_95_arcsec": self.interval_95_arcsec,
            "budget_arcsec": self.budget_arcsec,
            "from_budget": self.from_budget,
            "scatter": self.scatter,
        }


def monte_carlo(
    reduction: PolygonReduction, fitted, budget_arcsec: float, runs: int, seed: int = 1, progress: bool = False
) -> MonteCarlo:
    """Repeat the calibration `runs` times. `progress` shows a bar, if there is a terminal.

    Raises `ValueError` for fewer than `FEWEST_RUNS`, and `InputError` for stated numbers that cannot be.
    """
    if runs < FEWEST_RUNS:
        raise ValueError(f"{runs} runs, at least {FEWEST_RUNS} were expected")
    calibration = _Repetition(reduction, fitted)
    random = np.random.default_rng(seed)
    square_of_run = np.empty(runs)
    # The share of each size of error, to a thousandth of the budget's uncertainty, gives the interval without keeping
    # every error.
    width = budget_arcsec / 1000.0
    sizes = np.zeros(20_000, np.int64)
    console = Console(stderr=True)
    with Progress(console=console, disable=not (progress and console.is_terminal), transient=True) as bar:
        task = bar.add_task("Monte Carlo", total=runs)
        for start in range(0, runs, _BLOCK):
            count = min(_BLOCK, runs - start)
            error = calibration.errors_arcsec(random, count)
            square_of_run[start : start + count] = (error**2).mean(axis=1)
            size = np.minimum(np.abs(error) / width, sizes.size - 1).astype(np.int64)
            sizes += np.bincount(size.ravel(), minlength=sizes.size)
            bar.advance(task, count)
    total = np.cumsum(sizes)
    interval = (int(np.searchsorted(total, 0.95 * total[-1])) + 0.5) * width
    u = float(np.sqrt(square_of_run.mean()))
    scatter = float(square_of_run.std(ddof=1) / np.sqrt(runs) / (2 * u**2))
    return MonteCarlo(runs, seed, u, interval, budget_arcsec, scatter)


class _Repetition:
    """The calibration that is repeated: its readings, its fit, and the truth."""

    def __init__(self, reduction: PolygonReduction, fitted):
        self.reduction, self.run, self.fitted = reduction, reduction.run, fitted
        self.inputs = PolygonInputs.of(reduction)
        self.angle_deg = line_middles_deg(fitted)
        self.weights = fitted.weights(self.angle_deg)
        self.truth = self.weights @ fitted.curve.error_arcsec
        self.slope = np.gradient(self.truth, self.angle_deg)
        modes = curve_modes(fitted.curve)
        self.mode_sigma = np.sqrt(modes.variance_arcsec2)
        self.modes_at_faces, self.modes_at_angles = modes.at(fitted.curve.angle_deg), modes.at(self.angle_deg)
        transfer = FitTransfer.over_turn(fitted)
        self.drift = drift_shape_arcsec(self.inputs, transfer)
        self.half_return = return_half_arcsec(self.inputs)

    def errors_arcsec(self, random: np.random.Generator, count: int) -> np.ndarray:
        """Corrected minus true angle about its mean over the angles, float64[count, angles]."""
        inputs, run, face = self.inputs, self.run, self.run.face
        readings = len(face)

        def per_reading(u):
            return 0.0 if u is None else random.normal(0.0, u, (count, readings))

        def per_face(u):
            return 0.0 if u is None else random.normal(0.0, u, (count, inputs.faces))

        # The certificate as drawn is what the reduction believes; the faces themselves stay as they are.
        certificate = np.zeros(readings) if run.face_deviation_arcsec is None else run.face_deviation_arcsec
        certificate = np.broadcast_to(certificate, (count, readings))
        certificate = certificate + _at(per_face(inputs.u_face_certificate_arcsec), face)
        error = per_face(inputs.u_autocollimator_arcsec) + self._stated_at_faces(random, count)
        true_modes = random.normal(size=(count, self.mode_sigma.size)) * self.mode_sigma
        error = error + true_modes @ self.modes_at_faces.T
        error = error + random.normal(size=(count, 1)) * self.drift + self._unseen_tilt(random, count)
        x_error = _at(error, face) + per_reading(inputs.repeatability_arcsec)
        within_line, phase = self._within_line(random, count)
        x_error = x_error + within_line * np.sin(np.radians(run.position_deg * LINES_PER_TURN) + phase)
        changes = {
            "x_arcsec": run.x_arcsec + run.sign * x_error,
            "face_deviation_arcsec": certificate,
        }
        if run.y_arcsec is not None:
            sigma = inputs.tilt.sigma_arcsec
            changes["y_arcsec"] = run.y_arcsec + _at(per_face(sigma if np.isfinite(sigma) else None), face)
            changes["roll_arcmin"] = (run.roll_arcmin or 0.0) + self._roll_arcmin(random, count)
        reduced = reduce_polygon(replace(run, **changes), self.reduction.tilt_corrected)
        rom = np.floor(arcsec_to_counts(reduced.error_arcsec @ self.weights.T) + 0.5) * ARCSEC_PER_COUNT
        return self._about_mean(self._readings(random, true_modes, within_line, phase) - rom)

    def _readings(self, random, true_modes, within_line, phase) -> np.ndarray:
        """The error of a reading somewhere in the cell of each angle, with all that the ROM cannot hold."""
        count, angles = true_modes.shape[0], self.angle_deg.size
        place = random.uniform(-0.5, 0.5, (count, angles))  # in the cell, as parts of a grating line
        error = self.truth + true_modes @ self.modes_at_angles.T + self.slope * place * (360.0 / LINES_PER_TURN)
        # The cell's middle is half a line from its start, so the phase there is half a turn.
        error += within_line * np.sin(2 * np.pi * (place + 0.5) + phase)
        error += random.uniform(-0.5, 0.5, (count, angles)) * ARCSEC_PER_COUNT
        return error

    def _about_mean(self, error: np.ndarray) -> np.ndarray:
        """About the mean over the turn; the reading is in use forward as often as backward."""
        error -= error.mean(axis=1, keepdims=True)
        error[0::2] += self.weights @ self.half_return
        error[1::2] -= self.weights @ self.half_return
        return error

    def _stated_at_faces(self, random, count: int):
        """Eccentric mounting and temperature: at each face the same in every round."""
        inputs, faces = self.inputs, self.inputs.faces
        total = np.zeros((count, faces))
        if inputs.u_eccentric_mounting_arcsec is not None:
            total += random.normal(0.0, inputs.u_eccentric_mounting_arcsec, (count, faces))
        elif inputs.u_face_flatness_arcsec_per_mm is not None and inputs.eccentricity_mm is not None:
            direction = random.uniform(0.0, 2 * np.pi, (count, 1))
            wander_mm = inputs.eccentricity_mm * np.sin(np.radians(inputs.theta_deg) + direction)
            total += wander_mm * random.normal(0.0, inputs.u_face_flatness_arcsec_per_mm, (count, faces))
        if inputs.u_temperature_arcsec is not None:
            total += random.normal(0.0, inputs.u_temperature_arcsec, (count, faces))
        elif inputs.u_temperature_coefficient_arcsec_per_k is not None and inputs.temperature_change_k is not None:
            change_k = inputs.temperature_change_k * random.uniform(-0.5, 0.5, (count, faces))
            total += change_k * random.normal(0.0, inputs.u_temperature_coefficient_arcsec_per_k, (count, faces))
        return total

    def _unseen_tilt(self, random, count: int):
        """Tilt and roll of a run without y readings, as far as they are stated; tilt and roll left in x."""
        inputs = self.inputs
        if inputs.tilt is not None:
            if inputs.tilt_corrected:
                return 0.0
            left = inputs.tilt.horizontal_arcsec(inputs.theta_deg)
            u = inputs.u_autocollimator_roll_arcmin or 0.0
            roll = np.radians(random.normal(0.0, u, (count, 1)) / 60.0)
            signs = random.choice([-1.0, 1.0], (count, 2))
            both = signs[:, :1] * left + signs[:, 1:] * inputs.x_roll_arcsec
            return both + roll * inputs.tilt.vertical_arcsec(inputs.theta_deg)
        if inputs.tilt_limit_arcsec is None:
            return 0.0
        psi = random.uniform(0.0, inputs.tilt_limit_arcsec, (count, 1))
        omega_deg = random.uniform(-180.0, 180.0, (count, 1))
        roll = np.radians(random.normal(0.0, inputs.u_autocollimator_roll_arcmin or 0.0, (count, 1)) / 60.0)
        level = horizontal_reading_arcsec(inputs.theta_deg, psi, omega_deg)
        return level + roll * vertical_reading_arcsec(inputs.theta_deg, psi, omega_deg)

    def _within_line(self, random, count: int):
        """Amplitude of the error within a grating line in arcsec, and its phase in each run."""
        u = interpolation_u_arcsec(self.run.run)
        return (u or 0.0) * np.sqrt(2.0), random.uniform(0.0, 2 * np.pi, (count, 1))

    def _roll_arcmin(self, random, count: int) -> np.ndarray:
        return random.normal(0.0, self.inputs.u_autocollimator_roll_arcmin or 0.0, count)


def _at(of_face, face):
    """Values of the faces as values of the readings; a plain number stays as it is."""
    return of_face if np.ndim(of_face) == 0 else of_face[..., face]
