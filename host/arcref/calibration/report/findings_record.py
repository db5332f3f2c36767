"""The part of a calibration's record that is the same for every method: checks, budget, sections, provenance."""

import math

from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.uncertainty_budget import COVERAGE_FACTOR, UncertaintyBudget


def findings_record(result: CalibrationResult) -> dict:
    """What was found beside the table of errors, ready for JSON."""
    return {
        "method": list(result.method),
        "figures": [{"name": name, "value": value} for name, value in result.figures],
        "checks": [
            {"sentence": check.sentence, "found": check.found, "passed": check.passed} for check in result.checks
        ],
        "warnings": list(result.warnings),
        "budget": budget_record(result.budget),
        "results": result.results,
        "sections": [
            {
                "title": section.title,
                "paragraphs": list(section.paragraphs),
                "columns": list(section.columns),
                "rows": [list(row) for row in section.rows],
            }
            for section in result.sections
        ],
        "not_checked": list(result.not_checked),
        "provenance": result.provenance,
    }


def budget_record(budget: UncertaintyBudget) -> dict:
    """The budget, each contribution with its share of the combined variance."""
    combined = budget.combined_arcsec
    return {
        "contributions": [
            {
                "name": term.name,
                "type": term.type,
                "distribution": term.distribution,
                "u": float(term.u),
                "unit": term.unit,
                "sensitivity": float(term.sensitivity),
                "u_arcsec": float(term.u_arcsec),
                "share": (term.u_arcsec / combined) ** 2 if combined else 0.0,
                "degrees_of_freedom": finite(term.degrees_of_freedom),
                "basis": term.basis,
            }
            for term in budget.contributions
        ],
        "missing": [{"name": each.name, "metadata_key": each.metadata_key} for each in budget.missing],
        "combined_arcsec": combined,
        "coverage_factor": COVERAGE_FACTOR,
        "expanded_arcsec": budget.expanded_arcsec,
        "expanded_of_difference_arcsec": math.sqrt(2) * budget.expanded_arcsec,
        "effective_degrees_of_freedom": finite(budget.effective_degrees_of_freedom),
        "coverage_factor_95": budget.coverage_factor_95,
    }


def finite(value: float) -> float | None:
    """The number, None for one that JSON cannot hold."""
    return value if math.isfinite(value) else None
