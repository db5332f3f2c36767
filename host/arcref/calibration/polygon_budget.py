"""The uncertainty budget of a polygon run, after the GUM.

The measurand is a corrected angle anywhere on the turn, about the mean of its error over the turn: where the encoder's
zero lies is a matter of choice. The angle between two readings has this uncertainty twice, so the square root of two
times it. Each sensitivity is the rms over the turn of what an input of 1 does through the reduction, the mean over the
series and the fit. Source of the rules: JCGM 100:2008 (GUM), equations 10 and G.2b.
"""

import math

import numpy as np

from arcref.calibration.correction_budget import correction_contributions, line_phasor_of
from arcref.calibration.fit_transfer import FitTransfer
from arcref.calibration.polygon_drift import drift_shape_arcsec, return_half_arcsec
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.tower_tilt import ARCSEC_PER_RADIAN, horizontal_reading_arcsec
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget

ARCMIN_PER_RADIAN = ARCSEC_PER_RADIAN / 60

TILT_LIMIT_FACTOR = math.sqrt(9 / 160) / ARCSEC_PER_RADIAN
"""u of x per arcsec^2 of the limit: psi rectangular below the limit, azimuth unknown, equation (12) over the turn."""


def polygon_budget(inputs: PolygonInputs, fitted) -> UncertaintyBudget:
    """The budget of a corrected angle. `fitted`: the curve through the reduced errors, with its weights."""
    measured, missing = face_contributions(inputs, FitTransfer.over_turn(fitted))
    corrected, also_missing = correction_contributions(inputs.run, fitted, line_phasor(inputs))
    return UncertaintyBudget(measured + corrected, missing + also_missing)


def face_u_arcsec(inputs: PolygonInputs) -> np.ndarray:
    """Standard uncertainty of the reduced error at each face, about the mean of the faces, float64[faces].

    It is the same at every face, the first included: about the mean no face is better known than another.
    """
    contributions, _ = face_contributions(inputs, FitTransfer.to_faces(inputs.faces))
    return np.full(inputs.faces, UncertaintyBudget(contributions).combined_arcsec)


def face_contributions(
    inputs: PolygonInputs, transfer: FitTransfer
) -> tuple[tuple[Contribution, ...], tuple[MissingInput, ...]]:
    """Contributions of the measurement at the faces, and what is missing for them."""
    missing: list[MissingInput] = []
    contributions: list[Contribution] = []
    for part in (
        _certificate,
        _autocollimator,
        _repeatability,
        _drift,
        _return,
        _tilt,
        _roll,
        _eccentric,
        _temperature,
    ):
        for term in part(inputs, transfer):
            (missing if isinstance(term, MissingInput) else contributions).append(term)
    return tuple(contributions), tuple(missing)


def line_phasor(inputs: PolygonInputs) -> np.ndarray:
    """Mean over the series of exp(i phase within the grating line) at which each face was read, complex128[faces]."""
    return inputs.weight @ line_phasor_of(inputs.position_deg)


def _certificate(inputs: PolygonInputs, transfer: FitTransfer):
    u = inputs.u_face_certificate_arcsec
    if u is None:
        what = "face certificate" if inputs.certified else "face deviations, taken as nil without a certificate"
        yield MissingInput(what, "u_face_certificate_arcsec")
        return
    yield Contribution(
        "face certificate", "B", "normal", u, "arcsec", transfer.of_independent,
        "stated" if inputs.certified else "stated; the face deviations themselves were taken as nil",
    )  # fmt: skip


def _autocollimator(inputs: PolygonInputs, transfer: FitTransfer):
    if inputs.u_autocollimator_arcsec is None:
        yield MissingInput("autocollimator", "u_autocollimator_arcsec")
        return
    yield Contribution(
        "autocollimator", "B", "normal", inputs.u_autocollimator_arcsec, "arcsec", transfer.of_independent,
        "stated; the same in every round, so no mean makes it less",
    )  # fmt: skip


def _repeatability(inputs: PolygonInputs, transfer: FitTransfer):
    if inputs.repeatability_arcsec is None:
        yield MissingInput("repeatability, which one round alone does not show", "u_repeatability_arcsec")
        return
    series, freedom = len(inputs.direction), inputs.repeatability_degrees_of_freedom
    found = (
        f"scatter of {series} series, {freedom:g} degrees of freedom" if inputs.repeatability_type == "A" else "stated"
    )
    yield Contribution(
        "repeatability", inputs.repeatability_type, "normal", inputs.repeatability_arcsec, "arcsec",
        transfer.of_independent * inputs.averaging, f"{found}; of one reading, mean of {series}", freedom,
    )  # fmt: skip


def _drift(inputs: PolygonInputs, transfer: FitTransfer):
    if not np.isfinite(inputs.closing_error_arcsec).any():
        return
    u = transfer.of_shape(drift_shape_arcsec(inputs, transfer))
    basis = "closing errors of the rounds beyond the scatter, spread evenly over each round"
    yield Contribution("drift within a round", "A", "rectangular", u, "arcsec", 1.0, basis)


def _return(inputs: PolygonInputs, transfer: FitTransfer):
    if inputs.return_error_arcsec is None:
        return
    u = transfer.of_offset(return_half_arcsec(inputs))
    basis = "half the difference between the directions beyond the scatter; the ROM holds their mean"
    yield Contribution("return error", "A", "two-point", u, "arcsec", 1.0, basis)


def _tilt(inputs: PolygonInputs, transfer: FitTransfer):
    tilt = inputs.tilt
    if tilt is None:
        if inputs.tilt_limit_arcsec is None:
            yield MissingInput("tower tilt, without y readings", "tilt_limit_arcsec")
        else:
            u = TILT_LIMIT_FACTOR * inputs.tilt_limit_arcsec**2
            basis = (
                f"tilt somewhere below {inputs.tilt_limit_arcsec:g} arcsec as stated, azimuth unknown; not corrected"
            )
            yield Contribution("tower tilt", "B", "rectangular", u, "arcsec", 1.0, basis)
        return
    if not inputs.tilt_corrected:
        u = transfer.of_shape(tilt.horizontal_arcsec(inputs.theta_deg))
        basis = "what the y readings say it does to x; left uncorrected"
        yield Contribution("tower tilt", "A", "arcsine", u, "arcsec", 1.0, basis)
        return
    step_arcsec, step_deg = max(tilt.psi_arcsec, 1.0) * 1e-3, 1e-2
    for name, u, unit, step, psi, omega in (
        ("tower tilt, its size", tilt.u_psi_arcsec, "arcsec", step_arcsec, step_arcsec, 0.0),
        ("tower tilt, its azimuth", tilt.u_omega_deg, "deg", step_deg, 0.0, step_deg),
    ):
        if not math.isfinite(u):
            yield MissingInput(f"{name}: three faces show no scatter of the y readings", "tilt_limit_arcsec")
            continue
        above = horizontal_reading_arcsec(inputs.theta_deg, tilt.psi_arcsec + psi, tilt.omega_deg + omega)
        below = horizontal_reading_arcsec(inputs.theta_deg, tilt.psi_arcsec - psi, tilt.omega_deg - omega)
        yield Contribution(
            name, "A", "normal", u, unit, transfer.of_shape((above - below) / (2 * step)),
            "scatter of the y readings about the tilt; what is left after its correction", tilt.degrees_of_freedom,
        )  # fmt: skip


def _roll(inputs: PolygonInputs, transfer: FitTransfer):
    if inputs.tilt is not None and not inputs.tilt_corrected:
        u = transfer.of_shape(inputs.x_roll_arcsec)
        yield Contribution("roll, left in x", "B", "arcsine", u, "arcsec", 1.0, "stated roll times y; left uncorrected")
    u = inputs.u_autocollimator_roll_arcmin
    if u is None:
        yield MissingInput("roll of the autocollimator", "u_autocollimator_roll_arcmin")
        return
    if inputs.tilt is not None:
        sensitivity = transfer.of_shape(inputs.tilt.vertical_arcsec(inputs.theta_deg)) / ARCMIN_PER_RADIAN
        basis = "stated; roll times the tilt's y"
    elif inputs.tilt_limit_arcsec is not None:
        theta = np.radians(inputs.theta_deg)
        wave = math.hypot(transfer.of_shape(np.cos(theta)), transfer.of_shape(np.sin(theta)))
        sensitivity = inputs.tilt_limit_arcsec / math.sqrt(6) * wave / ARCMIN_PER_RADIAN
        basis = "stated; y from the tilt's limit"
    else:
        return  # without the tilt, which is named as missing, nothing can be told of the roll
    yield Contribution("roll of the autocollimator", "B", "normal", u, "arcmin", sensitivity, basis)


def _eccentric(inputs: PolygonInputs, transfer: FitTransfer):
    whole, flatness = inputs.u_eccentric_mounting_arcsec, inputs.u_face_flatness_arcsec_per_mm
    if whole is not None:
        yield Contribution(
            "eccentric mounting",
            "B",
            "normal",
            whole,
            "arcsec",
            transfer.of_independent,
            "stated as it is in a reading",
        )
    elif flatness is not None and inputs.eccentricity_mm is not None:
        # The beam wanders over a face by the eccentricity times a sine of the angle: rms over the turn.
        sensitivity = transfer.of_independent * inputs.eccentricity_mm / math.sqrt(2)
        basis = f"stated flatness; the beam wanders by up to {inputs.eccentricity_mm:g} mm over the faces"
        yield Contribution("eccentric mounting", "B", "normal", flatness, "arcsec/mm", sensitivity, basis)
    elif flatness is not None:
        yield MissingInput("eccentric mounting", "eccentricity_mm")
    elif inputs.eccentricity_mm is not None:
        yield MissingInput("eccentric mounting", "u_face_flatness_arcsec_per_mm")
    else:
        yield MissingInput("eccentric mounting", "u_eccentric_mounting_arcsec")


def _temperature(inputs: PolygonInputs, transfer: FitTransfer):
    """Only if something was stated of the temperature: it acts on the scatter and the closing errors as well."""
    whole, coefficient = inputs.u_temperature_arcsec, inputs.u_temperature_coefficient_arcsec_per_k
    if whole is not None:
        yield Contribution("temperature", "B", "normal", whole, "arcsec", transfer.of_independent, "stated")
    elif coefficient is not None and inputs.temperature_change_k is not None:
        change = inputs.temperature_change_k / math.sqrt(12)
        sensitivity = transfer.of_independent * change
        basis = f"stated coefficient; change of {inputs.temperature_change_k:g} K, rectangular"
        yield Contribution("temperature", "B", "normal", coefficient, "arcsec/K", sensitivity, basis)
    elif coefficient is not None:
        yield MissingInput("temperature", "temperature_change_k")
    elif inputs.temperature_change_k is not None:
        yield MissingInput("temperature", "u_temperature_coefficient_arcsec_per_k")
