"""What every calibration method ends in: the error curve, the method's numbers, and all that the report shows."""

from dataclasses import dataclass, field

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.uncertainty_budget import UncertaintyBudget
from arcref.check import Check
from arcref.error_curve import ErrorCurve
from arcref.run_file import RunFile
from arcref.subdivision_curve import SubdivisionCurve


@dataclass(frozen=True)
class ReportSection:
    """A section that belongs to one method: paragraphs, an optional table and plots as SVG text.

    `rows`: cells as text, one tuple a row, as many as `columns`; `plots`: SVG documents.
    """

    title: str
    paragraphs: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    plots: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class SeriesErrors:
    """The errors of each series (one passage over the angles in one direction), before they were averaged.

    `angle_deg`: float64[n], those of the error curve; `error_arcsec`: float64[series, n], NaN where a reading is
    missing; `direction`: +1 forward or -1 backward, one for each series; `closing_error_arcsec`: float64[series], first
    angle read again at the end minus its first reading, NaN where it was not read again, or None;
    `return_error_arcsec`: float64[n], forward minus backward at each angle, or None when one direction alone was read.
    """

    angle_deg: np.ndarray
    error_arcsec: np.ndarray
    direction: tuple[int, ...]
    closing_error_arcsec: np.ndarray | None = None
    return_error_arcsec: np.ndarray | None = None


@dataclass(frozen=True)
class CalibrationResult:
    """The outcome of one calibration.

    `kind`: "polygon", "closure", "theodolite" or "subdivision"; `curve`: errors with their standard uncertainty (k=1),
    over the turn, or of kind subdivision over a grating line;
    `results`: the method's numbers, ready for JSON, as DESIGN names them; `method`: paragraphs on how it was done;
    `figures`: (name, value) pairs of the short table on the terminal and at the page's top;
    `not_checked`: plain sentences on what this method cannot see; `run`: the file it came from; `fitted`: the curve
    through the errors that a ROM would take, None when none was chosen; `series`: the errors before averaging, None
    when the method has none.
    """

    kind: str
    run: RunFile
    curve: ErrorCurve | SubdivisionCurve
    results: dict
    budget: UncertaintyBudget
    method: tuple[str, ...]
    figures: tuple[tuple[str, str], ...]
    checks: tuple[Check, ...] = ()
    warnings: tuple[str, ...] = ()
    sections: tuple[ReportSection, ...] = ()
    not_checked: tuple[str, ...] = ()
    provenance: dict = field(default_factory=dict)
    fitted: FittedCurve | None = None
    series: SeriesErrors | None = None

    @property
    def passed(self) -> bool:
        """True when every check was passed."""
        return all(check.passed for check in self.checks)
