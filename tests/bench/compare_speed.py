"""How fast the core is simulated: natively, as the zero-return test does it, and beside it in plain cocotb.

Both run the same core on the same machine, one right after the other. Timings differ from machine to machine and from
run to run; the ratio is what lasts. Also shows that the native run's cost grows no faster than its samples.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(HERE.parent / "cocotb")]

from cocotb_tools.runner import get_runner  # noqa: E402
from core_under_test import bench_rom, build_core  # noqa: E402
from plain_cocotb import RESULT_VARIABLE, SAMPLES_PER_WORD, WORDS_VARIABLE  # noqa: E402

from arcref.error_curve import ErrorCurve  # noqa: E402
from arcref.radial_basis_network import RadialBasisNetwork  # noqa: E402
from arcref_gateware.core_ports import MODULE_NAME  # noqa: E402
from arcref_sim.zero_return import run_zero_return  # noqa: E402

COCOTB_WORDS = 100_000
TURNS = (1, 2, 10)


def cocotb_samples_per_s() -> float:
    """Samples a second of real time in plain cocotb."""
    core = build_core(SAMPLES_PER_WORD)
    with tempfile.TemporaryDirectory() as place:
        result = Path(place) / "result.json"
        get_runner("verilator").test(
            test_module="plain_cocotb",
            hdl_toplevel=MODULE_NAME,
            hdl_toplevel_lang="verilog",
            build_dir=core,
            test_dir=place,
            extra_env={WORDS_VARIABLE: str(COCOTB_WORDS), RESULT_VARIABLE: str(result), "COCOTB_ANSI_OUTPUT": "0"},
            log_file=Path(place) / "log.txt",
        )
        told = json.loads(result.read_text())
    return told["words"] * SAMPLES_PER_WORD / told["seconds"]


def main() -> None:
    """Print the table."""
    os.chdir(ROOT)
    network = RadialBasisNetwork.fit(ErrorCurve.from_polygon_csv("examples/polygon_before_correction.csv"))
    table = Table("way", "samples", "M samples/s", "times plain cocotb", box=None, pad_edge=False)
    plain = cocotb_samples_per_s()
    table.add_row("plain cocotb", f"{COCOTB_WORDS * SAMPLES_PER_WORD:,}", f"{plain / 1e6:.3f}", "1")
    run_zero_return(bench_rom(), network.evaluate, revolutions=0)  # builds the core
    for turns in TURNS:
        result = run_zero_return(bench_rom(), network.evaluate, revolutions=turns)
        rate = result.samples_per_s
        samples = result.words * result.samples_per_word
        name = f"native, {turns} turn{'s' if turns > 1 else ''} each way, every word checked"
        table.add_row(name, f"{samples:,}", f"{rate / 1e6:.1f}", f"{rate / plain:.0f}")
    Console(width=110, highlight=False).print(table)


if __name__ == "__main__":
    main()
