"""From a run of samples to its calibration: the error over a line, budget, checks, and what the report says."""

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.calibration.calibration_provenance import calibration_provenance
from arcref.calibration.calibration_result import CalibrationResult
from arcref.check import Check
from arcref.run_file import RunFile
from arcref.subdivision.identification.identification import IdentifiedParameters
from arcref.subdivision.identification.identification_names import METHODS
from arcref.subdivision.period_parameters import SIGNIFICANCE
from arcref.subdivision.samples_budget import samples_budget, speed_change_percent
from arcref.subdivision.samples_findings import SamplesFindings, samples_findings
from arcref.subdivision.samples_run import samples_run
from arcref.subdivision.samples_sections import samples_sections
from arcref.subdivision.signal_budget import error_harmonics, signal_budget
from arcref.subdivision.subdivision_run import SubdivisionOptions
from arcref.subdivision_curve import SubdivisionCurve

_DIGITS = 9


def samples_result(run: RunFile, options: SubdivisionOptions) -> CalibrationResult:
    """Identify the signals of a run of samples and judge. Raises `InputError` for a run that cannot be used."""
    found = samples_findings(samples_run(run, options.orders), options)
    budget = samples_budget(found)
    results = _results(found) | {"expanded_uncertainty_arcsec": budget.expanded_arcsec}
    return CalibrationResult(
        kind="subdivision",
        run=run,
        curve=_curve(found),
        results=results,
        budget=budget,
        method=_method(found),
        figures=_figures(found, budget),
        checks=_checks(found),
        warnings=_warnings(found),
        sections=samples_sections(found, options.plots),
        not_checked=_not_checked(found),
        provenance=_provenance(found),
    )


def _curve(found: SamplesFindings) -> SubdivisionCurve:
    known = speed_change_percent(found)
    phase = 0.0 if known is None else known[0] * found.speed_sensitivity_arcsec
    u = np.sqrt(found.noise_arcsec**2 + phase**2 + found.lack_of_fit_arcsec**2)
    return SubdivisionCurve(found.line_deg, found.error_arcsec, _provenance(found), u)


def _provenance(found: SamplesFindings) -> dict:
    method = {
        "name": f"samples of sine and cosine, {METHODS[found.options.method]}",
        "orders": list(found.options.orders),
        "periods": found.run.samples.periods,
        "samples_per_period": found.parameters.samples_per_period,
        "resampled": found.run.resampled,
    }
    return calibration_provenance(method, found.run.run)


def _results(found: SamplesFindings) -> dict:
    model = found.model
    waves, phases = error_harmonics(model)
    results = {
        "sine": _channel(model.sine.to_json()),
        "cosine": _channel(model.cosine.to_json()),
        "line_count": found.run.line_count,
        "cosine_sign": found.run.cosine_sign,
        "count_zero_phase_deg": found.run.count_zero_phase_deg or 0.0,
        "count_zero_phase_is_stated": found.run.count_zero_phase_deg is not None,
        "periods": found.run.samples.periods,
        "samples_per_period": found.parameters.samples_per_period,
        "noise_v": {"sine": _rounded(found.parameters.noise_v[0]), "cosine": _rounded(found.parameters.noise_v[1])},
        "error_peak_to_peak_arcsec": _rounded(np.ptp(found.error_before_arcsec)),
        "left_peak_to_peak_arcsec": _rounded(np.ptp(found.error_after_arcsec)),
        "error_harmonics": [
            {"order": order, "amplitude_arcsec": _rounded(amplitude), "phase_rad": _rounded(phase)}
            for order, (amplitude, phase) in enumerate(zip(waves, phases, strict=True), 1)
        ],
        "causes": [
            {
                "name": cause.name,
                "size_arcsec": None if cause.size_arcsec is None else _rounded(cause.size_arcsec),
                "amplitude_arcsec": _rounded(cause.amplitude_arcsec),
                "largest_wave_arcsec": _rounded(cause.wave_arcsec),
                "orders": list(cause.orders),
            }
            for cause in signal_budget(model)
        ],
        "change_probability": found.parameters.change_probability,
    }
    if found.options.compare:
        results["identifications"] = [_identification(found, each) for each in found.rivals]
    return results


def _identification(found: SamplesFindings, each: IdentifiedParameters) -> dict:
    return {
        "method": each.method,
        "sine": _channel(each.model.sine.to_json()),
        "cosine": _channel(each.model.cosine.to_json()),
        "residual_rms_v": [_rounded(value) for value in each.residual_rms_v],
        "error_before_peak_to_peak_arcsec": _rounded(np.ptp(found.error_before_arcsec)),
        "error_after_peak_to_peak_arcsec": _rounded(np.ptp(found.left_by(each))),
    }


def _channel(content: dict) -> dict:
    waves = {
        order: {name: _rounded(value) for name, value in wave.items()} for order, wave in content["harmonics"].items()
    }
    return {"offset_v": _rounded(content["offset_v"]), "harmonics": waves}


def _method(found: SamplesFindings) -> tuple[str, ...]:
    run, rate = found.run, found.parameters.samples_per_period
    orders = ", ".join(map(str, found.options.orders))
    if run.has_time:
        how = f"in time, {run.rate_per_period:.1f} a period, resampled to {rate} at equal angles"
    elif run.resampled:
        how = f"numbered {rate} to a period, but off their angles, so resampled to {rate} at equal angles"
    else:
        how = f"taken at equal angles, {rate} a period"
    periods = "period" if run.samples.periods == 1 else "periods"
    return (
        f"Sine and cosine were sampled over {run.samples.periods} whole signal {periods}, {how}. Of their "
        f"mean, offset, amplitudes and phases of orders {orders} were identified for both channels by "
        f"{METHODS[found.options.method]}: the model of Gao Xu et al., Acta Optica Sinica 33(7) 2013, equations (8) "
        "and (9).",
        f"The angle reads atan2(sine, {'+' if run.cosine_sign > 0 else '-'}cosine); the error is that reading less the "
        "true phase, as an angle, with no mean over the line. The curve is over the reading, as the ROM's table needs "
        "it, so one look-up corrects. Phase 0 of the curve is where the count is a multiple of a line: the "
        f"interpolated phase {run.count_zero_phase_deg or 0:g} deg "
        f"({'stated' if run.count_zero_phase_deg is not None else 'not stated, assumed'}).",
    )


def _figures(found: SamplesFindings, budget) -> tuple[tuple[str, str], ...]:
    run, model = found.run, found.model
    before, after = found.error_before_arcsec, found.error_after_arcsec
    strongest = max(signal_budget(model)[:-1], key=lambda cause: cause.amplitude_arcsec)
    noise = found.parameters.noise_v * 1e3
    periods = "period" if run.samples.periods == 1 else "periods"
    kind = "resampled" if run.resampled else "at equal angles"
    rows = [
        ("samples", f"{run.samples.periods} {periods} of {found.parameters.samples_per_period}, {kind}"),
        ("grating", f"{run.line_count} lines, a period is {model.period_arcsec:.4f} arcsec"),
        ("identified by", f"{METHODS[found.options.method]}, orders {', '.join(map(str, found.options.orders))}"),
        ("error within a line", f"{before.max():+.3f} / {before.min():+.3f}, {np.ptp(before):.3f} arcsec peak to peak"),
        ("largest cause", f"{strongest.name}, amplitude {strongest.amplitude_arcsec:.3f} arcsec"),
        ("after correction", f"{np.ptp(after):.3f} arcsec peak to peak, of the mean of these same periods"),
        (
            "noise",
            f"{noise[0]:.3g} mV sine, {noise[1]:.3g} mV cosine: {found.reading_noise_arcsec:.4f} arcsec a reading",
        ),
        ("expanded uncertainty", f"{budget.expanded_arcsec:.3f} arcsec (k=2) of an angle corrected within the line"),
    ]
    if found.options.compare:
        rows += [(f"by {METHODS[each.method]}", _compared(found, each)) for each in found.rivals]
    return tuple(rows)


def _compared(found: SamplesFindings, each: IdentifiedParameters) -> str:
    left = np.ptp(found.left_by(each))
    residual = max(each.residual_rms_v) * 1e3
    return f"residual {residual:.3g} mV, error {left:.3f} arcsec after it, {each.seconds * 1e3:.3g} ms"


def _checks(found: SamplesFindings) -> tuple[Check, ...]:
    before, after = np.ptp(found.error_before_arcsec), np.ptp(found.error_after_arcsec)
    noise = 8 * np.sqrt(np.mean(found.noise_arcsec**2)) + 6 * found.reading_noise_arcsec / np.sqrt(
        found.run.samples.periods
    )
    sentence = "The correction makes the error of the mean period less, or it is within the noise already."
    passed = bool(after < before or before <= noise)
    return (Check(sentence, f"{before:.3f} before, {after:.3f} arcsec after, peak to peak", passed),)


def _warnings(found: SamplesFindings) -> tuple[str, ...]:
    run, warnings = found.run, []
    if run.line_count != LINES_PER_TURN:
        warnings.append(
            f"The disc has {run.line_count} lines; the ROM of this instrument is for {LINES_PER_TURN} "
            "and will not take it."
        )
    if run.count_zero_phase_deg is None:
        warnings.append(
            "The run does not state at which phase of the signals the count is a multiple of a line "
            "(# count_zero_phase_deg: ...); 0 was assumed, and a wrong one puts the table beside its place."
        )
    if not run.sign_is_stated:
        warnings.append(
            f"The run does not state '# cosine_sign: ...'; {run.cosine_sign:+d} was taken from the samples, as if the "
            "angle grew during the run. Swapped columns or a shaft that turned backwards would give a mirrored curve."
        )
    if run.resampled and not run.has_time:
        warnings.append(
            f"The numbered samples are off their angles: periods differ by {100 * np.sqrt(np.mean(run.slip**2)):.2g} % "
            "rms from one to the next. They were resampled; sampling should follow the speed."
        )
    probability = found.parameters.change_probability
    if probability is not None and probability < SIGNIFICANCE and len(found.map.error_arcsec) > 1:
        change = float(np.sqrt(np.mean(found.map.change_arcsec**2)))
        warnings.append(
            f"The parameters change from line to line more than the noise explains: {change:.3f} arcsec rms of the "
            "error. One table serves all lines and corrects their mean."
        )
    if found.identified.method == "swarm-printed":
        warnings.append("The inertia rule as printed is kept for comparison only: its swarm often stops short.")
    return tuple(warnings)


def _not_checked(found: SamplesFindings) -> tuple[str, ...]:
    sentences = [
        "A change of the speed in step with the lines: to the samples it is an error of the signals.",
        "The interpolator: its own converters, delay and filters are not in signals sampled before it. Edge times or a "
        "fine scan see them.",
        "The error over the turn: that is the first table's.",
    ]
    if found.run.samples.periods < found.run.line_count:
        sentences.append(f"Other lines than the {found.run.samples.periods} of this run.")
    return tuple(sentences)


def _rounded(value) -> float:
    """Last digits differ from machine to machine."""
    return float(f"{float(value):.{_DIGITS}g}")
