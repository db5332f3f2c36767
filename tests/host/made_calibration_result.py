"""Calibration results for tests of the report: made polygon runs that went through the real reduction and budget."""

from made_polygon_run import polygon_run_text

from arcref.calibration.calibration_result import CalibrationResult, ReportSection, SeriesErrors
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration.monte_carlo import monte_carlo
from arcref.calibration.polygon_budget import face_u_arcsec, polygon_budget
from arcref.calibration.polygon_inputs import PolygonInputs
from arcref.calibration.polygon_reduction import reduce_polygon
from arcref.calibration.polygon_run import read_polygon_run
from arcref.check import Check
from arcref.error_curve import ErrorCurve


def reduced(path, **made):
    """A made run, written to `path`, read and reduced: reduction and inputs of its budget."""
    path.write_text(polygon_run_text(**made), encoding="utf-8")
    reduction = reduce_polygon(read_polygon_run(path))
    return reduction, PolygonInputs.of(reduction)


def calibration_result(path, fit="rbf", runs=0, sections=(), warnings=(), **made) -> CalibrationResult:
    """A polygon calibration; `runs`: of the Monte Carlo, 0 for none."""
    reduction, inputs = reduced(path, **made)
    run = reduction.run.run
    curve = ErrorCurve(reduction.angle_deg, reduction.error_arcsec, face_u_arcsec(inputs))
    fitted = fit_curve(curve, fit)
    budget = polygon_budget(inputs, fitted)
    results = {"repeatability_arcsec": inputs.repeatability_arcsec}
    if runs:
        results["monte_carlo"] = monte_carlo(reduction, fitted, budget.combined_arcsec, runs).figures()
    series = SeriesErrors(
        reduction.angle_deg,
        reduction.error_of_series_arcsec,
        inputs.direction,
        reduction.closing_error_arcsec,
        reduction.return_error_arcsec,
    )
    return CalibrationResult(
        kind="polygon",
        run=run,
        curve=curve,
        results=results,
        budget=budget,
        method=("The encoder was read at each face of the polygon while the autocollimator looked at it.",),
        figures=(("faces", str(inputs.faces)),),
        checks=(Check("each round closes within 0.5 arcsec", "0.12 arcsec at most", True),),
        warnings=tuple(warnings),
        sections=tuple(sections) or (ReportSection("Signs", ("x adds to the error.",), ("sign",), (("+1",),)),),
        not_checked=("Angles between the faces.", "Errors within one grating line."),
        provenance={"encoder_serial": run.metadata.get("encoder_serial"), "inputs": [run.file.record]},
        fitted=fitted,
        series=series,
    )
