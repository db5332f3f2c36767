"""The short table that the command prints and the page begins with: the same rows for simulation and instrument."""

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.zero_return.index_pass import closure_text
from arcref.zero_return.result import ZeroReturnResult
from arcref.zero_return.truth_parts import ErrorFigures

NO_SPACING = 4095
"""What the shortest edge spacing reads while no two edges came within 2048 samples."""

NOT_KNOWN = "not checked: an instrument does not know the true angle"


def figures(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """Names and values."""
    turns = sorted(set(result.counts_per_turn))
    drift = result.zero_drift_counts
    parts = result.instrument
    largest = 0 if parts is None else parts.largest_closure_error_counts
    seen, further = len(result.index_passes), 0
    if parts is not None:
        expected = len(result.expected_passes) - len(result.missing_passes)
        seen, further = expected, seen - expected + parts.further_marks
    return [
        ("speed", _speed_text(result)),
        ("samples", f"{result.sample_rate_hz / 1e6:g} M samples/s, {result.samples_per_count:.2f} to a count"),
        ("turns", f"{result.revolutions} forward, {result.revolutions} reverse, {result.counts:,} counts"),
        ("counts per turn", " .. ".join(f"{turn:,}" for turn in turns[:1] + turns[1:][-1:]) or "no whole turn"),
        ("zero marks seen", f"{seen} of {len(result.expected_passes)}{_further_text(further)}"),
        ("closure error, each", closure_text(result.closure_errors_counts, largest)),
        ("zero drift", "the zero mark did not come back" if drift is None else f"{drift} counts"),
        ("counts lost", _lost_text(result)),
        ("illegal steps", f"{result.illegal_steps}"),
        ("shortest edge spacing", _spacing_text(result)),
        ("error before correction", _error_text(result.before)),
        ("error after correction", _error_text(result.after)),
        *_ends_of_the_correction(result),
        ("fault flags up", ", ".join(result.faults) or "none"),
        _work_done(result),
    ]


def _speed_text(result: ZeroReturnResult) -> str:
    counts = f"{result.speed_rps * COUNTS_PER_TURN / 1e6:.2f} M counts/s"
    if result.instrument is None:
        return f"{result.speed_rps:g} r/s, {counts}"
    return f"{result.speed_rps:.4g} r/s, {counts}; {result.instrument.fastest_rps:.4g} r/s at most"


def _further_text(number: int) -> str:
    return f", and {number} more beside them" if number else ""


def _lost_text(result: ZeroReturnResult) -> str:
    if result.lost_counts is not None:
        return f"{result.lost_counts}"
    largest = abs(result.instrument.largest_closure_error_counts)
    return f"{largest} at the zero marks{'' if largest == 0 else ' at most'}; between them not known"


def _spacing_text(result: ZeroReturnResult) -> str:
    spacing = result.shortest_edge_spacing_samples
    if spacing == NO_SPACING:
        return "more than 2048 samples"
    return f"{spacing} sample{'s' * (spacing != 1)}, {result.shortest_edge_spacing_ns:.2f} ns"


def _error_text(error: ErrorFigures | None) -> str:
    if error is None:
        return NOT_KNOWN
    if error.readings == 0:
        return "not corrected"
    return f"{error.rms_arcsec:.3f} arcsec rms, {error.max_arcsec:.3f} at most"


def _ends_of_the_correction(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """How the corrected position and the SPI frames compare with what they must be."""
    if result.instrument is None:
        return [
            ("corrected, off the fit", f"{result.correction_deviation_counts:.3f} counts at most"),
            ("SPI frames", f"{result.spi_frames} read, {result.spi_frames_wrong} wrong"),
        ]
    wrong = result.instrument.rom_readings_wrong
    compared = "not checked: no ROM image was named"
    if wrong is not None:
        compared = f"{result.instrument.readings} readings, {wrong} wrong"
    if not result.flags & Flag.CORRECTION_ACTIVE:
        compared = f"the correction was off; {compared}"
    return [
        ("corrected, off the ROM", compared),
        ("SPI frames", "not checked: read over the serial link"),
    ]


def _work_done(result: ZeroReturnResult) -> tuple[str, str]:
    if result.instrument is None:
        text = f"{result.counts_per_s / 1e6:.2f} M counts/s, {result.samples_per_s / 1e6:.1f} M samples/s"
        return "simulated", text
    parts = result.instrument
    rate = f"{parts.readings_per_s:.3g}" if parts.readings_per_s < 100 else f"{parts.readings_per_s:,.0f}"
    return "measured", f"{parts.readings:,} readings in {parts.duration_s:.3g} s, {rate} a second"
