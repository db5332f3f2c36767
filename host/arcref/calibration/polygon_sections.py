"""What a report says of a polygon run beyond the curve: its method, its rounds, its tower tilt and how to adjust it."""

import math

import numpy as np

from arcref.calibration.calibration_result import ReportSection
from arcref.calibration.polygon_checks import closing_limit, series_name
from arcref.calibration.polygon_reduction import PolygonReduction
from arcref.calibration.tilt_adjustment import AdjustingScrews, adjustment_sentences
from arcref.calibration.tilt_plot import tilt_plot
from arcref.calibration.tilt_tolerance import GRADES, TiltTolerance


def method_paragraphs(reduction: PolygonReduction) -> tuple[str, ...]:
    """How the errors were got, the sign of x named."""
    run = reduction.run
    c, b = ("+" if run.sign > 0 else "-"), ("" if run.face_deviation_arcsec is not None else ", b the nominal angle")
    rounds = len(run.series.direction)
    paragraphs = [
        f"The encoder turned a polygon of {run.faces} faces before an autocollimator. The error (reading less true "
        f"angle) at face i is e_i = (a_i - a_1) - (b_i - b_1) {c} (c_i - c_1): a the encoder's reading, b the face's "
        f"angle from its certificate{b}, c the autocollimator's x. The sign of c is {run.sign:+d}, {run.sign_basis}.",
        f"{rounds} series of {run.faces} faces{'' if rounds == 1 else ', each against its first face, were averaged'}"
        f"{'; both directions count alike' if len(set(run.series.direction)) == 2 else ''}. Angles count from the "
        f"encoder's zero; face 1 is the one read first, at {run.angle_deg[0]:g} deg.",
    ]
    if reduction.tilt is None:
        paragraphs.append("There were no y readings, so tower tilt was neither found nor corrected.")
    elif reduction.tilt_corrected:
        roll = "no roll was stated" if run.roll_arcmin is None else f"roll {run.roll_arcmin:g} arcmin as stated"
        paragraphs.append(
            "Tower tilt was found from the y readings by least squares and what it adds to x taken off by the exact "
            f"rotation about the tilted axis; {roll}."
        )
    else:
        paragraphs.append("Tower tilt was found from the y readings, and x left as it was read.")
    return tuple(paragraphs)


def series_section(reduction: PolygonReduction) -> ReportSection:
    """The rounds: limit of the closing error, scatter, return error, and how far each is from the mean."""
    run = reduction.run
    rows = [
        (series_name(run, index), f"{np.sqrt(np.mean(residual**2)):.3f}")
        for index, residual in enumerate(reduction.residual_arcsec)
        if run.series.direction.count(run.series.direction[index]) > 1
    ]
    limit, basis = closing_limit(reduction)
    paragraphs = [f"Limit of the closing error: {limit:.3g} arcsec, {basis}."]
    if reduction.degrees_of_freedom:
        paragraphs.append(
            f"Standard deviation of one reading {reduction.repeatability_arcsec:.3f} arcsec, from "
            f"{reduction.degrees_of_freedom} degrees of freedom; the constant of each series is left out."
        )
    if reduction.return_error_arcsec is not None:
        returned = reduction.return_error_arcsec
        face = int(np.argmax(np.abs(returned)))
        paragraphs.append(
            f"Return error, forward less backward: mean {returned.mean():+.3f} arcsec, largest {returned[face]:+.3f} "
            f"arcsec at face {face + 1}. What the zero drifted from series to series is in it."
        )
    columns = ("series", "scatter about the mean of its direction, rms / arcsec")
    return ReportSection("Rounds", tuple(paragraphs), columns, tuple(rows))


def tilt_section(reduction: PolygonReduction, *, plot: bool) -> ReportSection:
    """The tilt, its tolerance, and the screws. `plot`: whether to draw it, which takes half a second."""
    tilt, run = reduction.tilt, reduction.run
    screws = AdjustingScrews.of_run(run.run)
    before, after = reduction.uncorrected_error_arcsec, reduction.uncorrected_error_arcsec - _tilt_at_faces(reduction)
    rows = [
        ("psi, tilt", f"{tilt.psi_arcsec:.3f} arcsec", _u(tilt.u_psi_arcsec, "arcsec")),
        ("omega, azimuth from face 1 towards face 2", f"{tilt.omega_deg:.3f} deg", _u(tilt.u_omega_deg, "deg")),
        ("y less the model, standard deviation", f"{tilt.sigma_arcsec:.3f} arcsec", ""),
        ("tilt and roll in the errors, peak to peak", f"{np.ptp(before - after):.4f} arcsec", ""),
        ("errors peak to peak, x as read", f"{np.ptp(before):.3f} arcsec", ""),
        ("errors peak to peak, tilt and roll taken off", f"{np.ptp(after):.3f} arcsec", ""),
        ("in the curve", "taken off" if reduction.tilt_corrected else "left in", ""),
    ]
    if run.roll_arcmin is not None:
        rows.insert(2, ("roll of the autocollimator, stated", f"{run.roll_arcmin:g} arcmin", ""))
    tolerance = TiltTolerance.of_run(run.run)
    paragraphs = adjustment_sentences(tilt, screws, run.faces)
    if tolerance is not None:
        rows += _tolerance_rows(tolerance, tilt.psi_arcsec)
    else:
        met = [grade for grade in GRADES if tilt.psi_arcsec <= TiltTolerance.of_grade(grade).formula_arcsec]
        grades = f"grade {met[0]} and coarser" if met else "no grade of the table"
        paragraphs.append(
            f"By the formula this tilt, uncorrected, would do for {grades}; state encoder_grade or "
            "required_accuracy_arcsec to have it judged."
        )
    plots = (tilt_plot(reduction, screws),) if plot else ()
    return ReportSection("Tower tilt", tuple(paragraphs), ("quantity", "value", "u (k=1)"), tuple(rows), plots)


def _tolerance_rows(tolerance: TiltTolerance, psi_arcsec: float) -> list[tuple[str, str, str]]:
    what = f"+-{tolerance.accuracy_arcsec:g} arcsec"
    if tolerance.grade is not None:
        what = f"grade {tolerance.grade}, {what}"
    limits = [
        ("as published", tolerance.published_arcsec),
        ("by the formula", tolerance.formula_arcsec),
        ("at the worst azimuth", tolerance.strict_arcsec),
    ]
    return [
        (f"tolerance for {what}, {name}", f"{limit:.1f} arcsec", "met" if psi_arcsec <= limit else "exceeded")
        for name, limit in limits
        if limit is not None
    ]


def _tilt_at_faces(reduction: PolygonReduction) -> np.ndarray:
    """What tilt and roll add to the error at each face, float64[faces], 0 at the first."""
    series = reduction.run.series
    added = series.weight @ (reduction.run.sign * reduction.x_correction_arcsec)[series.reading_of_face]
    return added - added[0]


def _u(value: float, unit: str) -> str:
    return "no degrees of freedom" if math.isnan(value) else f"{value:.2g} {unit}"
