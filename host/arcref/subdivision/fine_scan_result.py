"""`arcref calibrate subdivision` for a fine scan: the scan's reduction, budget and report."""

import math

from arcref.angle import ARCSEC_PER_COUNT, LINES_PER_TURN
from arcref.calibration.calibration_result import CalibrationResult, ReportSection
from arcref.calibration.stated_values import stated_standard_uncertainty
from arcref.calibration.uncertainty_budget import Contribution, MissingInput, UncertaintyBudget
from arcref.run_file import RunFile
from arcref.subdivision.count_plots import line_error_plot
from arcref.subdivision.count_result import count_result, mean_u_arcsec, slope_arcsec_per_deg, wave_curve
from arcref.subdivision.fine_scan import LINES_FOR_A_BEND, FineScanWave, fine_scan
from arcref.subdivision.fine_scan_run import fine_scan_readings
from arcref.subdivision.samples_budget import table_contributions
from arcref.subdivision.subdivision_run import SubdivisionOptions

AUTOCOLLIMATOR = "autocollimator"
U_KEY, EXPANDED_KEY = "u_autocollimator_arcsec", "expanded_autocollimator_arcsec"


def fine_scan_result(run: RunFile, options: SubdivisionOptions) -> CalibrationResult:
    """The calibration. Raises `InputError` as `fine_scan_readings` does."""
    scan = fine_scan_readings(run)
    found = fine_scan(scan)
    budget = _budget(run, found)
    curve = wave_curve(
        found.wave, math.hypot(*(each.u_arcsec for each in budget.contributions if each.name == AUTOCOLLIMATOR))
    )
    passages = int(scan.passage[-1]) + 1
    figures = [
        ("readings", f"{scan.count.size} over {scan.lines:.2f} lines" + (f" in {passages} passages" * (passages > 1))),
        ("sign of x", f"{scan.sign:+d}, {scan.sign_basis}"),
        ("scale of x", f"{100 * found.scale_error:+.3f} % against the counts, taken off"),
        ("scatter", f"{found.noise_arcsec:.3f} arcsec a reading, {found.degrees_of_freedom} degrees of freedom"),
    ]
    sections = []
    if options.plots:
        plot = line_error_plot(curve, scan.phase_rad, found.error_arcsec, "fine-scan")
        sections.append(ReportSection("Error within a line", plots=(plot,)))
    warnings = []
    if scan.lines < LINES_FOR_A_BEND:
        warnings.append(
            f"The scan spans {scan.lines:.2f} lines: drift of the autocollimator is told from the error's first order "
            f"only as far as it is straight. Scan {LINES_FOR_A_BEND:g} lines or more."
        )
    return count_result(
        run,
        found.wave,
        curve,
        budget,
        method={"name": "fine scan", "orders": found.wave.orders, "autocollimator_sign": scan.sign},
        paragraphs=(
            "The shaft was moved in small steps while an autocollimator watched one face. Count plus x is then the "
            "encoder's error, up to a constant, and what repeats with the grating line is the error within it.",
            f"Each passage has {'a straight' if found.drift_degree == 1 else 'a bent'} drift of its own, which takes "
            "up the autocollimator's drift and scale and the error over the turn; the error is a sum of "
            f"{found.wave.orders} orders. Both come from one least squares solution.",
        ),
        figures=figures,
        results={
            "noise_arcsec": found.noise_arcsec,
            "degrees_of_freedom": found.degrees_of_freedom,
            "lines": scan.lines,
            "autocollimator_sign": scan.sign,
            "scale_error": found.scale_error,
        },
        warnings=warnings,
        sections=sections,
        not_checked=(
            "An error of the autocollimator that repeats every 316.4 arcsec of x, as the lines do, looks the same.",
            f"The other lines of {LINES_PER_TURN}: the curve is that of the few scanned.",
        ),
    )


def _budget(run: RunFile, found: FineScanWave) -> UncertaintyBudget:
    scatter = Contribution(
        "scatter of the readings",
        "A",
        "normal",
        mean_u_arcsec(found.wave),
        "arcsec",
        1.0,
        f"{found.noise_arcsec:.3f} arcsec a reading, a count's rounding ({ARCSEC_PER_COUNT:.3f} arcsec wide) in it",
        found.degrees_of_freedom,
    )
    u = stated_standard_uncertainty(run, U_KEY, EXPANDED_KEY)
    measured = (scatter, *table_contributions(slope_arcsec_per_deg(found.wave)))
    if u is None:
        return UncertaintyBudget(measured, (MissingInput(AUTOCOLLIMATOR, U_KEY),))
    stated = Contribution(AUTOCOLLIMATOR, "B", "normal", u, "arcsec", 1.0, "as stated by the run file")
    return UncertaintyBudget((*measured, stated))
