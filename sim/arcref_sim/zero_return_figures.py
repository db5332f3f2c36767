"""The figures of a zero-return test: the short table for a person, and the same by name for a program."""

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.zero_return import ZeroReturnResult


def figures(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """Rows of the short table: name and value."""
    plan = result.plan
    errors = [error for _, _, error in result.closure]
    turns = sorted(set(result.counts_per_turn))
    spacing = plan.samples_per_count
    return [
        ("speed", f"{plan.speed_rps:g} r/s, {plan.speed_rps * COUNTS_PER_TURN / 1e6:.2f} M counts/s"),
        ("samples", f"{plan.sample_rate_hz / 1e6:g} M samples/s, {spacing:.2f} for each count"),
        ("turns", f"{plan.revolutions} forward, {plan.revolutions} reverse"),
        ("counts seen", f"{result.counts:,}".replace(",", " ")),
        ("counts per turn", " .. ".join(f"{turn}" for turn in (turns[:1] + turns[1:][-1:])) or "no whole turn"),
        ("zero marks seen", f"{len(errors)} of {2 * (plan.revolutions + 1)}"),
        ("closure error, each", _closure(errors)),
        ("zero drift", "no zero mark" if result.zero_drift_counts is None else f"{result.zero_drift_counts} counts"),
        ("counts lost", f"{result.lost_counts}"),
        ("illegal steps", f"{result.illegal_steps}"),
        ("shortest edge spacing", f"{result.shortest_edge_spacing} samples"),
        ("error before correction", _error(result.before_arcsec)),
        ("error after correction", _error(result.after_arcsec)),
        ("corrected, off the fit", f"{result.fit_difference_counts:.3f} counts at most"),
        ("SPI frames", f"{result.frames_read} read, {result.frames_wrong} wrong"),
        ("simulated", f"{result.counts / result.seconds / 1e6:.2f} M counts/s, "
                      f"{result.samples_per_s / 1e6:.1f} M samples/s"),
        ("fault flags up", ", ".join(result.faults) or "none"),
    ]  # fmt: skip


def figures_by_name(result: ZeroReturnResult) -> dict:
    """The figures for a program; units stand in the names."""
    plan = result.plan
    return {
        "passed": result.passed,
        "checks": result.checks,
        "speed_rps": plan.speed_rps,
        "revolutions": plan.revolutions,
        "samples_per_word": plan.samples_per_word,
        "sample_rate_hz": plan.sample_rate_hz,
        "samples_per_count": plan.samples_per_count,
        "counts": result.counts,
        "counts_per_turn": result.counts_per_turn,
        "closure": [
            {"turn": turn, "direction": direction, "closure_error_counts": error}
            for turn, direction, error in result.closure
        ],
        "zero_drift_counts": result.zero_drift_counts,
        "lost_counts": result.lost_counts,
        "illegal_steps": result.illegal_steps,
        "shortest_edge_spacing_samples": result.shortest_edge_spacing,
        "flags": result.flags,
        "error_before_rms_arcsec": _rms(result.before_arcsec),
        "error_before_max_arcsec": _largest(result.before_arcsec),
        "error_after_rms_arcsec": _rms(result.after_arcsec),
        "error_after_max_arcsec": _largest(result.after_arcsec),
        "fit_difference_max_counts": result.fit_difference_counts,
        "spi_frames_read": result.frames_read,
        "spi_frames_wrong": result.frames_wrong,
        "first_difference": result.first_difference,
        "words": result.words,
        "seconds": result.seconds,
        "samples_per_s": result.samples_per_s,
        "rom_crc32": plan.rom.crc32,
    }


def _closure(errors: list[int]) -> str:
    if not errors:
        return "no zero mark"
    if len(set(errors)) == 1:
        return f"{errors[0]} counts"
    return " ".join(str(error) for error in errors) + " counts"


def _rms(errors: np.ndarray) -> float | None:
    return float(np.sqrt(np.mean(errors**2))) if len(errors) else None


def _largest(errors: np.ndarray) -> float | None:
    return float(np.abs(errors).max()) if len(errors) else None


def _error(errors: np.ndarray) -> str:
    if not len(errors):
        return "not corrected"
    return f"{_rms(errors):.3f} arcsec rms, {_largest(errors):.3f} at most"
