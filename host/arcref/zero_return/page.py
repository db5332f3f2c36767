"""The zero-return test as one HTML page that needs nothing beside itself."""

import json

from jinja2 import Environment, PackageLoader, StrictUndefined

from arcref.angle import COUNTS_PER_TURN, counts_to_deg, format_dms, split_position
from arcref.flags import Flag
from arcref.zero_return.figures import figures
from arcref.zero_return.index_pass import IndexPass
from arcref.zero_return.instrument_parts import NOT_CHECKED, FaultRecord
from arcref.zero_return.plots import closure_plot, error_plot, waveform_plot, way_plot
from arcref.zero_return.result import ZeroReturnResult

TEMPLATE = "zero_return.html.j2"


def zero_return_page(result: ZeroReturnResult) -> str:
    """The page's text. Every value that came from a file or an instrument is escaped."""
    environment = Environment(loader=PackageLoader("arcref.zero_return"), autoescape=True, undefined=StrictUndefined)
    simulated = result.instrument is None
    return environment.get_template(TEMPLATE).render(
        result=result,
        speed=f"{result.speed_rps:g}" if simulated else f"{result.speed_rps:.4g}",
        verdict="PASS" if result.passed else "FAIL",
        figures=figures(result),
        at_limit=bool(result.flags & Flag.EDGE_SPACING_LIMIT),
        closure_svg=closure_plot(result),
        error_svg=error_plot(result.error_over_turn) if simulated else None,
        waveform_svg=waveform_plot(result) if simulated else None,
        way_svg=None if simulated else way_plot(result),
        not_checked=None if simulated else NOT_CHECKED,
        first_homes=simulated or any(index.homes for index in result.index_passes),
        closure_of=_closure_text,
        place_of=_place_text,
        origin=_simulation_origin(result) if simulated else _instrument_origin(result),
        provenance_json=json.dumps(result.provenance, indent=2, ensure_ascii=False),
    )


def _closure_text(index: IndexPass) -> str:
    if index.homes:
        return "homes"
    return "not read alone" if index.closure_error_counts is None else str(index.closure_error_counts)


def _place_text(fault: FaultRecord) -> str:
    turn, angle = split_position(fault.position_counts)
    return f"turn {turn}, {format_dms(counts_to_deg(angle % COUNTS_PER_TURN))}"


def _simulation_origin(result: ZeroReturnResult) -> list[tuple[str, str]]:
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


def _instrument_origin(result: ZeroReturnResult) -> list[tuple[str, str]]:
    """Which instrument was tested, and the calibration that it says it carries."""
    told, rom = result.provenance, result.provenance["rom"]
    trial = ", a trial that is gone at power-off" if told["rom_is_trial"] else ""
    return [
        ("date", told["date"]),
        ("instrument", f"{result.instrument.port}, gateware {told['gateware']}"),
        ("encoder", rom.get("serial", "not stated")),
        ("calibration", f"{rom.get('date', 'not dated')}, expanded uncertainty {rom.get('expanded uncertainty', '?')}"),
        ("method", rom.get("method", "not stated")),
        ("ROM image", f"CRC-32 {told['rom_crc32']}{trial}"),
        ("arcref", told["arcref_version"]),
    ]
