"""Contributions that only the run file's metadata can state, for methods with a polygon or without.

Each function takes the run and the sensitivity of the result to an independent error of every reading, and yields a
`Contribution`, or a `MissingInput` that says which key would state it.
"""

import math
from collections.abc import Iterator

from arcref.calibration.stated_values import stated_number, stated_standard_uncertainty
from arcref.calibration.uncertainty_budget import Contribution, MissingInput
from arcref.run_file import RunFile


def autocollimator(run: RunFile, sensitivity: float) -> Iterator[Contribution | MissingInput]:
    """Calibration of the autocollimator."""
    u = stated_standard_uncertainty(run, "u_autocollimator_arcsec", "expanded_autocollimator_arcsec")
    if u is None:
        yield MissingInput("autocollimator", "u_autocollimator_arcsec")
        return
    basis = "stated; the same whenever x is the same, so no mean makes it less"
    yield Contribution("autocollimator", "B", "normal", u, "arcsec", sensitivity, basis)


def eccentric_mounting(run: RunFile, sensitivity: float) -> Iterator[Contribution | MissingInput]:
    """The beam wanders over faces that are not flat, because the polygon sits beside the axis."""
    name = "eccentric mounting"
    whole, flatness, eccentricity = (
        stated_number(run, key)
        for key in ("u_eccentric_mounting_arcsec", "u_face_flatness_arcsec_per_mm", "eccentricity_mm")
    )
    if whole is not None and flatness is not None:
        problem = "u_eccentric_mounting_arcsec stands here too, one was expected"
        raise run.metadata_error("u_face_flatness_arcsec_per_mm", problem)
    if whole is not None:
        yield Contribution(name, "B", "normal", whole, "arcsec", sensitivity, "stated as it is in a reading")
    elif flatness is not None and eccentricity is not None:
        # The beam wanders over a face by the eccentricity times a sine of the angle: rms over the turn.
        basis = f"stated flatness; the beam wanders by up to {eccentricity:g} mm over the faces"
        wander = sensitivity * eccentricity / math.sqrt(2)
        yield Contribution(name, "B", "normal", flatness, "arcsec/mm", wander, basis)
    elif flatness is not None:
        yield MissingInput(name, "eccentricity_mm")
    elif eccentricity is not None:
        yield MissingInput(name, "u_face_flatness_arcsec_per_mm")
    else:
        yield MissingInput(name, "u_eccentric_mounting_arcsec")


def temperature(run: RunFile, sensitivity: float) -> Iterator[Contribution | MissingInput]:
    """Temperature, if something was stated of it: it acts on the scatter as well."""
    whole, coefficient, change = (
        stated_number(run, key)
        for key in ("u_temperature_arcsec", "u_temperature_coefficient_arcsec_per_k", "temperature_change_k")
    )
    if whole is not None and coefficient is not None:
        problem = "u_temperature_arcsec stands here too, one was expected"
        raise run.metadata_error("u_temperature_coefficient_arcsec_per_k", problem)
    if whole is not None:
        yield Contribution("temperature", "B", "normal", whole, "arcsec", sensitivity, "stated")
    elif coefficient is not None and change is not None:
        basis = f"stated coefficient; change of {change:g} K, rectangular"
        moved = sensitivity * change / math.sqrt(12)
        yield Contribution("temperature", "B", "normal", coefficient, "arcsec/K", moved, basis)
    elif coefficient is not None:
        yield MissingInput("temperature", "temperature_change_k")
    elif change is not None:
        yield MissingInput("temperature", "u_temperature_coefficient_arcsec_per_k")
