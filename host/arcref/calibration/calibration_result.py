"""What every calibration method ends in: the error curve, the method's numbers, and all that the report shows."""

from dataclasses import dataclass, field

from arcref.calibration.uncertainty_budget import UncertaintyBudget
from arcref.error_curve import ErrorCurve
from arcref.run_file import RunFile


@dataclass(frozen=True)
class Check:
    """One demand on the run: a sentence, what was found, and whether the demand was met."""

    sentence: str
    found: str
    passed: bool


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


@dataclass(frozen=True)
class CalibrationResult:
    """The outcome of one calibration.

    `kind`: "polygon", "closure" or "theodolite"; `curve`: errors with their standard uncertainty (k=1);
    `results`: the method's numbers, ready for JSON, as DESIGN names them; `method`: paragraphs on how it was done;
    `figures`: (name, value) pairs of the short table on the terminal and at the page's top;
    `not_checked`: plain sentences on what this method cannot see; `run`: the file it came from.
    """

    kind: str
    run: RunFile
    curve: ErrorCurve
    results: dict
    budget: UncertaintyBudget
    method: tuple[str, ...]
    figures: tuple[tuple[str, str], ...]
    checks: tuple[Check, ...] = ()
    warnings: tuple[str, ...] = ()
    sections: tuple[ReportSection, ...] = ()
    not_checked: tuple[str, ...] = ()
    provenance: dict = field(default_factory=dict)

    @property
    def passed(self) -> bool:
        """True when every check was passed."""
        return all(check.passed for check in self.checks)
