"""From a closure run to its calibration: error curve, budget, checks, and what the report says."""

import numpy as np

from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult, SeriesErrors
from arcref.calibration.closure_budget import closure_budget, face_u_arcsec, position_u_arcsec, repeatability
from arcref.calibration.closure_checks import (
    closure_checks,
    closure_not_checked,
    closure_warnings,
    refuse_mistakes,
)
from arcref.calibration.closure_run import ClosureRun
from arcref.calibration.closure_sections import closure_sections
from arcref.calibration.closure_solution import ClosureSolution, solve_closure
from arcref.calibration.correction_budget import INTERPOLATION
from arcref.calibration.fit_options import USUAL_FIT, FitOptions, fit_report
from arcref.calibration.fits.fit_names import fit_curve
from arcref.calibration_file import readings_json
from arcref.error_curve import ErrorCurve

DATUM = "mean of the encoder's errors over the positions and mean of the face deviations both zero"

_DIGITS = 6


def closure_result(run: ClosureRun, options: FitOptions = USUAL_FIT) -> CalibrationResult:
    """Solve and judge a run. Raises `InputError` for readings that no such set-up gives, see `closure_mistakes`."""
    solution = solve_closure(run.design, run.reading_arcsec())
    refuse_mistakes(run, solution)
    curve = _curve(run, solution)
    fitted = fit_curve(curve, options.fit)
    budget = closure_budget(run, solution, fitted)
    readings_deg = _readings_deg(run)
    face_u = face_u_arcsec(run, solution)
    fit_results, fit_sections = fit_report(fitted, options, readings_deg)
    results = _results(run, solution, face_u) | fit_results | {"expanded_uncertainty_arcsec": budget.expanded_arcsec}
    results["expanded_uncertainty_without_interpolation_arcsec"] = budget.without(INTERPOLATION).expanded_arcsec
    results["readings"] = readings_json(readings_deg, np.ones(readings_deg.shape[1]))
    return CalibrationResult(
        kind="closure",
        run=run.run,
        curve=curve,
        results=results,
        budget=budget,
        method=_method(run),
        figures=_figures(run, solution, curve, budget, face_u),
        checks=closure_checks(run, solution),
        warnings=closure_warnings(run, fitted, readings_deg),
        sections=closure_sections(run, solution, face_u, options.plots) + fit_sections,
        not_checked=closure_not_checked(run),
        provenance=curve.provenance,
        fitted=fitted,
        series=_series(run, solution),
    )


def _curve(run: ClosureRun, solution: ClosureSolution) -> ErrorCurve:
    """The encoder's errors at its own angles, from the lowest up."""
    order = _order_of_curve(run)
    u = position_u_arcsec(run, solution)
    method = {
        "name": "closure: encoder and polygon by least squares",
        "faces": run.faces,
        "settings": run.settings,
        "setting_step_deg": run.setting_step_deg,
        "rounds": run.rounds,
        "readings": run.design.readings,
        "autocollimator_sign": run.sign,
        "datum": DATUM,
        "lost_orders": list(run.design.lost_orders),
    }
    provenance = calibration_provenance(method, run.run)
    return ErrorCurve(
        _curve_angles(run), solution.encoder_error_arcsec[order], None if u is None else u[order], provenance
    )


def _results(run: ClosureRun, solution: ClosureSolution, face_u: np.ndarray | None) -> dict:
    design = run.design
    sigma, freedom, kind = repeatability(run, solution)
    order = _order_of_curve(run)
    p = len(order)
    rows = np.concatenate([order, p + np.arange(len(design.faces))])
    covariance = None if sigma is None else sigma**2 * design.covariance[np.ix_(rows, rows)]
    series = {int(s): (int(r), int(k)) for s, r, k in zip(design.series, run.round, run.setting, strict=True)}
    return {
        "datum": DATUM,
        "face_deviation_arcsec": _by_face(run, solution.face_deviation_arcsec),
        "u_face_deviation_arcsec": None if face_u is None else _by_face(run, face_u),
        "repeatability_arcsec": sigma,
        "repeatability_type": kind,
        "degrees_of_freedom": design.degrees_of_freedom,
        "lost_orders": list(design.lost_orders),
        "noise_factor": {
            str(number): None if np.isnan(factor) else _rounded(factor)
            for number, factor in zip(design.orders, design.noise_factor, strict=True)
        },
        "mounting": [
            {"round": series[number][0], "setting": series[number][1], "mounting_arcsec": _rounded(value)}
            for number, value in enumerate(solution.mounting_arcsec)
        ],
        "closing_error_arcsec": [
            {"round": place[0], "setting": place[1], "closing_error_arcsec": _rounded(value)}
            for place, value in sorted(run.closing_error_arcsec.items())
        ],
        "covariance_order": "encoder errors in the order of the curve, then face deviations of the faces read",
        "covariance_arcsec2": None if covariance is None else [[_rounded(v) for v in row] for row in covariance],
    }


def _method(run: ClosureRun) -> tuple[str, ...]:
    x = "added to" if run.sign > 0 else "subtracted from"
    solved = (
        f"The polygon of {run.faces} faces was set at {run.settings} positions on the encoder, "
        f"{run.setting_step_deg:g} deg apart"
        + (f", in {run.rounds} rounds" if run.rounds > 1 else "")
        + f"; {run.design.readings} readings. Each reading, less the nominal position, is the encoder's error there "
        "plus the deviation of the face plus the mounting of that series. All of them were solved together by least "
        "squares; no certificate was used."
    )
    return (
        solved,
        f"Autocollimator x was {x} the encoder's reading ({run.sign_basis}). Error is reading less true angle.",
        f"Datum: {DATUM}. Where the zero lies is a matter of choice; uncertainties are about the mean.",
        "The uncertainty of the scatter is that of the whole covariance of the solution, which the calibration keeps.",
    )


def _figures(run, solution, curve, budget, face_u) -> tuple[tuple[str, str], ...]:
    design = run.design
    sigma, freedom, kind = repeatability(run, solution)
    rows = [
        ("faces, settings", f"{run.faces}, {run.settings} at {run.setting_step_deg:g} deg"),
        ("readings", f"{design.readings} for {design.rank} unknowns"),
        ("positions", f"{len(design.position_deg)}, {curve.spacing_deg:.4g} deg apart"),
        ("orders lost", ", ".join(map(str, design.lost_orders)) or "none"),
        ("noise, against a whole set", f"{np.nan_to_num(design.noise_factor).max():.2f} at most"),
        ("errors", f"{np.ptp(curve.error_arcsec):.2f} arcsec peak to peak"),
        ("face deviations", f"{np.ptp(solution.face_deviation_arcsec):.2f} arcsec peak to peak"),
    ]
    if sigma is None:
        rows.append(("repeatability", "no reading is left over to tell"))
    else:
        found = f"{freedom:g} degrees of freedom" if kind == "A" else "stated"
        rows.append(("repeatability", f"{sigma:.3f} arcsec, one reading ({found})"))
        rows.append(("u of the encoder's error", f"{curve.u_arcsec.max():.3f} arcsec at most (k=1)"))
        rows.append(("u of a face, from scatter", f"{face_u.max():.3f} arcsec at most (k=1)"))
    rows.append(("expanded uncertainty", f"{budget.expanded_arcsec:.2f} arcsec (k=2) of a corrected angle"))
    return tuple(rows)


def _series(run: ClosureRun, solution: ClosureSolution) -> SeriesErrors:
    """The encoder's errors as each series has them, faces and mountings taken off."""
    design = run.design
    order = _order_of_curve(run)
    errors = np.full((design.series_count, len(order)), np.nan)
    errors[design.series, design.position] = solution.encoder_error_arcsec[design.position] + solution.residual_arcsec
    closing = np.full(design.series_count, np.nan)
    for series, round_, setting in zip(design.series, run.round, run.setting, strict=True):
        closing[series] = run.closing_error_arcsec.get((int(round_), int(setting)), np.nan)
    return SeriesErrors(
        _curve_angles(run),
        errors[:, order],
        (1,) * design.series_count,
        closing if np.isfinite(closing).any() else None,
    )


def _curve_angles(run: ClosureRun) -> np.ndarray:
    """Angles of the curve: those of the positions brought into the turn that begins half a step before zero."""
    half = 180.0 / len(run.angle_deg)
    return np.sort(np.mod(run.angle_deg + half, 360.0) - half)


def _order_of_curve(run: ClosureRun) -> np.ndarray:
    half = 180.0 / len(run.angle_deg)
    return np.argsort(np.mod(run.angle_deg + half, 360.0) - half)


def _readings_deg(run: ClosureRun) -> np.ndarray:
    """float64[p, most]: at which angles each position of the curve was read, NaN where there are fewer readings."""
    order = _order_of_curve(run)
    own = [run.position_deg[run.design.position == position] for position in order]
    table = np.full((len(own), max(map(len, own))), np.nan)
    for row, values in zip(table, own, strict=True):
        row[: len(values)] = values
    return table


def _by_face(run: ClosureRun, values: np.ndarray) -> list:
    """One entry for each face of the polygon, null for a face that was not read."""
    found: list = [None] * run.faces
    for face, value in zip(run.design.faces, values, strict=True):
        found[face] = _rounded(value)
    return found


def _rounded(value) -> float:
    """Last digits differ from machine to machine."""
    return float(f"{float(value):.{_DIGITS}g}")
