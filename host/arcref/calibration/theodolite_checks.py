"""What is refused of a solved theodolite run, what is checked, warned of, and not checked."""

import math

import numpy as np
from scipy.stats import chi2

from arcref.calibration.closure_solution import FALSE_ALARM
from arcref.calibration.theodolite_arc import shortest_arc_deg
from arcref.calibration.theodolite_budget import azimuth_noise, zenith_noise
from arcref.calibration.theodolite_findings import ArcFindings
from arcref.calibration.theodolite_model import LARGEST_ALPHA_DEG
from arcref.calibration.theodolite_run import ZENITH, TheodoliteRun
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD, ArcSolution
from arcref.check import Check
from arcref.input_error import InputError

OUTLIERS_NAMED = 5

# A mirror and a theodolite that fit worse than this do not see one shaft turning about one axis.
_LARGEST_SCATTER_ARCSEC = 60.0

# An azimuth this far off what its neighbours say, and this many times the usual step, is worth a look.
_SPIKE_ARCSEC, _SPIKE_FACTOR = 10.0, 8.0


def refuse_short_arc(run: TheodoliteRun, solution: ArcSolution, covariance_arcsec2, required_arcsec: float) -> None:
    """Raises `InputError` when the errors are less certain than required, with the arc that would do."""
    azimuth, zenith = azimuth_noise(run, solution), zenith_noise(run, solution)
    if azimuth.arcsec is None or covariance_arcsec2 is None:
        problem = (
            f"an expanded uncertainty of {required_arcsec:g} arcsec was asked, but nothing tells that of an azimuth: "
            "state it as '# u_azimuth_arcsec: ...', or read a second round"
        )
        raise InputError.at(run.run.path, problem)
    u = np.sqrt(np.diag(covariance_arcsec2))
    if 2 * u.max() <= required_arcsec:
        return
    sentence = (
        f"an arc of {run.arc_deg:.4g} deg gives the error with an expanded uncertainty of {2 * u.max():.3g} arcsec "
        f"(k=2) at its worst place, {required_arcsec:g} arcsec was asked"
    )
    start = math.degrees(float(solution.theta_rad.min()))
    noise = (zenith.arcsec, azimuth.arcsec, run.rounds)
    other = max(0.0, u.max() ** 2 - np.diag(_scatter(solution, *noise[:2])).max())
    left = (required_arcsec / 2) ** 2 - other
    arc = None
    if left > 0:
        arc = shortest_arc_deg(math.sqrt(left), solution.geometry, start, solution.readings.places, *noise)
    if arc is not None and arc > run.arc_deg:
        sentence += f": with as many readings an arc of {math.ceil(arc)} deg would do"
    else:
        sentence += f": no arc would do, the {azimuth.arcsec:g} arcsec of an azimuth reading are too much; read rounds"
    raise InputError.at(run.run.path, sentence)


def _scatter(solution: ArcSolution, u_zenith: float, u_azimuth: float) -> np.ndarray:
    return solution.sensitivity().error_covariance(u_zenith, u_azimuth)


def refuse_misfit(run: TheodoliteRun, solution: ArcSolution) -> None:
    """Raises `InputError` when no shaft turning about one axis gives these elevations."""
    geometry = solution.geometry
    if not np.isfinite(geometry.parameters).all() or not np.isfinite(solution.theta_rad).all():
        problem = "the elevations fit no axis: is each zenith angle that of its own reading?"
        raise run.run.error(problem, reading=0, column=ZENITH)
    if geometry.alpha_deg >= LARGEST_ALPHA_DEG:
        problem = (
            f"the elevations fit an axis {geometry.alpha_deg:.4g} deg off the mirror's upright; less than "
            f"{LARGEST_ALPHA_DEG:g} deg was expected, for beyond it four axes cannot be told apart"
        )
        raise run.run.error(problem, reading=0, column=ZENITH)
    residual = ARCSEC_PER_RAD * solution.elevation_residual_rad
    if float(solution.elevation_sigma_arcsec) > _LARGEST_SCATTER_ARCSEC:
        worst = int(np.argmax(np.abs(residual)))
        problem = (
            f"{run.zenith_deg[worst]:g} deg is {residual[worst]:+.4g} arcsec off the best axis, which leaves "
            f"{float(solution.elevation_sigma_arcsec):.4g} arcsec to all readings: no shaft turns like that"
        )
        raise run.run.error(problem, reading=worst, column=ZENITH)


def arc_checks(found: ArcFindings, required_arcsec: float | None) -> tuple[Check, ...]:
    """The demands on a run."""
    run, solution, checks = found.run, found.solution, []
    residual = ARCSEC_PER_RAD * solution.elevation_residual_rad
    named = "; ".join(
        f"row {run.run.rows[index]} ({run.reading_deg[index]:g} deg): {residual[index]:+.2f} arcsec, "
        f"{abs(found.studentized_elevation[index]):.1f} standard deviations of the others"
        for index in found.outliers[:OUTLIERS_NAMED]
    )
    largest = f"largest {np.abs(found.studentized_elevation).max():.1f} standard deviations"
    checks.append(Check("No zenith reading stands out from all others.", named or largest, not found.outliers))
    freedom = len(run.place) - 3
    for what, stated, sigma, free in (
        ("elevations about the axis", run.u_zenith_arcsec, solution.elevation_sigma_arcsec, freedom),
        ("azimuths between the rounds", run.u_azimuth_arcsec, solution.azimuth_sigma_arcsec, solution.azimuth_freedom),
    ):
        if stated is None or free < 1:
            continue
        limit = stated * math.sqrt(chi2.isf(FALSE_ALARM, free) / free)
        sentence = f"The {what} scatter no more than the stated {stated:g} arcsec explain."
        passed = bool(sigma <= limit + 1e-6)
        checks.append(Check(sentence, f"{float(sigma):.3f} arcsec, limit {limit:.3f}", passed))
    if required_arcsec is not None:
        sentence = f"The error is known to {required_arcsec:g} arcsec (k=2) everywhere on the arc."
        checks.append(Check(sentence, f"{2 * found.curve.u_arcsec.max():.3f} arcsec at the worst place", True))
    return tuple(checks)


def arc_warnings(found: ArcFindings) -> tuple[str, ...]:
    """What a reader should mind."""
    run, warnings = found.run, []
    azimuth = azimuth_noise(run, found.solution)
    part = found.parameter_u_arcsec.max()
    if azimuth.arcsec is None:
        warnings.append(
            "Nothing tells how well an azimuth repeats, so the curve has no uncertainty; axis and mirror alone bring "
            f"{part:.3g} arcsec."
        )
    elif part > azimuth.arcsec:
        warnings.append(
            f"The arc of {run.arc_deg:.4g} deg is too short to tell axis and mirror well: they bring {part:.3g} "
            f"arcsec, an azimuth reading {azimuth.arcsec:.3g} arcsec. A longer arc is worth more than more readings."
        )
    if not found.delta_is_known:
        warnings.append(
            "The axis stands so upright that its direction delta is not defined; the corrected angle does not need it."
        )
    error, angle = found.curve.error_arcsec, found.curve.angle_deg
    off = error[1:-1] - (error[:-2] + error[2:]) / 2
    worst = int(np.argmax(np.abs(off)))
    if abs(off[worst]) > max(_SPIKE_ARCSEC, _SPIKE_FACTOR * float(np.median(np.abs(off)))):
        row = run.run.rows[int(np.flatnonzero(run.place == worst + 1)[0])]
        warnings.append(
            f"The error at {angle[worst + 1]:g} deg is {off[worst]:+.3g} arcsec off its neighbours: is the azimuth in "
            f"row {row} a slip?"
        )
    return tuple(warnings)


def arc_not_checked(run: TheodoliteRun) -> tuple[str, ...]:
    """What the method cannot see."""
    sentences = (
        "The azimuth circle of the theodolite: its own division error is in the encoder's curve.",
        "The walk of the beam over the mirror as it turns, unless it is stated.",
        "Movement of the theodolite or of the encoder's base during the run: azimuths take it for the encoder's.",
        "Which way zenith angles are counted: the other way gives another axis and mirror, and the same errors.",
        "The error within a grating line, unless places fall at many phases of it.",
    )
    outside = "The encoder outside the arc: nothing was read there, and nothing will be corrected."
    return sentences if run.goes_around else (outside, *sentences)
