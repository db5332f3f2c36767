"""From a reduced polygon run to the calibration: curve, fit, budget, checks, and what the report needs."""

from dataclasses import dataclass

from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult, SeriesErrors
from arcref.calibration.correction_budget import INTERPOLATION
from arcref.calibration.fit_options import USUAL_FIT, FitOptions, fit_report
from arcref.calibration.fit_sections import aliasing_warning
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.monte_carlo import monte_carlo
from arcref.calibration.polygon_budget import face_u_arcsec, polygon_budget
from arcref.calibration.polygon_checks import polygon_checks, polygon_not_checked, polygon_warnings
from arcref.calibration.polygon_figures import polygon_figures, polygon_results
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.polygon_reduction import PolygonReduction
from arcref.calibration.polygon_sections import method_paragraphs, series_section, tilt_section
from arcref.calibration_file import readings_json
from arcref.check import Check
from arcref.error_curve import ErrorCurve


@dataclass(frozen=True)
class PolygonOptions:
    """How a reduced run becomes a calibration.

    `monte_carlo_runs`: 0 for none; `progress`: whether a bar shows them; `suspicion`: a mistake that seems to have been
    made and that the user accepted.
    """

    fit: FitOptions = USUAL_FIT
    monte_carlo_runs: int = 0
    progress: bool = False
    suspicion: str | None = None


USUAL = PolygonOptions()
"""The default fit, nothing more."""


def polygon_result(reduction: PolygonReduction, options: PolygonOptions = USUAL) -> CalibrationResult:
    """The calibration. Raises `InputError` for stated numbers that cannot be, and as the fit does."""
    run = reduction.run
    inputs = PolygonInputs.of(reduction)
    curve = ErrorCurve(reduction.angle_deg, reduction.error_arcsec, face_u_arcsec(inputs))
    fitted = fit_curve(curve, options.fit.fit)
    budget = polygon_budget(inputs, fitted)
    reading_deg = run.position_deg[run.series.reading_of_face].T
    fit_results, fit_sections = fit_report(fitted, options.fit, reading_deg)
    results = polygon_results(reduction) | fit_results
    results["expanded_uncertainty_arcsec"] = budget.expanded_arcsec
    results["expanded_uncertainty_without_interpolation_arcsec"] = budget.without(INTERPOLATION).expanded_arcsec
    results["readings"] = readings_json(reading_deg, run.series.weight)
    checks, warnings = polygon_checks(reduction), polygon_warnings(reduction)
    if options.suspicion:
        warnings.insert(0, f"Accepted though it looks like a mistake: {options.suspicion}.")
    warnings += filter(None, [aliasing_warning(fitted, reading_deg)])
    sections = [series_section(reduction)]
    if reduction.tilt is not None:
        sections.append(tilt_section(reduction, plot=options.fit.plots))
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
        figures=tuple(polygon_figures(reduction, fitted, budget, results)),
        checks=tuple(checks),
        warnings=tuple(warnings),
        sections=(*sections, *fit_sections),
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
