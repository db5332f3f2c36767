"""The zero-return test as one HTML page that needs nothing beside itself."""

import json

from jinja2 import Environment, PackageLoader, StrictUndefined

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref_sim.zero_return_plots import closure_plot, error_plot, waveform_plot
from arcref_sim.zero_return_result import ErrorFigures, ZeroReturnResult

TEMPLATE = "zero_return.html.j2"


def zero_return_page(result: ZeroReturnResult) -> str:
    """The page's text. Every value that came from a file is escaped."""
    environment = Environment(loader=PackageLoader("arcref_sim"), autoescape=True, undefined=StrictUndefined)
    return environment.get_template(TEMPLATE).render(
        result=result,
        speed=f"{result.speed_rps:g}",
        verdict="PASS" if result.passed else "FAIL",
        figures=figures(result),
        at_limit=bool(result.flags & Flag.EDGE_SPACING_LIMIT),
        closure_svg=closure_plot(result),
        error_svg=error_plot(result),
        waveform_svg=waveform_plot(result),
        origin=_origin(result),
        provenance_json=json.dumps(result.provenance, indent=2, ensure_ascii=False),
    )


def figures(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """Names and values of the short table that the command prints and the page begins with."""
    turns = sorted(set(result.counts_per_turn))
    spacing = result.shortest_edge_spacing_samples
    counts_per_s = result.speed_rps * COUNTS_PER_TURN
    closure = next(check.found for check in result.checks if "closure" in check.sentence)
    drift = result.zero_drift_counts
    return [
        ("speed", f"{result.speed_rps:g} r/s, {counts_per_s / 1e6:.2f} M counts/s"),
        ("samples", f"{result.sample_rate_hz / 1e6:g} M samples/s, {result.samples_per_count:.2f} to a count"),
        ("turns", f"{result.revolutions} forward, {result.revolutions} reverse, {result.counts:,} counts"),
        ("counts per turn", " .. ".join(f"{turn:,}" for turn in turns[:1] + turns[1:][-1:]) or "no whole turn"),
        ("zero marks seen", f"{len(result.index_passes)} of {2 * (result.revolutions + 1)}"),
        ("closure error, each", closure),
        ("zero drift", "the zero mark did not come back" if drift is None else f"{drift} counts"),
        ("counts lost", f"{result.lost_counts}"),
        ("illegal steps", f"{result.illegal_steps}"),
        ("shortest edge spacing", f"{spacing} sample{'s' * (spacing != 1)}, {result.shortest_edge_spacing_ns:.2f} ns"),
        ("error before correction", _error_text(result.before)),
        ("error after correction", _error_text(result.after)),
        ("corrected, off the fit", f"{result.correction_deviation_counts:.3f} counts at most"),
        ("SPI frames", f"{result.spi_frames} read, {result.spi_frames_wrong} wrong"),
        ("fault flags up", ", ".join(result.faults) or "none"),
        ("simulated", f"{result.counts_per_s / 1e6:.2f} M counts/s, {result.samples_per_s / 1e6:.1f} M samples/s"),
    ]


def _error_text(error: ErrorFigures) -> str:
    if error.readings == 0:
        return "not corrected"
    return f"{error.rms_arcsec:.3f} arcsec rms, {error.max_arcsec:.3f} at most"


def _origin(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """Where ROM and core come from. A ROM's provenance may hold anything, so nothing in it is taken for granted."""
    rom, core = result.provenance["rom"], result.provenance["core"]
    inputs = rom.get("inputs") if isinstance(rom.get("inputs"), list) else []
    files = [f"{entry.get('file')}, SHA-256 {entry.get('sha256')}" for entry in inputs if isinstance(entry, dict)]
    method = rom.get("method") if isinstance(rom.get("method"), dict) else {}
    spread = f", spread {method['spread_deg']} deg" if "spread_deg" in method else ""
    return [
        ("encoder", rom.get("encoder_serial") or "not stated"),
        ("calibration", ", ".join(files) or "not stated"),
        ("method", f"{method['name']}{spread}" if "name" in method else "not stated"),
        ("ROM image", f"CRC-32 {result.provenance['rom_crc32']}"),
        ("core", f"{core['samples_per_word']} samples a word, latency {core['latency_cycles']} clocks"),
        ("arcref", result.provenance["arcref_version"]),
    ]
