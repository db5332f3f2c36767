"""How the exported core meets the C++ harness: a Verilog module around it, and its ports as C++."""

import re

from arcref_gateware.core_ports import CORE_PORTS, MODULE_NAME

TOP_MODULE = "top"

MODEL = "Vcore"
"""Name of the C++ class that Verilator makes."""

FAST_PART = f"{MODEL}___024root__0.cpp"
"""The model's file with the code that runs at every clock."""

RESTING_BLOCKS = ("rom_check", "spi", "strobe_delay", "capture")
"""Blocks of the core that have nothing to do for long stretches: the power-up check once it is over, the SPI port while
chip select is high, the strobe and its captures while there is none. They are 40 % of the model's code, and the harness
spares it by not clocking them. The build `plain` clocks everything, and the tests hold one against the other."""


def clock_memory(clock: str) -> str:
    """Where Verilator's model keeps a clock's level of the evaluation before."""
    return f"__Vtrigprevexpr___TOP__{clock}__0"


def with_own_clocks(verilog: str) -> str:
    """The core's Verilog with a clock of its own, `clk_NAME`, for each of the resting blocks.

    Raises ValueError when a block is not where it is looked for.
    """
    for block in RESTING_BLOCKS:
        instance = rf"(\n  \\{MODULE_NAME}\.{block}(?:\$\d+)? +\\?{block}\S* *\(\n[^;]*?\.clk\()clk(\))"
        verilog, found = re.subn(instance, rf"\1clk_{block}\2", verilog)
        if found != 1:
            raise ValueError(f"the core's Verilog has {found} blocks {block}, one was expected")
    head = f"module {MODULE_NAME}("
    clocks = [f"clk_{block}" for block in RESTING_BLOCKS]
    start, declared = verilog.index(head), "\n  input clk;\n"
    before, inside = verilog[:start], verilog[start + len(head) :]
    inputs = "".join(f"  input {clock};\n  wire {clock};\n" for clock in clocks)
    return before + head + ", ".join(clocks) + ", " + inside.replace(declared, declared + inputs, 1)


def input_ports(description: dict) -> list[str]:
    """Names of the core's inputs: those of the promised ports, and what the simulation had added."""
    promised = {port.name: port.direction for port in CORE_PORTS}
    return [name for name in description["ports"] if promised.get(name) == "input" or name == "strobe_delay"]


def output_ports(description: dict) -> list[str]:
    """Names of the core's outputs in the order of the harness."""
    inputs = input_ports(description)
    return [name for name in description["ports"] if name not in inputs]


def simulation_top(description: dict, *, plain: bool, resting: tuple[str, ...] = RESTING_BLOCKS) -> str:
    """Verilog of a module with the core's ports. Unless `plain`, the core starts from its power-up values without
    a reset port, and the blocks `resting` have their own clocks.
    """
    inputs = input_ports(description)
    ports = {name: width for name, width in description["ports"].items() if plain or name != "rst"}
    if not plain:
        ports |= {f"clk_{block}": 1 for block in resting}
        inputs = [*inputs, *(f"clk_{block}" for block in resting)]
    declared = [
        f"    {'input' if name in inputs else 'output'} wire [{width - 1}:0] {name}" for name, width in ports.items()
    ]
    connected = [f"        .{name}({name})" for name in ports]
    if not plain:
        connected.append("        .rst(1'b0)")
    core = f"    {MODULE_NAME} core (\n" + ",\n".join(connected) + "\n    );"
    return f"module {TOP_MODULE} (\n" + ",\n".join(declared) + f"\n);\n{core}\nendmodule\n"


def harness_ports(description: dict, *, plain: bool, resting: tuple[str, ...] = RESTING_BLOCKS) -> str:
    """C++ of `core_ports.inc`: the ports of this core, and how the harness clocks it.

    `plain` evaluates both edges through Verilator's public call and keeps the reset port.
    """
    lines = [f'#include "{MODEL}.h"', f'#include "{MODEL}___024root.h"']
    lines += [f'#define MODEL_SOURCE "{FAST_PART}"', f"using Model = {MODEL};", f"using Pins = {MODEL}___024root;"]
    lines += [f"constexpr int SAMPLES_PER_WORD = {description['samples_per_word']};"]
    lines += [f"constexpr int64_t FIRST_CORRECTED_WORD = {description['first_corrected_word']};"]
    runs = "".join(f", bool {block}_runs" for block in resting)
    if plain:
        lines += ["#define HAS_RESET"]
        lines += ["inline void eval_clock(Model& model" + "".join(f", bool /*{b}*/" for b in resting) + ") {"]
        lines += ["    model.clk = 1;", "    model.eval();", "    model.clk = 0;", "    model.eval();", "}"]
    else:
        # One evaluation a clock: the model is told that a clock was low before, in place of evaluating a falling edge
        # at which nothing happens. A clock that was high before has no rising edge, and its block rests. The inner
        # call spares what Verilator's public one does for $display and threads.
        lines += [f"void {MODEL}___024root___eval({MODEL}___024root*);"]
        lines += [f"inline void eval_clock(Model& model{runs}) {{", "    Pins& pins = *model.rootp;"]
        lines += [f"    pins.{clock_memory('clk')} = 0;"]
        lines += [f"    pins.{clock_memory(f'clk_{block}')} = !{block}_runs;" for block in resting]
        lines += [f"    {MODEL}___024root___eval(&pins);", "}"]
    lines += ["inline void raise_clocks(Pins& pins) {"]
    clocks = [] if plain else ["clk", *(f"clk_{block}" for block in resting)]
    lines += ["    (void)pins;", *(f"    pins.{clock} = 1;" for clock in clocks), "}"]
    readers = [f"    [](const Pins& pins) -> uint64_t {{ return pins.{name}; }}," for name in output_ports(description)]
    lines += ["constexpr uint64_t (*OUTPUT_PORTS[])(const Pins&) = {", *readers, "};"]
    lines += ["inline int set_input_port(Pins& pins, const char* name, uint64_t value) {"]
    driven = ("clk", "rst", "a", "b", "z", "strobe")
    settable = [name for name in input_ports(description) if name not in driven]
    lines += [f'    if (!std::strcmp(name, "{name}")) return pins.{name} = value, 1;' for name in settable]
    return "\n".join([*lines, "    return 0;", "}", ""])
