"""How the exported core meets the C++ harness: a Verilog module around it, and its ports as C++."""

from arcref_gateware.core_ports import CORE_PORTS, MODULE_NAME

TOP_MODULE = "top"

MODEL = "Vcore"
"""Name of the C++ class that Verilator makes."""

CLOCK_MEMORY = "__Vtrigprevexpr___TOP__clk__0"
"""Where Verilator's model keeps the clock's level of the evaluation before."""


def input_ports(description: dict) -> list[str]:
    """Names of the core's inputs: those of the promised ports, and what the simulation had added."""
    promised = {port.name: port.direction for port in CORE_PORTS}
    return [name for name in description["ports"] if promised.get(name) == "input" or name == "strobe_delay"]


def output_ports(description: dict) -> list[str]:
    """Names of the core's outputs in the order of the harness."""
    inputs = input_ports(description)
    return [name for name in description["ports"] if name not in inputs]


def simulation_top(description: dict, *, with_reset: bool) -> str:
    """Verilog of a module with the core's ports. Without reset the core starts from its power-up values."""
    inputs = input_ports(description)
    ports = {name: width for name, width in description["ports"].items() if with_reset or name != "rst"}
    declared = [
        f"    {'input' if name in inputs else 'output'} wire [{width - 1}:0] {name}" for name, width in ports.items()
    ]
    connected = [f"        .{name}({name})" for name in ports]
    if not with_reset:
        connected.append("        .rst(1'b0)")
    core = f"    {MODULE_NAME} core (\n" + ",\n".join(connected) + "\n    );"
    return f"module {TOP_MODULE} (\n" + ",\n".join(declared) + f"\n);\n{core}\nendmodule\n"


def harness_ports(description: dict, plain: bool) -> str:
    """C++ of `core_ports.inc`: the ports of this core, and how the harness clocks it.

    `plain` evaluates both edges through Verilator's public call and keeps the reset port.
    """
    lines = [f'#include "{MODEL}.h"', f'#include "{MODEL}___024root.h"', "#include <cstdint>", "#include <cstring>"]
    lines += [f"using Model = {MODEL};", f"using Pins = {MODEL}___024root;"]
    lines += [f"constexpr int SAMPLES_PER_WORD = {description['samples_per_word']};"]
    if plain:
        lines += ["#define HAS_RESET"]
        lines += ["inline void eval_clock(Model& m) { m.clk = 1; m.eval(); m.clk = 0; m.eval(); }"]
    else:
        # One evaluation a clock: the model is told that the clock was low, in place of evaluating a falling edge at
        # which nothing happens. The call spares what Verilator does around it for $display and threads.
        lines += [f"void {MODEL}___024root___eval({MODEL}___024root*);"]
        lines += ["inline void eval_clock(Model& m) {", f"    m.rootp->{CLOCK_MEMORY} = 0;", "    m.rootp->clk = 1;"]
        lines += [f"    {MODEL}___024root___eval(m.rootp);", "}"]
    readers = [f"    [](const Pins& pins) -> uint64_t {{ return pins.{name}; }}," for name in output_ports(description)]
    lines += ["constexpr uint64_t (*OUTPUT_PORTS[])(const Pins&) = {", *readers, "};"]
    lines += ["inline int set_input_port(Pins& pins, const char* name, uint64_t value) {"]
    driven = ("clk", "rst", "a", "b", "z", "strobe")
    settable = [name for name in input_ports(description) if name not in driven]
    lines += [f'    if (!std::strcmp(name, "{name}")) return pins.{name} = value, 1;' for name in settable]
    return "\n".join([*lines, "    return 0;", "}", ""])
