"""From a theodolite run to its calibration: error curve over the arc, budget, checks, and what the report says."""

import numpy as np

from arcref.angle import format_dms
from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult, SeriesErrors
from arcref.calibration.fit_options import USUAL_FIT, FitOptions, fit_report
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.stated_values import stated_number
from arcref.calibration.theodolite_budget import arc_budget, azimuth_noise, place_covariance_arcsec2, zenith_noise
from arcref.calibration.theodolite_checks import (
    arc_checks,
    arc_not_checked,
    arc_warnings,
    refuse_misfit,
    refuse_short_arc,
)
from arcref.calibration.theodolite_findings import ArcFindings
from arcref.calibration.theodolite_model import LARGEST_ALPHA_DEG
from arcref.calibration.theodolite_run import TheodoliteRun
from arcref.calibration.theodolite_sections import arc_sections
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcSolution, solve_arc
from arcref.error_curve import ErrorCurve

DATUM = "mean error over the arc zero"

REQUIRED_KEY = "required_expanded_uncertainty_arcsec"

_DIGITS = 7


def theodolite_result(
    run: TheodoliteRun, options: FitOptions = USUAL_FIT, required_arcsec: float | None = None
) -> CalibrationResult:
    """Identify axis and mirror, find the errors, and judge.

    `required_arcsec`: largest expanded uncertainty (k=2) of the error anywhere on the arc; None takes what the run
    states. Raises `InputError` when no axis fits the elevations, or the arc is too short for what is required.
    """
    solution = solve_arc(run.readings)
    refuse_misfit(run, solution)
    sensitivity = solution.sensitivity()
    covariance = place_covariance_arcsec2(run, solution, sensitivity)
    required = stated_number(run.run, REQUIRED_KEY) if required_arcsec is None else required_arcsec
    if required is not None:
        refuse_short_arc(run, solution, covariance, required)
    found = ArcFindings(run, solution, sensitivity, _curve(run, solution, covariance), covariance)
    fitted = fit_curve(found.curve, options.fit)
    budget = arc_budget(run, solution, sensitivity, fitted)
    fit_results, fit_sections = fit_report(fitted, options)
    results = _results(found) | fit_results | {"expanded_uncertainty_arcsec": budget.expanded_arcsec}
    return CalibrationResult(
        kind="theodolite",
        run=run.run,
        curve=found.curve,
        results=results,
        budget=budget,
        method=_method(found),
        figures=_figures(found, budget),
        checks=arc_checks(found, required),
        warnings=arc_warnings(found),
        sections=arc_sections(found, options.plots) + fit_sections,
        not_checked=arc_not_checked(run),
        provenance=found.curve.provenance,
        fitted=fitted,
        series=_series(found) if run.rounds > 1 else None,
    )


def _curve(run: TheodoliteRun, solution: ArcSolution, covariance_arcsec2) -> ErrorCurve:
    method = {
        "name": "limited angle: mirror and autocollimating theodolite",
        "places": solution.readings.places,
        "rounds": run.rounds,
        "encoder_direction": run.direction,
        "datum": DATUM,
        "datum_deg": run.datum_deg,
    }
    angle = run.angle_deg
    u = None if covariance_arcsec2 is None else np.sqrt(np.diag(covariance_arcsec2))
    arc = None if run.goes_around else (float(angle[0]), float(angle[-1]))
    provenance = calibration_provenance(method, run.run)
    return ErrorCurve(angle, run.direction * solution.error_arcsec, u, provenance, arc_deg=arc)


def _results(found: ArcFindings) -> dict:
    run, solution, geometry = found.run, found.solution, found.solution.geometry
    u_alpha, u_delta, u_omega = found.u_angles_deg
    covariance = found.angle_covariance_deg2
    azimuth, zenith = azimuth_noise(run, solution), zenith_noise(run, solution)
    known = found.delta_is_known
    pairs = (("alpha_delta", 0, 1), ("alpha_omega", 0, 2), ("delta_omega", 1, 2))
    size = np.sqrt(np.diag(covariance))
    return {
        "alpha_deg": _rounded(geometry.alpha_deg),
        "u_alpha_deg": _rounded(u_alpha),
        "delta_deg": _rounded(geometry.delta_deg) if known else None,
        "u_delta_deg": _rounded(u_delta) if known else None,
        "omega_deg": _rounded(geometry.omega_deg),
        "u_omega_deg": _rounded(u_omega),
        "delta_sense": "printed equations: counter-clockwise seen from above, from the normal at the datum",
        "correlation": {
            name: _rounded(covariance[i, j] / (size[i] * size[j])) if known else None for name, i, j in pairs
        },
        "sine_alpha_sine_delta": _rounded(geometry.across),
        "sine_alpha_cosine_delta": _rounded(geometry.along),
        "datum": DATUM,
        "datum_deg": run.datum_deg,
        "arc_deg": _rounded(run.arc_deg),
        "zenith_reading_u_arcsec": _rounded(zenith.arcsec),
        "azimuth_reading_u_arcsec": None if azimuth.arcsec is None else _rounded(azimuth.arcsec),
        "elevation_scatter_arcsec": _rounded(solution.elevation_sigma_arcsec),
        "uncorrected_arcsec": [_rounded(value) for value in found.uncorrected_arcsec],
        "parameter_u_arcsec": [_rounded(value) for value in found.parameter_u_arcsec],
        "closed_form_difference_arcsec": _rounded(found.closed_form_difference_arcsec),
        "covariance_arcsec2": None
        if found.covariance_arcsec2 is None
        else [[_rounded(value) for value in row] for row in found.covariance_arcsec2],
    }


def _method(found: ArcFindings) -> tuple[str, ...]:
    run = found.run
    return (
        "A plane mirror turned with the shaft, and a theodolite that stood still read the direction of its normal by "
        f"autocollimation, at {found.solution.readings.places} places over {run.arc_deg:.4g} deg"
        + (f", in {run.rounds} rounds" if run.rounds > 1 else "")
        + ". The elevations (zenith reading less 90 deg) tell where axis and mirror stand; with these each azimuth is "
        "turned into the shaft's true angle, exactly. The method is that of Wang Tao et al., Acta Optica Sinica 38(5) "
        "2018; delta is counted as its printed equations have it, counter-clockwise seen from above.",
        "Three parameters were found from the elevations: in closed form first, then by nonlinear least squares. Four "
        f"axes give the same elevations; the one within {LARGEST_ALPHA_DEG:g} deg of the mirror's upright was taken. "
        "The true angles found, not the encoder's readings, were put back into the identification until nothing "
        "changed.",
        f"Angles of axis and mirror are stated at the encoder reading {run.datum_deg:g} deg ({run.datum_basis}). Error "
        f"is reading less true angle; datum: {DATUM}. Where the zero lies is a matter of choice; uncertainties are "
        "about the mean.",
    )


def _figures(found: ArcFindings, budget) -> tuple[tuple[str, str], ...]:
    run, geometry = found.run, found.solution.geometry
    u_alpha, u_delta, u_omega = found.u_angles_deg * 3600.0
    angle, azimuth, zenith = (
        found.curve.angle_deg,
        azimuth_noise(run, found.solution),
        zenith_noise(run, found.solution),
    )
    delta = "not defined so near to upright"
    if found.delta_is_known:
        delta = f"{geometry.delta_deg:.4f} deg, u {u_delta:.2f} arcsec, as the printed equations count"
    rounds = f", {run.rounds} rounds" if run.rounds > 1 else ""
    rows = [
        ("arc", f"{format_dms(angle[0])} to {format_dms(angle[-1])}, {angle.size} places{rounds}"),
        ("alpha, axis off upright", f"{geometry.alpha_deg:.4f} deg, u {u_alpha:.2f} arcsec"),
        ("delta, towards where", delta),
        ("omega, mirror looks up", f"{geometry.omega_deg:.4f} deg, u {u_omega:.2f} arcsec"),
        ("reading - azimuth", f"{np.ptp(found.uncorrected_arcsec):.1f} arcsec peak to peak, axis not known"),
        ("errors", f"{np.ptp(found.curve.error_arcsec):.2f} arcsec peak to peak"),
        ("zenith reading", f"u {zenith.arcsec:.3f} arcsec ({zenith.basis})"),
    ]
    if azimuth.arcsec is not None:
        rows.append(("azimuth reading", f"u {azimuth.arcsec:.3f} arcsec ({azimuth.basis})"))
        rows.append(("u of the error", f"{found.curve.u_arcsec.max():.3f} arcsec at most (k=1)"))
    rows += [
        ("of it, axis and mirror", f"{found.parameter_u_arcsec.max():.3f} arcsec at most (k=1)"),
        ("closed form differs by", f"{found.closed_form_difference_arcsec:.4f} arcsec at most"),
        ("expanded uncertainty", f"{budget.expanded_arcsec:.2f} arcsec (k=2) of a corrected angle"),
    ]
    return tuple(rows)


def _series(found: ArcFindings) -> SeriesErrors:
    """The errors of each round, about its mean."""
    run, solution = found.run, found.solution
    errors = np.full((run.rounds, solution.readings.places), np.nan)
    errors[run.round, run.place] = run.direction * ARCSEC_PER_RAD * solution.reading_error_rad
    for row in errors:
        row -= np.nanmean(row - found.curve.error_arcsec)
    return SeriesErrors(found.curve.angle_deg, errors, (1,) * run.rounds)


def _rounded(value) -> float:
    """Last digits differ from machine to machine."""
    return float(f"{float(value):.{_DIGITS}g}")
