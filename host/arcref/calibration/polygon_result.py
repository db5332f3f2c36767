"""From a reduced polygon run to the calibration: curve, fit, budget, checks, and what the report needs."""

import math
from dataclasses import dataclass

import numpy as np

from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult, Check, SeriesErrors
from arcref.calibration.correction_budget import INTERPOLATION
from arcref.calibration.fit_comparison import compare_fits
from arcref.calibration.fit_sections import aliasing_section, aliasing_warning, comparison_section, fit_section
from arcref.calibration.fits.fit_names import DEFAULT_FIT, fit_curve
from arcref.calibration.monte_carlo import monte_carlo
from arcref.calibration.polygon_budget import face_u_arcsec, polygon_budget
from arcref.calibration.polygon_checks import closing_limit, polygon_checks, polygon_not_checked, polygon_warnings
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.polygon_reduction import PolygonReduction
from arcref.calibration.polygon_sections import method_paragraphs, series_section, tilt_section
from arcref.calibration.tilt_adjustment import AdjustingScrews, screw_turns
from arcref.calibration.tilt_tolerance import TiltTolerance
from arcref.calibration_file import readings_json
from arcref.error_curve import ErrorCurve


@dataclass(frozen=True)
class PolygonOptions:
    """How a reduced run becomes a calibration.

    `fit`: name of the curve through the errors; `compare`: fit by its rivals as well; `second`: a run to verify the
    fit with; `monte_carlo_runs`: 0 for none; `plots`: whether the report will be drawn; `suspicion`: a mistake that
    seems to have been made and that the user accepted.
    """

    fit: str = DEFAULT_FIT
    compare: bool = False
    second: ErrorCurve | None = None
    monte_carlo_runs: int = 0
    plots: bool = False
    progress: bool = False
    suspicion: str | None = None


def polygon_result(reduction: PolygonReduction, options: PolygonOptions = PolygonOptions()) -> CalibrationResult:
    """The calibration. Raises `InputError` for stated numbers that cannot be, and as the fit does."""
    run = reduction.run
    inputs = PolygonInputs.of(reduction)
    curve = ErrorCurve(reduction.angle_deg, reduction.error_arcsec, face_u_arcsec(inputs))
    fitted = fit_curve(curve, options.fit)
    budget = polygon_budget(inputs, fitted)
    results = _results(reduction) | {"fit": {"name": fitted.name, "parameters": fitted.parameters}}
    results["expanded_uncertainty_arcsec"] = budget.expanded_arcsec
    results["expanded_uncertainty_without_interpolation_arcsec"] = budget.without(INTERPOLATION).expanded_arcsec
    reading_deg = run.position_deg[run.series.reading_of_face].T
    results["readings"] = readings_json(reading_deg, run.series.weight)
    checks, warnings = polygon_checks(reduction), polygon_warnings(reduction)
    if options.suspicion:
        warnings.insert(0, f"Accepted though it looks like a mistake: {options.suspicion}.")
    warnings += filter(None, [aliasing_warning(fitted, reading_deg)])
    sections = [series_section(reduction)]
    if reduction.tilt is not None:
        sections.append(tilt_section(reduction, plot=options.plots))
    sections.append(fit_section(fitted, options.plots))
    if options.compare or options.second is not None:
        comparison = compare_fits(fitted, options.second)
        results["comparison"] = comparison.to_json()
        sections.append(comparison_section(comparison, options.plots))
    sections.append(aliasing_section(fitted, reading_deg))
    if options.monte_carlo_runs:
        repeated = monte_carlo(
            reduction, fitted, budget.combined_arcsec, options.monte_carlo_runs, progress=options.progress
        )
        results["monte_carlo"] = repeated.figures()
        found = f"{repeated.u_arcsec:.4f} against {budget.combined_arcsec:.4f} arcsec, {repeated.from_budget:+.1%}"
        found += f", own scatter {repeated.scatter:.1%}"
        demand = "the Monte Carlo agrees with the budget within 5 % and twice its own scatter"
        checks.append(Check(demand, found, repeated.agrees))
    method = {
        "name": "polygon",
        "faces": run.faces,
        "series": len(run.series.direction),
        "autocollimator_sign": run.sign,
        "tilt_corrected": reduction.tilt_corrected,
        "fit": fitted.name,
    }
    return CalibrationResult(
        kind="polygon",
        run=run.run,
        curve=curve,
        results=results,
        budget=budget,
        method=(*method_paragraphs(reduction), f"The curve through the errors is a {fitted.title}."),
        figures=tuple(_figures(reduction, fitted, budget, results)),
        checks=tuple(checks),
        warnings=tuple(warnings),
        sections=tuple(sections),
        not_checked=tuple(polygon_not_checked(reduction)),
        provenance=calibration_provenance(method, run.run),
        fitted=fitted,
        series=SeriesErrors(
            reduction.angle_deg,
            reduction.error_of_series_arcsec,
            run.series.direction,
            reduction.closing_error_arcsec,
            reduction.return_error_arcsec,
        ),
    )


def _results(reduction: PolygonReduction) -> dict:
    """The method's numbers, ready for JSON: what is not known is null."""
    run, series = reduction.run, reduction.run.series
    limit, basis = closing_limit(reduction)
    returned = reduction.return_error_arcsec
    results = {
        "faces": run.faces,
        "autocollimator_sign": run.sign,
        "autocollimator_sign_basis": run.sign_basis,
        "certificate_used": run.face_deviation_arcsec is not None,
        "closing_limit_arcsec": limit,
        "closing_limit_basis": basis,
        "series": [
            {"round": number, "direction": way, "closing_error_arcsec": _finite(closing)}
            for number, way, closing in zip(series.round, series.direction, reduction.closing_error_arcsec, strict=True)
        ],
        "repeatability_arcsec": _finite(reduction.repeatability_arcsec),
        "repeatability_degrees_of_freedom": reduction.degrees_of_freedom,
        "return_error_arcsec": None if returned is None else returned.tolist(),
        "error_without_tilt_correction_arcsec": reduction.uncorrected_error_arcsec.tolist(),
    }
    if reduction.tilt is not None:
        results["tilt"] = _tilt_results(reduction)
    return results


def _tilt_results(reduction: PolygonReduction) -> dict:
    tilt, run = reduction.tilt, reduction.run
    results = {
        "psi_arcsec": tilt.psi_arcsec,
        "u_psi_arcsec": _finite(tilt.u_psi_arcsec),
        "omega_deg": tilt.omega_deg,
        "u_omega_deg": _finite(tilt.u_omega_deg),
        "y_sigma_arcsec": _finite(tilt.sigma_arcsec),
        "y_residual_arcsec": tilt.residual_arcsec.tolist(),
        "roll_arcmin": run.roll_arcmin,
        "corrected": reduction.tilt_corrected,
        "x_of_tilt_arcsec": (run.sign * tilt.horizontal_arcsec(run.series.theta_deg)).tolist(),
    }
    tolerance = TiltTolerance.of_run(run.run)
    if tolerance is not None:
        results["tolerance"] = {
            "grade": tolerance.grade,
            "accuracy_arcsec": tolerance.accuracy_arcsec,
            "published_arcsec": tolerance.published_arcsec,
            "formula_arcsec": tolerance.formula_arcsec,
            "at_worst_azimuth_arcsec": tolerance.strict_arcsec,
        }
    screws = AdjustingScrews.of_run(run.run)
    if screws is not None:
        results["screws"] = [
            {"number": turn.number, "angle_deg": turn.angle_deg, "rise_um": turn.rise_um, "turn_deg": turn.turn_deg}
            for turn in screw_turns(tilt, screws)
        ]
    return results


def _figures(reduction: PolygonReduction, fitted, budget, results: dict):
    """The short table on the terminal and at the page's top."""
    run = reduction.run
    statistics = fitted.curve.statistics()
    forward = run.series.direction.count(1)
    backward = len(run.series.direction) - forward
    ways = [f"{count} {way}" for count, way in ((forward, "forward"), (backward, "backward")) if count]
    yield "readings", f"{run.faces} faces, {' and '.join(ways)}"
    yield "sign of x", f"{run.sign:+d}, {run.sign_basis}"
    yield "error", f"sigma {statistics.sigma_arcsec:.3f}, peak to peak {statistics.peak_to_peak_arcsec:.3f} arcsec"
    closing = np.abs(reduction.closing_error_arcsec)
    if np.isfinite(closing).any():
        limit = results["closing_limit_arcsec"]
        yield "closing error", f"{np.nanmax(closing):.3f} arcsec at most, limit {limit:.3g} arcsec"
    else:
        yield "closing error", "no round was closed"
    if reduction.degrees_of_freedom:
        yield (
            "repeatability",
            (
                f"{reduction.repeatability_arcsec:.3f} arcsec a reading, "
                f"{reduction.degrees_of_freedom} degrees of freedom"
            ),
        )
    if reduction.return_error_arcsec is not None:
        yield "return error", f"{np.abs(reduction.return_error_arcsec).max():.3f} arcsec at most"
    if reduction.tilt is not None:
        yield from _tilt_figures(reduction, results)
    yield "fit", f"{fitted.title}, left out {fitted.leave_one_out_rms_arcsec:.3f} arcsec rms"
    if "monte_carlo" in results:
        repeated = results["monte_carlo"]
        yield "Monte Carlo", f"{repeated['runs']} runs, {repeated['u_arcsec']:.4f} arcsec (k=1)"
    missing = f"; {len(budget.missing)} inputs not stated" if budget.missing else ""
    yield "expanded uncertainty", f"{budget.expanded_arcsec:.3f} arcsec (k=2) of a corrected angle{missing}"


def _tilt_figures(reduction: PolygonReduction, results: dict):
    tilt = reduction.tilt
    u_psi, u_omega = results["tilt"]["u_psi_arcsec"], results["tilt"]["u_omega_deg"]
    psi, omega = f"{tilt.psi_arcsec:.3f}", f"{tilt.omega_deg:.3f}"
    if u_psi is not None:
        psi, omega = f"{psi} (u {u_psi:.3f})", f"{omega} (u {u_omega:.3f})"
    done = "taken off x" if reduction.tilt_corrected else "left in x"
    yield "tower tilt", f"{psi} arcsec towards {omega} deg, {done}"
    tolerance = results["tilt"].get("tolerance")
    if tolerance is not None:
        published = tolerance["published_arcsec"]
        text = f"{tolerance['formula_arcsec']:.1f} arcsec by the formula"
        yield "tilt tolerance", text if published is None else f"{text}, {published:g} as published"
    for screw in results["tilt"].get("screws", ()):
        turn = "" if screw["turn_deg"] is None else f", {screw['turn_deg']:+.1f} deg of turn"
        yield f"screw {screw['number']}", f"{screw['rise_um']:+.1f} um{turn} (+ raises)"


def _finite(value) -> float | None:
    return float(value) if math.isfinite(value) else None
