"""What a polygon run must meet, what its user should mind, and what it cannot show."""

import math

import numpy as np

from arcref.calibration.polygon_mistakes import outliers
from arcref.calibration.polygon_reduction import PolygonReduction, series_residual
from arcref.calibration.polygon_run import PolygonRun
from arcref.calibration.stated_values import stated_number
from arcref.calibration.tilt_tolerance import TiltTolerance
from arcref.check import Check
from arcref.error_curve import CLOSURE_TOLERANCE_ARCSEC

SCATTER_FACTOR = 4.0
"""A closing error this many times its own scatter is no scatter any more."""

SMALLEST_CERTIFICATE_ARCSEC = 0.1
"""Deviations all below this are no polygon's: their certificate's unit may have been mistaken."""


SCATTER_UNKNOWN = "the limit when neither rounds nor u_repeatability_arcsec tell how readings scatter"
"""Basis of the closing limit of a single round."""

SMALLEST_Y_SCATTER = 1 / 20
"""Scatter of y over that of x. Both are read by one eye or one detector: far less looks like another unit."""


def closing_limit(reduction: PolygonReduction) -> tuple[float, str]:
    """The limit of the closing error in arcsec, and where it comes from."""
    run = reduction.run
    if run.closing_limit_arcsec is not None:
        return run.closing_limit_arcsec, "stated in the run file"
    scatter = float(reduction.repeatability_arcsec)
    if not math.isfinite(scatter):
        scatter = stated_number(run.run, "u_repeatability_arcsec") or 0.0
    by_scatter = SCATTER_FACTOR * math.sqrt(2) * scatter
    if by_scatter > CLOSURE_TOLERANCE_ARCSEC:
        return by_scatter, f"{SCATTER_FACTOR:g} times the scatter of a difference of two readings"
    if not scatter:
        return CLOSURE_TOLERANCE_ARCSEC, SCATTER_UNKNOWN
    return CLOSURE_TOLERANCE_ARCSEC, "the limit when none is stated and the readings scatter less"


def polygon_checks(reduction: PolygonReduction) -> list[Check]:
    """The demands on the run: every round closes; the tilt is within its tolerance where it was not corrected."""
    checks = []
    closing = np.abs(reduction.closing_error_arcsec)
    closed = np.flatnonzero(np.isfinite(closing))
    if closed.size:
        limit, basis = closing_limit(reduction)
        worst = int(closed[np.argmax(closing[closed])])
        over = int((closing[closed] > limit).sum())
        found = f"{closing[worst]:.3f} arcsec at most, in {series_name(reduction.run, worst)}"
        if over:
            found += f"; {over} of {closed.size} beyond the limit: the set-up moved or drifted, read these again"
            if basis == SCATTER_UNKNOWN:
                found += ", or state u_repeatability_arcsec if readings are known to scatter so much"
        sentence = f"each round closes within {limit:.3g} arcsec ({basis})"
        checks.append(Check(sentence, found, not over))
    tolerance = TiltTolerance.of_run(reduction.run.run)
    if tolerance is not None and reduction.tilt is not None and not reduction.tilt_corrected:
        psi = reduction.tilt.psi_arcsec
        sentence = f"the tower tilt, left uncorrected, is within {tolerance.formula_arcsec:.1f} arcsec"
        checks.append(Check(sentence, f"{psi:.1f} arcsec", psi <= tolerance.formula_arcsec))
    return checks


def polygon_warnings(reduction: PolygonReduction) -> list[str]:
    """What the user should mind, one sentence each."""
    run, warnings = reduction.run, []
    if run.sign_basis.startswith("assumed"):
        warnings.append(
            "The sign of x was assumed to be +1, x growing as the face turns towards face 2's side; state "
            "autocollimator_sign. With the wrong sign every error has the wrong sign."
        )
    elif "against" in run.sign_basis:
        warnings.append(f"The sign of x is {run.sign:+d} {run.sign_basis}.")
    deviation = run.face_deviation_arcsec
    if deviation is None:
        warnings.append("No face deviations: the polygon's own errors stand in the curve as the encoder's.")
    elif 0 < np.abs(deviation).max() < SMALLEST_CERTIFICATE_ARCSEC:
        warnings.append(
            f"All face deviations are below {SMALLEST_CERTIFICATE_ARCSEC:g} arcsec, smaller than polygons are made; "
            "were they copied in another unit?"
        )
    if len(set(run.series.direction)) == 2 and len(set(run.series.weight)) == 2:
        warnings.append("Unlike numbers of rounds forward and backward: each direction counts half in the mean.")
    if reduction.tilt is not None and not reduction.tilt_corrected:
        warnings.append("Tower tilt and roll were left in x, as asked for.")
    if reduction.tilt is None and run.roll_arcmin:
        warnings.append("A roll is stated, but without y readings it cannot be taken off x.")
    tolerance = TiltTolerance.of_run(run.run)
    if tolerance is not None and reduction.tilt_corrected and reduction.tilt.psi_arcsec > tolerance.formula_arcsec:
        warnings.append(
            f"The tower tilt of {reduction.tilt.psi_arcsec:.1f} arcsec is beyond the tolerance of "
            f"{tolerance.formula_arcsec:.1f} arcsec; it was corrected, but a smaller one is better."
        )
    y_scatter = _scatter_of_y_arcsec(run)
    if 0 < y_scatter < SMALLEST_Y_SCATTER * reduction.repeatability_arcsec:
        warnings.append(
            f"From round to round y scatters {y_scatter:.2g} arcsec and x {reduction.repeatability_arcsec:.2g} arcsec: "
            "was y written in minutes of arc? The tower tilt would then be 60 times as large."
        )
    for reading, off_arcsec, chance in outliers(run):
        warnings.append(
            f"Row {run.run.rows[reading]} stands {off_arcsec:+.2f} arcsec off the other rounds at its face (chance "
            f"{chance:.1g}); it was kept. Read it again, or take out the round."
        )
    return warnings


def _scatter_of_y_arcsec(run: PolygonRun) -> float:
    """Standard deviation of one y reading from the rounds; 0 when there is nothing to tell it from."""
    if run.y_arcsec is None:
        return 0.0
    residual, freedom = series_residual(run.y_arcsec[run.series.reading_of_face], run.series.direction)
    return float(np.sqrt((residual**2).sum() / freedom)) if freedom else 0.0


def polygon_not_checked(reduction: PolygonReduction) -> list[str]:
    """Plain sentences on what this run cannot show."""
    run = reduction.run
    directions = set(run.series.direction)
    sentences = [
        "Angles between the faces: the curve there is the fit's.",
        "Errors within a grating line: the faces see each line at one place only.",
        "The encoder at speed: readings were taken at rest, so the interpolator's delay is not in them.",
    ]
    if run.face_deviation_arcsec is None:
        sentences.append("Which part of the errors is the polygon's: that needs its certificate, or a closure run.")
    if len(run.series.direction) == len(directions):
        sentences.append("Repeatability: that needs a second round in the same direction.")
    if len(directions) == 1:
        sentences.append("The return error: that needs rounds in both directions.")
    if not np.isfinite(reduction.closing_error_arcsec).any():
        sentences.append("Drift: no round was closed by reading its first face again.")
    if reduction.tilt is None:
        sentences.append("Tower tilt: that needs the autocollimator's y readings.")
    else:
        if run.roll_arcmin is None:
            sentences.append(
                "The autocollimator's roll: it puts a part of y into x that looks like eccentricity, and it cannot "
                "be told from the readings; at 300 arcsec of tilt each minute of roll costs 0.087 arcsec."
            )
        if "autocollimator_y_sign" not in run.run.metadata:
            sentences.append(
                "The sign of y, taken as growing while the face looks up. It does not change the corrected errors, "
                "but with the other sign the screws must be turned the other way."
            )
    return sentences


def series_name(run: PolygonRun, series: int) -> str:
    """A series as people call it."""
    way = "forward" if run.series.direction[series] > 0 else "backward"
    return f"round {run.series.round[series]} {way}"
