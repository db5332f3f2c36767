"""The sections of the report that belong to samples of sine and cosine."""

import numpy as np

from arcref.calibration.calibration_result import ReportSection
from arcref.subdivision.equal_angle_sampling import adaptive_scale_error, sampling_rate_hz
from arcref.subdivision.identification.identification_names import METHODS
from arcref.subdivision.identification.particle_swarm import PRINTED, SwarmSettings
from arcref.subdivision.identification.swarm_convergence import CONVERGED_V, swarm_convergence
from arcref.subdivision.period_parameters import SIGNIFICANCE
from arcref.subdivision.phase_knowledge import left_with_phase_error, limit_rows, period_scale_error_rad
from arcref.subdivision.samples_findings import SamplesFindings
from arcref.subdivision.signal_budget import error_harmonics, signal_budget
from arcref.subdivision.signal_correction import left_after_model, left_without
from arcref.subdivision.signal_model import line_phases_rad
from arcref.subdivision.signal_plots import causes_plot, harmonics_plot, lissajous_plot, map_plot, signals_plot

SWARM_SIZES, SWARM_SEEDS = (5, 10, 20, 40), 100

COMPARISON_TITLE = "Identifications side by side"


def samples_sections(found: SamplesFindings, plots: bool) -> tuple[ReportSection, ...]:
    """Signals, causes, harmonics, rivals, the map over the turn, and what the knowledge of the phase allows."""
    sections = [_signals(found, plots), _causes(found, plots), _harmonics(found, plots)]
    if found.options.compare:
        sections.append(_comparison(found))
        if plots:
            sections.append(_convergence(found))
    sections += [_over_the_turn(found, plots), _phase_knowledge(found)]
    return tuple(sections)


def _signals(found: SamplesFindings, plots: bool) -> ReportSection:
    expected = found.parameters.expected_sd_v / np.sqrt(found.run.samples.periods)
    rows = []
    for place, (name, channel) in enumerate((("sine", found.model.sine), ("cosine", found.model.cosine))):
        u = [float(value) for value in expected[place]]
        rows.append((f"{name}, offset", f"{channel.offset_v:+.5f}", f"{u[0]:.1g}", "", ""))
        for order, wave in channel.harmonics.items():
            # Both coefficients of an order have the same uncertainty, so the amplitude has it too.
            own = u[1] if len(u) > 1 else 0.0
            u_phase = np.degrees(own / wave.amplitude_v) if wave.amplitude_v > own else np.nan
            cells = f"{wave.amplitude_v:.5f}", f"{own:.1g}", f"{np.degrees(wave.phase_rad):+.3f}"
            rows.append((f"{name}, order {order}", *cells, f"{u_phase:.1g}" if np.isfinite(u_phase) else "any"))
    text = (
        "Both channels over one line, mean of all periods, and what the model leaves of them; sine against cosine with "
        "the circle that signals without a fault would draw. Phases are counted from the first sample of a period. "
        "The uncertainties are those that the samples' noise makes."
    )
    drawn = (signals_plot(found), lissajous_plot(found)) if plots else ()
    columns = ("parameter", "V", "u / V", "phase / deg", "u / deg")
    return ReportSection("Signals", (text,), columns, tuple(rows), drawn)


def _causes(found: SamplesFindings, plots: bool) -> ReportSection:
    causes = signal_budget(found.model)
    rows = tuple(
        (
            cause.name,
            "" if cause.size_arcsec is None else f"{cause.size_arcsec:.4f}",
            f"{cause.amplitude_arcsec:.4f}",
            f"{cause.wave_arcsec:.4f}",
            ", ".join(map(str, cause.orders)) or "none",
        )
        for cause in causes
    )
    text = (
        "Each fault alone on otherwise ideal signals: half of the peak to peak error that it makes. Waves of one order "
        "add or cancel with their phases, so the parts do not sum to the whole. A third harmonic makes waves of orders "
        "2 and 4; in both channels alike those of order 4 add and those of order 2 cancel, or the other way round.",
        _removal_sentence(found),
    )
    columns = ("cause", "size / arcsec", "error, half of peak to peak / arcsec", "largest wave / arcsec", "orders")
    return ReportSection("Error by cause", text, columns, rows, (causes_plot(causes),) if plots else ())


def _removal_sentence(found: SamplesFindings) -> str:
    model, theta = found.model, line_phases_rad(512)
    high = tuple(order for order in model.sine.orders if order > 1)
    without = np.ptp(left_without(model, theta, high, passes=2))
    offset = np.ptp(left_without(model, theta, high, offset=True, passes=2))
    whole = np.ptp(left_after_model(model, theta, model))
    named = " and ".join(map(str, high)) or "none"
    return (
        f"Of {np.ptp(model.error_arcsec(theta)):.3f} arcsec peak to peak, {without:.3f} would be left with the "
        f"harmonics {named} subtracted from the signals at run time, {offset:.3f} with the offsets "
        f"too, and {whole:.3f} with the whole model, which is what the ROM's table does."
    )


def _harmonics(found: SamplesFindings, plots: bool) -> ReportSection:
    waves, phases = error_harmonics(found.model)
    left = 2 * np.abs(np.fft.rfft(found.error_after_arcsec))[1 : waves.size + 1] / found.error_after_arcsec.size
    shown = min(waves.size, left.size)
    rows = tuple(
        (str(k + 1), f"{waves[k]:.4f}", f"{np.degrees(phases[k]):+.0f}", f"{left[k]:.4f}") for k in range(shown)
    )
    text = "Waves of the error to a line. Offsets make order 1, gain and quadrature order 2, third harmonics 2 and 4."
    drawn = (harmonics_plot(waves[:shown], left[:shown]),) if plots else ()
    columns = ("order", "before / arcsec", "phase / deg", "after / arcsec")
    return ReportSection("Harmonics of the error", (text,), columns, rows, drawn)


def _comparison(found: SamplesFindings) -> ReportSection:
    before = np.ptp(found.error_before_arcsec)
    fastest = min(each.seconds for each in found.rivals)
    rows = []
    for each in found.rivals:
        sine, cosine = each.model.sine, each.model.cosine
        rows.append(
            (
                METHODS[each.method],
                f"{sine.offset_v:+.4f} / {cosine.offset_v:+.4f}",
                _amplitudes(sine) + " / " + _amplitudes(cosine),
                f"{each.residual_rms_v[0] * 1e3:.4g} / {each.residual_rms_v[1] * 1e3:.4g}",
                f"{before:.3f}",
                f"{np.ptp(found.left_by(each)):.3f}",
                f"{each.seconds * 1e3:.3g} ({each.seconds / fastest:,.0f} x)",
            )
        )
    text = (
        "Sine / cosine. The model is linear in the offset and the two coefficients of each harmonic, so least squares "
        "finds the optimum exactly; the swarm searches the same optimum and cannot do better. The ellipse knows no "
        "harmonics. Times are those of this machine on this run."
    )
    columns = (
        "method", "offsets / V", "amplitudes / V", "residual rms / mV", "before / arcsec", "after / arcsec",
        "time / ms",
    )  # fmt: skip
    return ReportSection(COMPARISON_TITLE, (text,), columns, tuple(rows))


def _convergence(found: SamplesFindings) -> ReportSection:
    shares = [
        swarm_convergence(found.mean_samples, SWARM_SIZES, range(SWARM_SEEDS), found.options.orders, settings)
        for settings in (SwarmSettings(iterations=500), SwarmSettings(iterations=500, inertia_rule=PRINTED))
    ]
    below = max(each.least_below_v2 for of_rule in shares for each in of_rule)
    rows = tuple(
        (
            str(size),
            *(f"{100 * each.share:.0f}" for each in pair),
            *(f"{np.median(each.distance_v):.1e}" for each in pair),
        )
        for size, *pair in zip(SWARM_SIZES, *shares, strict=True)
    )
    text = (
        f"Swarms of several sizes, {SWARM_SEEDS} seeds each, 500 iterations, c1 = c2 = 2: share that comes within "
        f"{CONVERGED_V:g} V rms of the least squares optimum in both channels, and the median distance from it. "
        + ("None came below it." if below < 1e-12 else f"One came below it by {below:.1g} V^2.")
    )
    columns = ("particles", "converged / %", "rule as printed / %", "median distance / V", "rule as printed / V")
    return ReportSection("Does the swarm find the optimum?", (text,), columns, rows)


def _amplitudes(channel) -> str:
    return ", ".join(f"{wave.amplitude_v:.4f}" for wave in channel.canonical.harmonics.values())


def _over_the_turn(found: SamplesFindings, plots: bool) -> ReportSection:
    parameters, lines = found.parameters, found.map
    probability = parameters.change_probability
    if probability is None:
        what = "One period, or samples without noise, cannot show whether the parameters change."
    elif probability < SIGNIFICANCE:
        change = float(np.sqrt(np.mean(lines.change_arcsec**2)))
        chance = "below 1e-30" if probability < 1e-30 else f"{probability:.1g}"
        what = (
            f"The parameters change from line to line more than the noise explains (chance {chance}): {change:.4f} "
            "arcsec rms of the error, beyond the noise."
        )
    else:
        what = f"The parameters scatter no more than the noise explains (chance {probability:.2g})."
    average = "each line by itself" if lines.lines == 1 else f"{lines.lines} lines averaged in a row"
    rows = ()
    if parameters.coefficients_v.shape[0] > 1:
        scatter = parameters.coefficients_v.std(axis=0, ddof=1) * 1e3
        expected = parameters.expected_sd_v * 1e3
        names = ["offset"] + [f"order {k}, {part}" for k in parameters.orders for part in ("sine part", "cosine part")]
        rows = tuple(
            (name, *(f"{scatter[c, i]:.3g}" for c in (0, 1)), *(f"{expected[c, i]:.3g}" for c in (0, 1)))
            for i, name in enumerate(names)
        )
    columns = ("parameter", "scatter, sine / mV", "cosine / mV", "of noise alone, sine / mV", "cosine / mV")
    drawn = (map_plot(lines),) if plots and len(lines.error_arcsec) > 1 else ()
    return ReportSection("Over the turn", (what, f"The map has {average}."), columns, rows, drawn)


def _phase_knowledge(found: SamplesFindings) -> ReportSection:
    run, model = found.run, found.model
    rows = [(what, f"{left:.4f}") for what, left in limit_rows(model, found.options.orders)]
    paragraphs = [
        "What would be left of the error, peak to peak, after identification from one period and full correction, if "
        "the samples were not at the phases they are taken for. It is the limit of the method: sine and cosine at "
        "unknown phases are only a Lissajous figure.",
        f"Sampling at equal angles takes {found.parameters.samples_per_period} samples a period: "
        f"{sampling_rate_hz(1.0, run.line_count, found.parameters.samples_per_period) / 1e6:.4g} million a second for "
        "each turn a second.",
    ]
    if run.slip is not None and run.samples.mark_s is not None:
        scale = adaptive_scale_error(run.samples.mark_s)
        worst = float(np.sqrt(np.mean(scale**2)))
        left = np.ptp(left_with_phase_error(model, period_scale_error_rad(worst), found.options.orders))
        paragraphs.append(
            f"In this run a period differed from the one before by {100 * worst:.3g} % rms, "
            f"{100 * np.abs(scale).max():.3g} % at most. Adaptive sampling, whose rate follows the period before, "
            f"would have taken each period for that much longer or shorter: {left:.3f} arcsec peak to peak. Resampling "
            "afterwards knows both sides."
        )
    elif run.slip is not None:
        worst = float(np.sqrt(np.mean(run.slip**2)))
        paragraphs.append(f"In this run the periods begin within {100 * worst:.2g} % rms of where they should.")
    else:
        paragraphs.append("This run has one period, which cannot show whether its samples lie where they should.")
    columns = ("phases of the samples", "left / arcsec, peak to peak")
    return ReportSection("Knowledge of the phase", tuple(paragraphs), columns, tuple(rows))
