"""The core as Verilog, with exactly the ports of `core_ports`, and `core.json` beside it."""

from amaranth.back import verilog

from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.core_ports import CORE_PORTS, MODULE_NAME
from arcref_gateware.latency import FIRST_CORRECTED_WORD, LATENCY_CLOCKS
from arcref_gateware.pending_strobes import PENDING_STROBES
from arcref_gateware.position_spi import LOWEST_CLOCK_RATIO
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_gateware.toolchain import use_installed_yosys

Core = ReferenceEncoder | ConnectedEncoder
"""What can be exported: the core alone, as the long simulations run it, or with its wire, as users get it."""

OBSERVED_PORTS = ("shortest_edge_spacing", "largest_closure_error", "first_illegal_position", "first_illegal_time")
"""Outputs of the core that no port of `arcref_core` shows yet; the simulation may have them added."""


def port_names(core: Core, *, observed: bool = False) -> list[str]:
    """Names of the exported ports other than clock and reset. `observed` adds what the simulation looks at.

    The core alone has no UART and no compare output.
    """
    names = [port.name for port in CORE_PORTS if port.name in core.signature.members]
    return names + (["strobe_delay", *OBSERVED_PORTS] if observed else [])


def export_verilog(core: Core, *, observed: bool = False) -> str:
    """Verilog text of module `arcref_core`.

    `observed` adds outputs for the simulation, and `strobe_delay` as an input, so that one build serves every delay.
    """
    use_installed_yosys()
    ports = [getattr(core, name) for name in port_names(core, observed=observed)]
    return verilog.convert(core, name=MODULE_NAME, ports=ports, emit_src=False, strip_internal_attrs=True)


def describe_core(core: Core, *, observed: bool = False) -> dict:
    """Contents of `core.json`: the parameters of this core, its latency and its ports."""
    widths = {name: len(getattr(core, name)) for name in port_names(core, observed=observed)}
    return {
        "module": MODULE_NAME,
        "samples_per_word": core.samples_per_word,
        "latency_cycles": LATENCY_CLOCKS,
        "capture_latency_cycles": LATENCY_CLOCKS,
        "strobe_delay_samples": core.strobe_delay_init,
        "pending_strobes": PENDING_STROBES,
        "gate_state": list(core.gate_state_init),
        "spi_lowest_clock_ratio": LOWEST_CLOCK_RATIO,
        "first_corrected_word": FIRST_CORRECTED_WORD,
        "rom_crc32": core.rom.crc32,
        "ports": {"clk": 1, "rst": 1} | widths,
    }
