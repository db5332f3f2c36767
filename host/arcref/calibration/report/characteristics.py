"""The characteristics that JJF 1115-2004 names for photoelectric shaft encoders, each with how it was computed here.

JJF 1115-2004, Calibration Specification for Photoelectric Shaft Encoders, section 5: division error, repeatability of
angle, zero error, return error. The specification leaves room for how many rounds are read; what was done stands beside
each number.
"""

from dataclasses import dataclass

import numpy as np

from arcref.calibration.calibration_result import CalibrationResult, SeriesErrors


@dataclass(frozen=True)
class Characteristic:
    """One characteristic in arcsec, None when the run cannot give it; `how` it was computed, or what it would need."""

    key: str
    name: str
    value_arcsec: float | None
    how: str


def characteristics(result: CalibrationResult) -> tuple[Characteristic, ...]:
    """The four characteristics of the encoder as measured, before any correction."""
    return (_division(result), _repeatability(result), _zero(result.series), _return(result.series))


def _division(result: CalibrationResult) -> Characteristic:
    error = result.curve.error_arcsec
    mean = "mean of the series" if result.series is not None and len(result.series.direction) > 1 else "error"
    how = f"half of highest less lowest {mean} over {error.size} angles; stands either way of the middle"
    return Characteristic("division_error", "division error", float(np.ptp(error)) / 2, how)


def _repeatability(result: CalibrationResult) -> Characteristic:
    key, name = "repeatability", "repeatability"
    terms = [term for term in result.budget.contributions if term.name == "repeatability" and term.type == "A"]
    if not terms:
        return Characteristic(key, name, None, "needs two rounds in one direction or more")
    how = f"standard deviation of one reading: {terms[0].basis}"
    if result.kind == "polygon":
        how = (
            "standard deviation of one reading at one angle, pooled over the angles, of the rounds in one direction; "
            f"the mean of each round left out; {terms[0].degrees_of_freedom:g} degrees of freedom"
        )
    return Characteristic(key, name, terms[0].u, how)


def _zero(series: SeriesErrors | None) -> Characteristic:
    key, name = "zero_error", "zero error"
    closing = np.array([]) if series is None or series.closing_error_arcsec is None else series.closing_error_arcsec
    closed = np.flatnonzero(np.isfinite(closing))
    if not closed.size:
        return Characteristic(key, name, None, "needs the first angle read again after a turn")
    ways = {series.direction[index] for index in closed}
    from_where = "from both directions" if len(ways) > 1 else "from one direction only"
    often = "once" if closed.size == 1 else f"{closed.size} times"
    how = (
        f"largest change of the first angle's error when the encoder came back to it, {often}, {from_where}; drift "
        "of the set-up is in it"
    )
    return Characteristic(key, name, float(np.abs(closing[closed]).max()), how)


def _return(series: SeriesErrors | None) -> Characteristic:
    key, name = "return_error", "return error"
    if series is None or series.return_error_arcsec is None:
        return Characteristic(key, name, None, "needs rounds in both directions")
    how = "largest difference, at one angle, of the mean forward from the mean backward error; drift is in it"
    return Characteristic(key, name, float(np.abs(series.return_error_arcsec).max()), how)
