"""The uncertainty budget of a limited-angle calibration, after the GUM.

The measurand is a corrected angle anywhere on the arc, about the mean of its error. Azimuths and elevations come with
the whole covariance of the solution: the parameters of axis and mirror are poorly separated, the angle is not. What
shifts every reading alike is put through the whole reduction once.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from arcref.calibration.correction_budget import correction_contributions, line_phasor_of
from arcref.calibration.fit_transfer import FitTransfer
from arcref.calibration.stated_contributions import temperature
from arcref.calibration.stated_values import stated_number
from arcref.calibration.theodolite_run import TheodoliteRun
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcReadings, ArcSensitivity, ArcSolution, solve_arc
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget


@dataclass(frozen=True)
class ReadingNoise:
    """Standard uncertainty of one reading: `arcsec`, None when nothing tells; its type, degrees of freedom, basis."""

    arcsec: float | None
    type: str
    degrees_of_freedom: float
    basis: str


def zenith_noise(run: TheodoliteRun, solution: ArcSolution) -> ReadingNoise:
    """Of a zenith reading: as stated, or the scatter about the fitted axis where that is larger."""
    freedom = len(run.place) - 3
    found = float(solution.elevation_sigma_arcsec)
    return _larger(run.u_zenith_arcsec, found, freedom, f"scatter about the axis, {freedom} degrees of freedom")


def azimuth_noise(run: TheodoliteRun, solution: ArcSolution) -> ReadingNoise:
    """Of an azimuth reading: as stated, or the scatter between rounds where that is larger."""
    freedom = solution.azimuth_freedom
    found = float(solution.azimuth_sigma_arcsec)
    return _larger(run.u_azimuth_arcsec, found, freedom, f"scatter between rounds, {freedom} degrees of freedom")


def arc_budget(run: TheodoliteRun, solution: ArcSolution, sensitivity: ArcSensitivity, fitted) -> UncertaintyBudget:
    """The budget of a corrected angle. `fitted`: the curve through the errors, with its weights."""
    measured = arc_contributions(run, solution, sensitivity, FitTransfer.over_turn(fitted))
    phasor = line_phasor_of(run.reading_deg)
    mean = np.array([phasor[run.place == number].mean() for number in range(solution.readings.places)])
    corrected, also_missing = correction_contributions(run.run, fitted, mean)
    terms = tuple(term for term in measured if isinstance(term, Contribution))
    missing = tuple(term for term in measured if isinstance(term, MissingInput))
    return UncertaintyBudget(terms + corrected, missing + also_missing)


def place_covariance_arcsec2(
    run: TheodoliteRun, solution: ArcSolution, sensitivity: ArcSensitivity
) -> np.ndarray | None:
    """float64[places, places]: of the errors, about their mean, from all that was stated or found of the measurement.

    None when nothing tells how well an azimuth repeats.
    """
    azimuth, zenith = azimuth_noise(run, solution), zenith_noise(run, solution)
    if azimuth.arcsec is None:
        return None
    covariance = sensitivity.error_covariance(zenith.arcsec, azimuth.arcsec)
    for key, shapes in _COMMON:
        u = stated_number(run.run, key)
        for change in shapes if u else ():
            shape = u * _response(solution, change)
            covariance = covariance + np.outer(shape, shape)
    places = solution.readings.places
    about_mean = np.eye(places) - 1.0 / places
    own = [stated_number(run.run, "u_mirror_walk_arcsec") or 0.0]
    own += [term.u_arcsec for term in temperature(run.run, 1.0) if isinstance(term, Contribution)]
    return covariance + math.hypot(*own) ** 2 * about_mean


def arc_contributions(
    run: TheodoliteRun, solution: ArcSolution, sensitivity: ArcSensitivity, transfer: FitTransfer
) -> list[Contribution | MissingInput]:
    """Contributions of the measurement, and what is missing for them; `transfer` from the places to the result."""
    terms: list[Contribution | MissingInput] = []
    azimuth, zenith = azimuth_noise(run, solution), zenith_noise(run, solution)
    if azimuth.arcsec is None:
        terms.append(MissingInput("azimuth readings, which one round does not show", "u_azimuth_arcsec"))
    else:
        own = transfer.of_covariance(sensitivity.error_covariance(0.0, 1.0))
        name = "repeatability" if azimuth.type == "A" else "azimuth readings"
        terms.append(_noise_term(name, azimuth, own, "of one azimuth, through the solution"))
    own = transfer.of_covariance(sensitivity.error_covariance(1.0, 0.0))
    terms.append(_noise_term("zenith readings", zenith, own, "of one reading, through axis and mirror identified"))
    for key, name, basis in (
        ("u_zenith_index_arcsec", "index of the zenith circle", "stated; all elevations alike"),
        ("u_levelling_arcsec", "levelling of the theodolite", "stated, of each direction; the standing axis leans"),
        ("u_collimation_arcsec", "collimation of the theodolite", "stated; grows with the elevation"),
    ):
        u = stated_number(run.run, key)
        if u is None:
            terms.append(MissingInput(name, key))
            continue
        own = math.hypot(*(transfer.of_shape(_response(solution, change)) for change in dict(_COMMON)[key]))
        terms.append(Contribution(name, "B", "normal", u, "arcsec", own, basis))
    walk = stated_number(run.run, "u_mirror_walk_arcsec")
    if walk is None:
        terms.append(MissingInput("the beam's walk over the mirror", "u_mirror_walk_arcsec"))
    else:
        basis = "stated; the theodolite stands still and the mirror turns under its beam"
        own = transfer.of_independent
        terms.append(Contribution("the beam's walk over the mirror", "B", "normal", walk, "arcsec", own, basis))
    terms += temperature(run.run, transfer.of_independent)
    return terms


def _index(readings: ArcReadings, change_rad: float) -> ArcReadings:
    return replace(readings, elevation_rad=readings.elevation_rad + change_rad)


def _collimation(readings: ArcReadings, change_rad: float) -> ArcReadings:
    return replace(readings, azimuth_rad=readings.azimuth_rad + change_rad / np.cos(readings.elevation_rad))


def _levelling(towards_rad: float) -> Callable[[ArcReadings, float], ArcReadings]:
    def lean(readings: ArcReadings, change_rad: float) -> ArcReadings:
        """The standing axis leans by a small angle towards an azimuth: first order, as small as it is."""
        off = readings.azimuth_rad - towards_rad
        azimuth = readings.azimuth_rad + change_rad * np.sin(off) * np.tan(readings.elevation_rad)
        return replace(readings, azimuth_rad=azimuth, elevation_rad=readings.elevation_rad - change_rad * np.cos(off))

    return lean


_COMMON = (
    ("u_zenith_index_arcsec", (_index,)),
    ("u_levelling_arcsec", (_levelling(0.0), _levelling(math.pi / 2))),
    ("u_collimation_arcsec", (_collimation,)),
)

# Large enough against rounding, small enough for the first order.
_STEP_ARCSEC = 10.0


def _response(solution: ArcSolution, change: Callable[[ArcReadings, float], ArcReadings]) -> np.ndarray:
    """float64[places]: change of the errors for a change of 1 arcsec that all readings share."""
    ends = [solve_arc(change(solution.readings, sign * _STEP_ARCSEC / ARCSEC_PER_RAD)).error_arcsec for sign in (1, -1)]
    return (ends[0] - ends[1]) / (2 * _STEP_ARCSEC)


def _noise_term(name: str, noise: ReadingNoise, sensitivity: float, what: str) -> Contribution:
    return Contribution(
        name,
        noise.type,
        "normal",
        noise.arcsec,
        "arcsec",
        sensitivity,
        f"{noise.basis}; {what}",
        noise.degrees_of_freedom,
    )


def _larger(stated: float | None, found: float, freedom: int, basis: str) -> ReadingNoise:
    known = freedom > 0 and math.isfinite(found)
    if stated is not None and not (known and found > stated):
        return ReadingNoise(stated, "B", math.inf, "stated")
    return ReadingNoise(found, "A", float(freedom), basis) if known else ReadingNoise(None, "B", math.inf, "")
