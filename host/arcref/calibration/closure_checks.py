"""What is refused of a solved closure run, what is checked, warned of, and not checked."""

import math

import numpy as np
from scipy.stats import chi2

from arcref.angle import ARCSEC_PER_COUNT
from arcref.calibration.closure_mistakes import refuse_deviations, refuse_misread
from arcref.calibration.closure_plan import WEAK
from arcref.calibration.closure_run import ClosureRun, X
from arcref.calibration.closure_sections import outlier_rows, reading_name
from arcref.calibration.closure_solution import FALSE_ALARM, ClosureSolution, solve_closure
from arcref.calibration.fit_sections import aliasing_warning
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.stated_values import stated_number
from arcref.check import Check

OUTLIERS_NAMED = 5

# A quarter of a signal period: an error within a line has then changed altogether.
_SAME_PLACE_ARCSEC = 79.0


def refuse_mistakes(run: ClosureRun, solution: ClosureSolution) -> None:
    """Raises `InputError` for readings that no such set-up gives, see `closure_mistakes`."""
    x_alone = solve_closure(run.design, run.x_arcsec)
    refuse_misread(run.run, run.run[X], solution.residual_arcsec, x_alone.residual_arcsec, run.sign)
    refuse_deviations(run.run, run.design.faces, solution.face_deviation_arcsec, solution.mounting_arcsec)


def closure_checks(run: ClosureRun, solution: ClosureSolution) -> tuple[Check, ...]:
    """The demands on a run."""
    design, checks = run.design, []
    outliers = outlier_rows(solution)
    if design.degrees_of_freedom > 1:
        named = "; ".join(
            f"{reading_name(run, index)}: residual {solution.residual_arcsec[index]:+.2f} arcsec, "
            f"{abs(solution.studentized_residual[index]):.1f} standard deviations of the others"
            for index in outliers[:OUTLIERS_NAMED]
        )
        more = f"; {len(outliers) - OUTLIERS_NAMED} more" if len(outliers) > OUTLIERS_NAMED else ""
        found = named + more or f"largest {np.abs(solution.studentized_residual).max():.1f} standard deviations"
        checks.append(Check("No reading stands out from all others.", found, not outliers))
    stated, sigma = stated_number(run.run, "u_repeatability_arcsec"), solution.sigma_arcsec
    if stated is not None and design.degrees_of_freedom > 0:
        freedom = design.degrees_of_freedom
        # A reading of the encoder is a whole count besides.
        limit = math.hypot(stated, ARCSEC_PER_COUNT / math.sqrt(12)) * math.sqrt(
            chi2.isf(FALSE_ALARM, freedom) / freedom
        )
        sentence = f"The readings scatter no more than the stated {stated:g} arcsec and whole counts explain."
        checks.append(Check(sentence, f"{sigma:.3f} arcsec, limit {limit:.3f}", bool(sigma <= limit)))
    if run.closing_error_arcsec:
        place, worst = max(run.closing_error_arcsec.items(), key=lambda item: abs(item[1]))
        sentence = f"The first face read again agrees within {run.closing_limit_arcsec:g} arcsec at each setting."
        found = f"{worst:+.3f} arcsec at most, setting {place[1]}" + (f", round {place[0]}" if run.rounds > 1 else "")
        checks.append(Check(sentence, found, abs(worst) <= run.closing_limit_arcsec))
    return tuple(checks)


def closure_warnings(run: ClosureRun, fitted: FittedCurve, readings_deg: np.ndarray) -> tuple[str, ...]:
    """What a reader should mind; `readings_deg` as in `aliases`."""
    warnings = []
    if run.sign_basis.startswith("assumed") and np.ptp(run.x_arcsec) > 0:
        warnings.append(
            "The run file states no autocollimator_sign; +1 was taken: x grows as the encoder's reading would."
        )
    factor = np.nan_to_num(run.design.noise_factor)
    if factor.max() > WEAK:
        order = int(run.design.orders[int(np.argmax(factor))])
        plan = f"arcref calibrate closure {run.run.path.name} --plan"
        warnings.append(
            f"These settings separate order {order} with {factor.max():.1f} times the noise of a whole set; "
            f"'{plan}' says what would do better."
        )
    if run.design.lost_orders:
        warnings.append(_lost_sentence(run))
    if run.spread_arcsec > _SAME_PLACE_ARCSEC:
        warnings.append(
            f"Readings that count as one position lie up to {run.spread_arcsec:.0f} arcsec from their mean: an error "
            "within the grating line is not the same in them and counts as scatter."
        )
    aliased = aliasing_warning(fitted, readings_deg)
    return (*warnings, aliased) if aliased else tuple(warnings)


def _lost_sentence(run: ClosureRun) -> str:
    """Which orders are in neither the curve nor, unless something bounds them, its uncertainty."""
    orders = ", ".join(map(str, run.design.lost_orders))
    text = f"These settings cannot tell order {orders} of the encoder's error from "
    if run.design.lost_to_mountings:
        text += "the mountings of settings that share no position"
        text += ", nor from the faces" if run.design.lost_from_faces.any() else ""
        return f"{text}; it is in neither the curve nor its uncertainty."
    if stated_number(run.run, "u_face_deviation_arcsec") is None:
        return f"{text}the faces; it is in neither the curve nor its uncertainty."
    return f"{text}the faces; it is not in the curve, and its uncertainty is what u_face_deviation_arcsec states."


def closure_not_checked(run: ClosureRun) -> tuple[str, ...]:
    """What a closure run cannot see."""
    return (
        "A drift that is the same at each setting looks like face deviations; only the first face, read again at the "
        "end of a setting, shows it.",
        "Tower tilt: there are no y readings. A tilt that turns with the polygon counts as face deviations, one that "
        "stays with the encoder as its error.",
        "The scale of the autocollimator, which every x reading shares.",
        f"Errors between the positions: an order above {run.design.orders[-1]} looks like a lower one.",
        "The error within a grating line: positions are repeated within "
        f"{run.spread_arcsec:.0f} arcsec, and a line is 316 arcsec wide.",
    )
