"""The uncertainty budget of a closure run, after the GUM.

The measurand is a corrected angle anywhere on the turn, about the mean of its error: where the encoder's zero lies is a
matter of choice. The scatter of the readings comes with the whole covariance of the solution.
"""

import numpy as np

from arcref.calibration.closure_run import ClosureRun
from arcref.calibration.closure_solution import ClosureSolution
from arcref.calibration.correction_budget import correction_contributions, line_phasor_of
from arcref.calibration.fit_transfer import FitTransfer
from arcref.calibration.polygon_budget import TILT_LIMIT_FACTOR
from arcref.calibration.stated_contributions import autocollimator, eccentric_mounting, temperature
from arcref.calibration.stated_values import stated_number
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget


def closure_budget(run: ClosureRun, solution: ClosureSolution, fitted) -> UncertaintyBudget:
    """The budget of a corrected angle. `fitted`: the curve through the encoder's errors, with its weights."""
    measured = position_contributions(run, solution, FitTransfer.over_turn(fitted))
    position = run.design.position
    phasor = line_phasor_of(run.position_deg)
    mean = np.array([phasor[position == number].mean() for number in range(len(run.design.position_deg))])
    corrected, also_missing = correction_contributions(run.run, fitted, mean)
    terms, missing = _parted(measured)
    return UncertaintyBudget(terms + corrected, missing + also_missing)


def position_u_arcsec(run: ClosureRun, solution: ClosureSolution) -> np.ndarray | None:
    """Standard uncertainty of the encoder's error at each position, about their mean, float64[p].

    None when nothing tells how well a reading repeats.
    """
    sigma, _, _ = repeatability(run, solution)
    if sigma is None:
        return None
    p = len(run.design.position_deg)
    variance = sigma**2 * np.diag(run.design.covariance)[:p] + np.diag(lost_covariance_arcsec2(run))
    scattered = ("repeatability", "faces in the lost orders")
    terms, _ = _parted(position_contributions(run, solution, FitTransfer.to_faces(p)))
    other = sum(term.u_arcsec**2 for term in terms if term.name not in scattered)
    return np.sqrt(variance + other)


def face_u_arcsec(run: ClosureRun, solution: ClosureSolution) -> np.ndarray | None:
    """Standard uncertainty of each face deviation from the scatter, about their mean, float64[f]."""
    sigma, _, _ = repeatability(run, solution)
    p = len(run.design.position_deg)
    return None if sigma is None else sigma * np.sqrt(np.diag(run.design.covariance)[p:])


def repeatability(run: ClosureRun, solution: ClosureSolution) -> tuple[float | None, float, str]:
    """Standard deviation of one reading, its degrees of freedom and type: from the residuals, else as stated."""
    if run.design.degrees_of_freedom > 0:
        return float(solution.sigma_arcsec), float(run.design.degrees_of_freedom), "A"
    return stated_number(run.run, "u_repeatability_arcsec"), np.inf, "B"


def lost_covariance_arcsec2(run: ClosureRun) -> np.ndarray:
    """float64[p, p]: of what the encoder's curve leaves out, as far as the stated face deviations bound it."""
    u = stated_number(run.run, "u_face_deviation_arcsec")
    lost = run.design.lost_from_faces
    return (0.0 if u is None else u**2) * lost @ lost.T


def position_contributions(
    run: ClosureRun, solution: ClosureSolution, transfer: FitTransfer
) -> list[Contribution | MissingInput]:
    """Contributions of the measurement, and what is missing for them; `transfer` from positions to the result."""
    terms: list[Contribution | MissingInput] = []
    design, p = run.design, len(run.design.position_deg)
    sigma, freedom, kind = repeatability(run, solution)
    if sigma is None:
        name = "repeatability, which no reading is left over to show"
        terms.append(MissingInput(name, "u_repeatability_arcsec"))
    else:
        sensitivity = transfer.of_covariance(design.covariance[:p, :p])
        basis = f"residuals of {design.readings} readings, {freedom:g} degrees of freedom" if kind == "A" else "stated"
        basis += "; of one reading, through the solution with its covariance"
        terms.append(Contribution("repeatability", kind, "normal", sigma, "arcsec", sensitivity, basis, freedom))
    if design.lost_orders:
        terms += _lost(run, transfer)
    terms += autocollimator(run.run, transfer.of_independent)
    limit = stated_number(run.run, "tilt_limit_arcsec")
    if limit is None:
        terms.append(MissingInput("tower tilt", "tilt_limit_arcsec"))
    else:
        basis = f"tilt somewhere below {limit:g} arcsec as stated, azimuth unknown; a closure run does not show it"
        terms.append(Contribution("tower tilt", "B", "rectangular", TILT_LIMIT_FACTOR * limit**2, "arcsec", 1.0, basis))
    terms += eccentric_mounting(run.run, transfer.of_independent)
    terms += temperature(run.run, transfer.of_independent)
    return terms


def _lost(run: ClosureRun, transfer: FitTransfer):
    """What the settings could not separate, and so was given to the faces."""
    orders = ", ".join(map(str, run.design.lost_orders))
    u = stated_number(run.run, "u_face_deviation_arcsec")
    lost = run.design.lost_from_faces
    if u is None and lost.any():
        yield MissingInput(f"faces in the lost orders ({orders})", "u_face_deviation_arcsec")
    elif u is not None:
        basis = f"stated; orders {orders} of the encoder were given to the faces, which bound them"
        sensitivity = transfer.of_covariance(lost @ lost.T)
        yield Contribution("faces in the lost orders", "B", "normal", u, "arcsec", sensitivity, basis)


def _parted(terms) -> tuple[tuple[Contribution, ...], tuple[MissingInput, ...]]:
    found = tuple(term for term in terms if isinstance(term, Contribution))
    return found, tuple(term for term in terms if isinstance(term, MissingInput))
