"""How closure and theodolite calibrations fit their curve, and what they say of the fit in results and report."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from arcref.calibration.calibration_result import ReportSection
from arcref.calibration.fit_comparison import compare_fits
from arcref.calibration.fit_sections import aliasing_section, comparison_section, fit_section
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.fits.fit_names import DEFAULT_FIT
from arcref.error_curve import ErrorCurve
from arcref.input_file import read_input_file
from arcref.rom_command import read_curve


@dataclass(frozen=True)
class FitOptions:
    """`fit`: name of the curve through the errors; `compare`: fit by its rivals as well; `second`: a run to verify the
    fit with; `plots`: whether the report will be drawn.
    """

    fit: str = DEFAULT_FIT
    compare: bool = False
    second: ErrorCurve | None = None
    plots: bool = False


USUAL_FIT = FitOptions()
"""The default fit, without rivals."""


def fit_report(fitted: FittedCurve, options: FitOptions, reading_deg=None) -> tuple[dict, tuple[ReportSection, ...]]:
    """Numbers for `results` and sections for the report; `reading_deg` as in `aliases`."""
    results = {"fit": {"name": fitted.name, "parameters": fitted.parameters}}
    sections = [fit_section(fitted, options.plots), aliasing_section(fitted, reading_deg)]
    if options.compare or options.second is not None:
        comparison = compare_fits(fitted, options.second)
        results["comparison"] = comparison.to_json()
        sections.append(comparison_section(comparison, options.plots))
    return results, tuple(sections)


def second_curve(path: Path | None, column: str, calibrated: Callable[[Path], ErrorCurve]) -> ErrorCurve | None:
    """The curve of a second run: one with `column`, which `calibrated` reduces, a reduced curve, or a calibration."""
    if path is None:
        return None
    if path.suffix.lower() != ".json" and column in read_input_file(path).text():
        return calibrated(path)
    return read_curve(path)
