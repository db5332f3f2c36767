"""From the error within a line that counts gave to the calibration: what edge timing and fine scan share."""

import numpy as np

from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult, ReportSection
from arcref.calibration.uncertainty_budget import UncertaintyBudget
from arcref.run_file import RunFile
from arcref.subdivision.line_wave import LineWave, cell_middles_deg
from arcref.subdivision_curve import SubdivisionCurve


def wave_curve(wave: LineWave, other_u_arcsec: float = 0.0) -> SubdivisionCurve:
    """The wave at the middles of the table's 512 cells; `other_u_arcsec` is added to its own uncertainty (squares)."""
    phases = np.radians(cell_middles_deg())
    u = np.hypot(wave.u_arcsec(phases), other_u_arcsec)
    return SubdivisionCurve(cell_middles_deg(), wave.error_arcsec(phases), {}, u)


def slope_arcsec_per_deg(wave: LineWave) -> float:
    """Slope of the error, rms over the line, for each degree of the line."""
    power = np.sum((np.arange(1, wave.orders + 1) * wave.amplitude_arcsec) ** 2) / 2
    return float(np.radians(np.sqrt(power)))


def mean_u_arcsec(wave: LineWave) -> float:
    """Root mean square over the line of the wave's own uncertainty."""
    return float(np.sqrt(np.mean(wave.u_arcsec(np.radians(cell_middles_deg())) ** 2)))


def count_result(
    run: RunFile,
    wave: LineWave,
    curve: SubdivisionCurve,
    budget: UncertaintyBudget,
    *,
    method: dict,
    paragraphs: tuple[str, ...],
    figures: list[tuple[str, str]],
    results: dict,
    warnings: list[str],
    sections: list[ReportSection],
    not_checked: tuple[str, ...],
) -> CalibrationResult:
    """The calibration; figures, results, warnings and sections of the wave itself are added here."""
    largest = int(np.argmax(wave.amplitude_arcsec))
    peak_to_peak = float(np.ptp(curve.error_arcsec))
    figures = [
        *figures,
        (
            "error within a line",
            f"{peak_to_peak:.3f} arcsec peak to peak, {np.sqrt(np.mean(curve.error_arcsec**2)):.3f} rms",
        ),
        ("largest order", f"{largest + 1} a line, amplitude {wave.amplitude_arcsec[largest]:.3f} arcsec"),
        ("expanded uncertainty", f"{budget.expanded_arcsec:.3f} arcsec (k=2) of an angle corrected within the line"),
    ]
    if peak_to_peak < 4 * float(np.sqrt(np.mean(curve.u_arcsec**2))):
        text = "The error found is no larger than its expanded uncertainty: a table of it would correct nothing."
        warnings = [*warnings, text]
    u = np.sqrt(np.maximum(np.diag(wave.covariance_arcsec2), 0)).reshape(2, -1)
    orders = [
        {
            "order": order + 1,
            "amplitude_arcsec": float(wave.amplitude_arcsec[order]),
            "u_amplitude_arcsec": float(np.sqrt(np.mean(u[:, order] ** 2))),
            "phase_deg": float(wave.phase_of_order_deg[order]),
        }
        for order in range(wave.orders)
    ]
    table = ReportSection(
        "Orders within a line",
        (
            "The error is the sum of amplitude times sin(order x phase of the reading + phase). Offsets of the signals "
            "make order 1, unequal amplitudes and quadrature order 2, third harmonics orders 2 and 4.",
        ),
        ("waves a line", "amplitude / arcsec", "u / arcsec", "phase / deg"),
        tuple(
            (
                str(each["order"]),
                f"{each['amplitude_arcsec']:.4f}",
                f"{each['u_amplitude_arcsec']:.4f}",
                f"{each['phase_deg']:+.1f}",
            )
            for each in orders
        ),
    )
    results = {
        "peak_to_peak_arcsec": peak_to_peak,
        "orders": orders,
        "expanded_uncertainty_arcsec": budget.expanded_arcsec,
    } | results
    return CalibrationResult(
        kind="subdivision",
        run=run,
        curve=curve,
        results=results,
        budget=budget,
        method=paragraphs,
        figures=tuple(figures),
        warnings=tuple(warnings),
        sections=(*sections, table),
        not_checked=not_checked,
        provenance=calibration_provenance(method, run),
    )
