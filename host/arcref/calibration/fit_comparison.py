"""The fits side by side: residuals in the sample, leave-one-out, and against a second run."""

from dataclasses import dataclass

import numpy as np

from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.fits.fit_names import FIT_NAMES, fit_curve
from arcref.error_curve import ErrorCurve
from arcref.error_statistics import ErrorStatistics
from arcref.input_error import InputError


@dataclass(frozen=True, eq=False)
class Verification:
    """What a correction leaves of a second run's errors.

    `angle_deg`, `left_arcsec`: float64[m], the second run less the fit, its first reading taken as zero; `statistics`:
    of them and of a closing zero, as Yu Hai et al. 2015 count in their tables; `open_statistics`: without that.
    """

    angle_deg: np.ndarray
    left_arcsec: np.ndarray
    statistics: ErrorStatistics
    open_statistics: ErrorStatistics


@dataclass(frozen=True, eq=False)
class FitFigures:
    """The figures of one fit; `fit` and `parameters` are None for no correction at all.

    `u_largest_arcsec`: largest standard uncertainty from the faces, None when they state none;
    `interpolation_u_arcsec`: that of the fit between the faces, rms; `difference_arcsec`: rms over the turn of this
    fit less the chosen one.
    """

    title: str
    fit: FittedCurve | None
    residual_rms_arcsec: float
    leave_one_out_rms_arcsec: float
    u_largest_arcsec: float | None = None
    interpolation_u_arcsec: float | None = None
    difference_arcsec: float | None = None
    verification: Verification | None = None


@dataclass(frozen=True, eq=False)
class FitComparison:
    """The chosen fit first, then its rivals, then no correction; `second` is the run that verifies, or None.

    `refused`: why a rival could not be fitted, one line each.
    """

    curve: ErrorCurve
    second: ErrorCurve | None
    figures: tuple[FitFigures, ...]
    refused: tuple[str, ...] = ()

    @property
    def chosen(self) -> FittedCurve:
        """The fit that goes into the ROM."""
        return self.figures[0].fit

    @property
    def fits(self) -> tuple[FittedCurve, ...]:
        """All fits, the chosen one first."""
        return tuple(one.fit for one in self.figures if one.fit is not None)

    def to_json(self) -> list[dict]:
        """The figures as JSON holds them, one entry a fit."""
        return [_json(one) for one in self.figures]


def compare_fits(chosen: FittedCurve, second: ErrorCurve | None = None) -> FitComparison:
    """`chosen` beside every other fit, these with their defaults, to the same curve; `second` is a run to verify with.

    Raises `InputError` when fewer than two readings of `second` lie where `chosen` was measured.
    """
    curve = chosen.curve
    fits, refused = [chosen], []
    for name in FIT_NAMES:
        if name != chosen.name:
            try:
                fits.append(fit_curve(curve, name))
            except InputError as error:
                refused.append(f"{name}: {error}")
    angle_deg = measured_angles_deg(chosen)
    there = chosen.evaluate(angle_deg)
    figures = [_figures(fit, second, angle_deg, there) for fit in fits]
    rms = _rms(curve.error_arcsec)
    untouched = None if second is None else _verification(second, np.zeros(second.angle_deg.size), chosen)
    figures.append(FitFigures("no correction", None, rms, rms, verification=untouched))
    return FitComparison(curve, second, tuple(figures), tuple(refused))


def verify_fit(fit: FittedCurve, second: ErrorCurve) -> Verification:
    """What `fit` leaves of the errors of `second`, the way the third table of Yu Hai et al. 2015 was made.

    `second` is a run of the encoder without correction, at any angles. Readings outside a measured arc are passed over.
    Raises `InputError` when fewer than two are left.
    """
    return _verification(second, fit.evaluate(second.angle_deg), fit)


def _verification(second: ErrorCurve, correction_arcsec: np.ndarray, fit: FittedCurve) -> Verification:
    covered = fit.covers(second.angle_deg)
    if covered.sum() < 2:
        raise InputError(
            f"the second run has {covered.sum()} readings where the first one measured, at least 2 were expected"
        )
    left = (second.error_arcsec - correction_arcsec)[covered]
    left = left - left[0]
    closed = ErrorStatistics.of(np.append(left, 0.0))
    return Verification(second.angle_deg[covered], left, closed, ErrorStatistics.of(left))


def _figures(
    fit: FittedCurve, second: ErrorCurve | None, angle_deg: np.ndarray, chosen_there: np.ndarray
) -> FitFigures:
    u = fit.u_arcsec(angle_deg)
    return FitFigures(
        fit.title,
        fit,
        _rms(fit.residual_arcsec),
        fit.leave_one_out_rms_arcsec,
        None if u is None else float(u.max()),
        _rms(fit.interpolation_u_arcsec(angle_deg)),
        _rms(fit.evaluate(angle_deg) - chosen_there),
        None if second is None else verify_fit(fit, second),
    )


def measured_angles_deg(fit: FittedCurve) -> np.ndarray:
    """Angles a quarter of a degree apart, those that were measured."""
    angle_deg = fit.curve.angle_deg[0] + np.arange(1440) / 4
    return angle_deg[fit.covers(angle_deg)]


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _json(one: FitFigures) -> dict:
    entry = {
        "fit": None if one.fit is None else one.fit.name,
        "title": one.title,
        "parameters": {} if one.fit is None else one.fit.parameters,
        "residual_rms_arcsec": one.residual_rms_arcsec,
        "leave_one_out_rms_arcsec": one.leave_one_out_rms_arcsec,
        "u_largest_arcsec": one.u_largest_arcsec,
        "interpolation_u_arcsec": one.interpolation_u_arcsec,
        "difference_from_chosen_rms_arcsec": one.difference_arcsec,
    }
    if one.verification is not None:
        closed, opened = one.verification.statistics, one.verification.open_statistics
        entry["verification"] = {
            "n": closed.n,
            "sigma_arcsec": closed.sigma_arcsec,
            "peak_to_peak_arcsec": closed.peak_to_peak_arcsec,
            "sigma_without_closure_arcsec": opened.sigma_arcsec,
            "mean_arcsec": opened.mean_arcsec,
        }
    return entry
