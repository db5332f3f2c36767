"""What a report says about the fit: the fit itself, its rivals, and errors within a line that it may have taken in."""

import numpy as np

from arcref.calibration.aliasing import BLIND, Alias, aliases, exposure_at, telling_offsets
from arcref.calibration.calibration_result import ReportSection
from arcref.calibration.fit_comparison import FitComparison, FitFigures, measured_angles_deg
from arcref.calibration.fit_plot import comparison_plot, fit_plot
from arcref.calibration.fits.curve_fit import FittedCurve
from arcref.calibration.harmonics import harmonics
from arcref.calibration.periodogram_test import fisher_g_p
from arcref.error_curve import ErrorCurve

LEAVE_ONE_OUT_MEANING = (
    "Left out, each face is foretold by the others. A fit that foretells worse than no correction does harm between "
    "the faces; among fits within some ten percent of each other leave-one-out does not choose, and it is no "
    "uncertainty: a face left out leaves a gap twice as wide as any the fit has to bridge."
)

COMPARISON_TITLE = "Fits side by side"

OFFSETS_SHOWN = 4


def fit_section(fit: FittedCurve, plots: bool = True) -> ReportSection:
    """The fit that goes into the ROM: what it is, and its figures; `plots` draws it, which takes most of the time."""
    curve = fit.curve
    angle_deg = measured_angles_deg(fit)
    u, between = fit.u_arcsec(angle_deg), fit.interpolation_u_arcsec(angle_deg)
    rows = [("fit", fit.title)]
    rows += [(_parameter_name(key), _parameter_value(key, value)) for key, value in fit.parameters.items()]
    rows.append(("residual at the faces, rms", f"{_rms(fit.residual_arcsec):.3f} arcsec"))
    rows.append(("leave-one-out, rms", f"{fit.leave_one_out_rms_arcsec:.3f} arcsec"))
    rows.append(("without correction, rms", f"{_rms(curve.error_arcsec):.3f} arcsec"))
    if u is not None:
        rows.append(("standard uncertainty from the faces", f"{u.min():.3f} .. {u.max():.3f} arcsec"))
    rows.append(("standard uncertainty of the fit between faces", f"{_rms(between):.3f} arcsec rms"))
    paragraphs = [LEAVE_ONE_OUT_MEANING]
    if fit.leave_one_out_rms_arcsec > _rms(curve.error_arcsec):
        paragraphs.insert(0, "Caution: left out, a face is foretold worse by this fit than by no correction.")
    if curve.arc_deg is not None:
        first, last = curve.arc_deg
        paragraphs.append(f"Only {first:g} .. {last:g} deg was measured. Outside of it nothing is corrected.")
    elif curve.gaps_deg.max() > 2 * curve.spacing_deg:
        start = curve.angle_deg[int(np.argmax(curve.gaps_deg))]
        paragraphs.append(f"Caution: nothing was measured in the {curve.gaps_deg.max():g} deg behind {start:g} deg.")
    return ReportSection("Fit", tuple(paragraphs), ("figure", "value"), tuple(rows), (fit_plot(fit),) if plots else ())


def comparison_section(comparison: FitComparison, plots: bool = True) -> ReportSection:
    """The fit and its rivals in a table, with the plot if `plots`."""
    columns = ["fit", "in sample", "left out", "u from faces", "u between", "from chosen"]
    verified = comparison.second is not None
    if verified:
        columns += ["second run", "peak to peak"]
    rows = tuple(_comparison_row(one, verified) for one in comparison.figures)
    paragraphs = [
        "All figures in arcsec: rms of the residuals at the faces in the sample and left out; largest standard "
        "uncertainty that comes from the faces; that of the fit between them, rms; rms difference from the chosen fit, "
        "the first.",
        LEAVE_ONE_OUT_MEANING,
    ]
    if verified:
        n = comparison.figures[0].verification.statistics.n
        paragraphs.append(
            f"Second run: its errors less the fit, the first reading taken as zero; sigma (n - 1) and peak to peak of "
            f"the {n - 1} readings and a closing zero, n = {n}, as Yu Hai et al. 2015 count. Noise of both runs is "
            "in it."
        )
        paragraphs += blind_sentences(comparison.chosen, comparison.second)
    paragraphs += [f"Not fitted: {reason}" for reason in comparison.refused]
    drawn = (comparison_plot(comparison),) if plots else ()
    return ReportSection(COMPARISON_TITLE, tuple(paragraphs), tuple(columns), rows, drawn)


def blind_sentences(fit: FittedCurve, second: ErrorCurve) -> list[str]:
    """Which errors within a line `second` cannot tell from slow ones, one sentence, or none when it tells them all."""
    hidden = [
        alias
        for alias in aliases(fit.curve)
        if alias.seen_order and exposure_at(fit, alias.order, second.angle_deg) < BLIND
    ]
    if not hidden:
        return []
    orders = " and ".join(f"{alias.order} (seen as {alias.seen_order})" for alias in hidden)
    return [f"Caution: at its angles the second run is blind to an error of order {orders}, as the first one was."]


def aliasing_warning(fit: FittedCurve, reading_deg=None) -> str | None:
    """The warning in one paragraph, None when the faces scatter every error within a line. See `aliases`."""
    hidden = [alias for alias in aliases(fit.curve, reading_deg) if alias.seen_order]
    if not hidden:
        return None
    first = hidden[0]
    same = [alias for alias in hidden if alias.seen_order == first.seen_order]
    orders = ", ".join(str(alias.order) for alias in same)
    text = f"An error of order {orders} (within a grating line) looks like order {first.seen_order} to these faces"
    if first.amplitude_arcsec is not None:
        text += f", where {_amplitude(first)} of the curve stand, {_percent(first.share)} of its power"
    offset_deg, factors = telling_offsets(fit, tuple(hidden))[0]
    return text + (
        f"; the faces cannot tell which it is. A second run with every face {offset_deg:.4g} deg further on shows it "
        f"at {min(factors):.2f} times its amplitude or more."
    )


def aliasing_section(fit: FittedCurve, reading_deg=None) -> ReportSection:
    """What errors within a grating line look like, how much of the curve stands there, and which angle would tell."""
    curve = fit.curve
    found = harmonics(curve)
    seen = aliases(curve, reading_deg, found=found)
    title = "Errors within a grating line as the faces see them"
    if curve.arc_deg is not None:
        text = "An arc does not tell harmonics of the turn apart; errors within a grating line were not looked for."
        return ReportSection(title, (text,))
    offsets = telling_offsets(fit, seen)[:OFFSETS_SHOWN]
    columns = ("order", "looks like", "amplitude there / arcsec", "share of power", "chance in noise")
    columns += tuple(f"shown at +{_offset(offset_deg)}" for offset_deg, _ in offsets)
    rows = tuple(
        (*_alias_cells(alias), *(f"{factors[number]:.2f} x" for _, factors in offsets))
        for number, alias in enumerate(seen)
    )
    paragraphs = [_alias_sentence(curve, seen)]
    if any(alias.share is not None for alias in seen):
        strongest = int(found.order[np.argmax(found.power_arcsec2)])
        paragraphs.append(
            "Chance in noise: that of so large a share at an order named beforehand, were the errors of the faces "
            f"independent. The largest order of this curve is {strongest}; the chance of so large a largest one "
            f"(Fisher's g test) is {fisher_g_p(found):.2g}. A small chance says that there is a wave of that order, "
            "not where it comes from."
        )
    if any(alias.seen_order for alias in seen):
        paragraphs.append(
            "The last columns are for a second run with every face that much further on: the amplitude that the "
            "correction leaves there, in units of the error's own. 2 shows it doubled, 0 not at all. A fine scan "
            "within one grating line tells as well."
        )
    return ReportSection(title, tuple(paragraphs), columns, rows)


def _alias_sentence(curve: ErrorCurve, seen: tuple[Alias, ...]) -> str:
    faces = curve.angle_deg.size
    if all(alias.seen_order is None for alias in seen):
        return (
            f"The {faces} faces meet the grating lines at so many phases that an error within a line looks like no "
            "single order to them; it adds to their scatter."
        )
    text = (
        f"An error that repeats in each grating line is far too fast for {faces} faces. They see it as a slow "
        "error, the fit takes it for one, and the ROM then corrects between the faces what is not there."
    )
    if any(alias.seen_order == 0 for alias in seen):
        text += " What looks like a constant is in no run against the first face; only a fine scan shows it."
    return text


def _alias_cells(alias: Alias) -> tuple[str, ...]:
    looks = {None: "no single order", 0: "a constant"}.get(alias.seen_order, f"order {alias.seen_order}")
    if alias.seen_order is not None and alias.coherence < 0.995:
        looks += f" ({_percent(alias.coherence)} of it)"
    if alias.amplitude_arcsec is None:
        return str(alias.order), looks, "-", "-", "-"
    chance = "-" if alias.p is None else f"{alias.p:.2g}"
    return str(alias.order), looks, _amplitude(alias).removesuffix(" arcsec"), _percent(alias.share), chance


def _amplitude(alias: Alias) -> str:
    u = "" if alias.u_amplitude_arcsec is None else f" (u {alias.u_amplitude_arcsec:.3f})"
    return f"{alias.amplitude_arcsec:.3f}{u} arcsec"


def _percent(part: float) -> str:
    return f"{100 * part:.0f} %"


def _offset(offset_deg: float) -> str:
    return f"{offset_deg:.4f}".rstrip("0").rstrip(".") + " deg"


def _comparison_row(one: FitFigures, verified: bool) -> tuple[str, ...]:
    values = [
        one.residual_rms_arcsec,
        one.leave_one_out_rms_arcsec,
        one.u_largest_arcsec,
        one.interpolation_u_arcsec,
        one.difference_arcsec,
    ]
    if verified:
        statistics = one.verification.statistics
        values += [statistics.sigma_arcsec, statistics.peak_to_peak_arcsec]
    return (one.title, *("-" if value is None else f"{value:.3f}" for value in values))


def _parameter_name(key: str) -> str:
    for unit in ("_deg", "_arcsec"):
        key = key.removesuffix(unit)
    return key.replace("_", " ")


def _parameter_value(key: str, value) -> str:
    unit = " deg" if key.endswith("_deg") else " arcsec" if key.endswith("_arcsec") else ""
    return f"{value:.4g}{unit}"


def _rms(values) -> float:
    return float(np.sqrt(np.mean(np.square(values))))
