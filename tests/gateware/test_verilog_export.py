# amaranth: UnusedElaboratable=no
"""The exported Verilog: exactly the promised ports, in name, direction, width and sign."""

import re
from functools import cache

import numpy as np
import pytest

from arcref.correction_rom import CorrectionRom
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.core_ports import CORE_PORTS, MODULE_NAME
from arcref_gateware.latency import LATENCY_CLOCKS
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_gateware.verilog_export import OBSERVED_PORTS, describe_core, export_verilog

DESIGN_INPUTS = {"clk": 1, "rst": 1, "a": 0, "b": 0, "z": 0, "strobe": 0, "spi_sck": 1, "spi_cs_n": 1, "spi_copi": 1}
DESIGN_INPUTS |= {"uart_rx": 1}
DESIGN_OUTPUTS = {
    "raw_position": -48,
    "position": -48,
    "homed": 1,
    "illegal_steps": 16,
    "closure_error": -24,
    "index_count": 16,
    "flags": 8,
    "capture_valid": 1,
    "capture_position": -48,
    "capture_raw": -48,
    "capture_time": 48,
    "spi_cipo": 1,
    "uart_tx": 1,
    "compare": 1,
}
"""Bits of each port as the design document promises them; 0 is one bit a sample, minus a signed one."""


@cache
def core(samples_per_word: int) -> ConnectedEncoder:
    rng = np.random.default_rng(3)
    rom = CorrectionRom(rng.integers(-32768, 32768, 4096), rng.integers(-32768, 32768, 512))
    return ConnectedEncoder(rom, samples_per_word, strobe_delay=4000)


@cache
def text(samples_per_word: int, observed: bool = False) -> str:
    return export_verilog(core(samples_per_word), observed=observed)


def ports_of(verilog: str) -> dict[str, tuple[str, int]]:
    """Direction and width of each port of the module, minus for signed, read from the text."""
    header = re.search(rf"^module {MODULE_NAME}\((.*?)\);(.*?)^endmodule", verilog, re.DOTALL | re.MULTILINE)
    names = [name.strip() for name in header[1].split(",")]
    ports = {}
    for direction, signed, msb, name in re.findall(
        r"^ *(input|output|inout)\s+(signed )?(?:\[(\d+):0\] )?(\S+?);", header[2], re.MULTILINE
    ):
        width = int(msb or 0) + 1
        ports[name] = direction, -width if signed else width
    assert sorted(names) == sorted(ports)
    return ports


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_the_module_has_exactly_the_ports_of_the_design(samples_per_word):
    promised = {name: ("input", width or samples_per_word) for name, width in DESIGN_INPUTS.items()}
    promised |= {name: ("output", width) for name, width in DESIGN_OUTPUTS.items()}
    assert ports_of(text(samples_per_word)) == promised


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_the_list_of_ports_says_the_same_as_the_module(samples_per_word):
    listed = {}
    for port in CORE_PORTS:
        bits = port.bits(samples_per_word)
        listed[port.name] = port.direction, -bits if port.signed else bits
    assert ports_of(text(samples_per_word)) == listed


def test_the_simulation_only_adds_ports():
    # The long simulations run the core alone, without the link.
    alone = ReferenceEncoder(core(4).rom, 4)
    plain, observed = (ports_of(export_verilog(alone, observed=observed)) for observed in (False, True))
    added = {name: observed[name] for name in observed.keys() - plain.keys()}
    assert plain.items() <= observed.items()
    assert added.pop("strobe_delay") == ("input", 16)
    assert set(added) == set(OBSERVED_PORTS)
    assert all(direction == "output" for direction, _ in added.values())


def test_one_module_holds_everything_and_names_no_machine():
    verilog = text(4)
    defined = re.findall(r"^module (\S+?) ?\(", verilog, re.MULTILINE)
    assert defined.count(MODULE_NAME) == 1
    assert len(set(defined)) == len(defined)
    assert "/" + "home" not in verilog
    assert ".py" not in verilog


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_the_description_says_what_the_core_is(samples_per_word):
    description = describe_core(core(samples_per_word))
    assert description["module"] == "arcref_core"
    assert description["samples_per_word"] == samples_per_word
    assert description["latency_cycles"] == LATENCY_CLOCKS <= 24
    assert description["strobe_delay_samples"] == 4000
    assert description["gate_state"] == [1, 1]
    assert description["spi_lowest_clock_ratio"] == 8
    assert description["pending_strobes"] >= 16
    assert description["rom_crc32"] == core(samples_per_word).rom.crc32
    widths = {name: abs(width) for name, (_, width) in ports_of(text(samples_per_word)).items()}
    assert description["ports"] == widths


def test_the_same_core_gives_the_same_text():
    assert export_verilog(ConnectedEncoder(core(4).rom, 4, strobe_delay=4000)) == text(4)
