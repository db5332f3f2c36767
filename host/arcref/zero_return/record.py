"""The zero-return test for a program: the content of its JSON file."""

from dataclasses import asdict

from arcref.zero_return.result import ZeroReturnResult
from arcref.zero_return.truth_parts import ErrorFigures


def zero_return_record(result: ZeroReturnResult) -> dict:
    """The figures for a program; units stand in the names. What was not checked is None."""
    before, after = (error or ErrorFigures(None, None, 0) for error in (result.before, result.after))
    return {
        "format": "arcref-zero-return",
        "version": 1,
        "passed": result.passed,
        "checks": {check.sentence: check.passed for check in result.checks},
        "speed_rps": result.speed_rps,
        "revolutions": result.revolutions,
        "samples_per_word": result.samples_per_word,
        "sample_rate_hz": result.sample_rate_hz,
        "samples_per_count": result.samples_per_count,
        "counts": result.counts,
        "counts_per_turn": result.counts_per_turn,
        "closure": [asdict(index) for index in result.index_passes],
        "zero_drift_counts": result.zero_drift_counts,
        "lost_counts": result.lost_counts,
        "illegal_steps": result.illegal_steps,
        "shortest_edge_spacing_samples": result.shortest_edge_spacing_samples,
        "shortest_edge_spacing_ns": result.shortest_edge_spacing_ns,
        "flags": result.flags,
        "error_before_rms_arcsec": before.rms_arcsec,
        "error_before_max_arcsec": before.max_arcsec,
        "error_after_rms_arcsec": after.rms_arcsec,
        "error_after_max_arcsec": after.max_arcsec,
        "fit_difference_max_counts": result.correction_deviation_counts,
        "spi_frames_read": result.spi_frames,
        "spi_frames_wrong": result.spi_frames_wrong,
        "first_difference": None if result.difference is None else str(result.difference),
        "words": result.words,
        "seconds": result.simulation_s,
        "counts_per_s": result.counts_per_s,
        "samples_per_s": result.samples_per_s,
        "provenance": result.provenance,
    } | ({} if result.instrument is None else {"instrument": result.instrument.to_json()})
