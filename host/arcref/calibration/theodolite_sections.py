"""The sections of a report that belong to a limited-angle calibration: axis and mirror, elevations, the arc."""

import math

import numpy as np

from arcref.calibration.calibration_result import ReportSection
from arcref.calibration.theodolite_arc import LONGEST_ARC_DEG, arc_u_arcsec
from arcref.calibration.theodolite_budget import azimuth_noise, zenith_noise
from arcref.calibration.theodolite_findings import ArcFindings
from arcref.calibration.theodolite_plots import arc_length_plot, elevations_plot, tilt_effect_plot
from arcref.calibration.theodolite_solution import ARCSEC_PER_RAD

ARCS_SHOWN_DEG = (5, 10, 20, 30, 40, 60, 90, 120)


def arc_sections(found: ArcFindings, plots: bool = True) -> tuple[ReportSection, ...]:
    """The sections in the order of the report, with their plots unless nobody will look."""
    sections = [_axis_section(found, plots), _elevations_section(found, plots)]
    if azimuth_noise(found.run, found.solution).arcsec is not None:
        sections.append(_arc_section(found, plots))
    return tuple(sections)


def _axis_section(found: ArcFindings, plots: bool) -> ReportSection:
    geometry, u = found.solution.geometry, found.u_angles_deg * 3600.0
    covariance = found.angle_covariance_deg2
    size = np.sqrt(np.diag(covariance))

    def correlations(i: int) -> tuple[str, ...]:
        if not found.delta_is_known:
            return ("-",) * 3
        return tuple(f"{covariance[i, j] / (size[i] * size[j]):+.3f}" for j in range(3))

    delta = (f"{geometry.delta_deg:.5f}", f"{2 * u[1]:.2f}") if found.delta_is_known else ("not defined", "-")
    rows = (
        ("alpha, axis to the mirror's upright", f"{geometry.alpha_deg:.5f}", f"{2 * u[0]:.2f}", *correlations(0)),
        ("delta, azimuth of the axis", *delta, *correlations(1)),
        ("omega, elevation of the normal", f"{geometry.omega_deg:.5f}", f"{2 * u[2]:.2f}", *correlations(2)),
    )
    columns = ("angle", "deg", "U (k=2) / arcsec", "correlation: alpha", "delta", "omega")
    twins = ", ".join(
        f"({twin.alpha_deg:.4f}, {twin.delta_deg:.4f})" for twin in geometry.twins()[1:] if np.isfinite(twin.alpha_deg)
    )
    paragraphs = (
        "Delta is counted counter-clockwise seen from above, as the printed equations of the method have it (its text "
        "says clockwise). The angles are poorly separated from each other; the corrected angle is not, because what "
        "one of them lacks another makes up for.",
        f"Three more axes give the very same elevations, (alpha, delta) in deg: {twins}. Their azimuths would be quite "
        "others; none is as upright as this one.",
        f"Not corrected, reading and azimuth would differ by {np.ptp(found.uncorrected_arcsec):.4g} arcsec over the "
        "arc.",
    )
    curve = found.curve
    drawn = (tilt_effect_plot(curve.angle_deg, found.uncorrected_arcsec, curve.error_arcsec, curve.u_arcsec),)
    return ReportSection("Axis and mirror", paragraphs, columns, rows, drawn if plots else ())


def _elevations_section(found: ArcFindings, plots: bool) -> ReportSection:
    run, solution = found.run, found.solution
    residual = ARCSEC_PER_RAD * solution.elevation_residual_rad
    worst = np.argsort(-np.abs(found.studentized_elevation), kind="stable")[:5]
    rows = tuple(
        (
            f"row {run.run.rows[index]} ({run.reading_deg[index]:g} deg)",
            f"{residual[index]:+.3f}",
            f"{found.studentized_elevation[index]:+.2f}",
            "outlier" if index in found.outliers else "",
        )
        for index in worst
    )
    text = (
        f"{len(residual)} elevations for 3 parameters; standard deviation of one about the fit "
        f"{float(solution.elevation_sigma_arcsec):.3f} arcsec. The table has those that fit worst. Nothing was left "
        "out. In closed form, without iteration, the angles found would differ by "
        f"{found.closed_form_difference_arcsec:.4f} arcsec at most."
    )
    outlier = np.zeros(len(residual), bool)
    outlier[found.outliers] = True
    elevation = np.degrees(solution.readings.elevation_rad)
    fitted = np.degrees(solution.geometry.elevation_rad(solution.theta_rad))
    drawn = (elevations_plot(run.reading_deg, elevation, fitted, residual, outlier),) if plots else ()
    columns = ("reading", "residual / arcsec", "in standard deviations", "")
    return ReportSection("Elevations of the mirror", (text,), columns, rows, drawn)


def _arc_section(found: ArcFindings, plots: bool) -> ReportSection:
    run, solution = found.run, found.solution
    start = math.degrees(float(solution.theta_rad.min()))
    places = min(solution.readings.places, 200)
    noise = (zenith_noise(run, solution).arcsec, azimuth_noise(run, solution).arcsec, run.rounds)

    def expanded(arc_deg: float) -> float:
        return 2 * float(arc_u_arcsec(solution.geometry, start, arc_deg, places, *noise).max())

    rows = tuple((f"{arc:g}", f"{expanded(arc):.3g}") for arc in ARCS_SHOWN_DEG)
    text = (
        "A short arc does not tell axis and mirror well enough. The table is for arcs that begin where this one does, "
        "with as many places and the same readings: expanded uncertainty of the error at the worst place, of the "
        "readings' scatter alone."
    )
    drawn = ()
    if plots:
        arcs = np.geomspace(min(4.0, run.arc_deg), min(LONGEST_ARC_DEG, max(120.0, run.arc_deg)), 25)
        drawn = (arc_length_plot(arcs, [expanded(arc) for arc in arcs], run.arc_deg, expanded(run.arc_deg)),)
    return ReportSection("Length of the arc", (text,), ("arc / deg", "U (k=2) / arcsec"), rows, drawn)
