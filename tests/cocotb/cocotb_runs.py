"""Runs the benches in the simulator and hands each cocotb test's outcome to pytest."""

import ast
import os
import xml.etree.ElementTree as ElementTree
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

from cocotb_tools.runner import get_runner
from core_under_test import SAMPLES_VARIABLE, build_core

from arcref_gateware.core_ports import MODULE_NAME

FOLDER = Path(__file__).parent

LINKED_BENCHES = {"bench_spi_registers"}
"""Benches of the core with its wire; the others are of the core alone."""

BENCHES = sorted(path.stem for path in FOLDER.glob("bench_*.py"))


def names_of_tests(bench: str) -> list[str]:
    """Names of the cocotb tests of a bench, read from its text: it can be imported in a simulator only."""
    tree = ast.parse((FOLDER / f"{bench}.py").read_text(encoding="utf-8"))
    functions = [node for node in tree.body if isinstance(node, ast.AsyncFunctionDef)]
    return [
        function.name
        for function in functions
        if any(ast.unparse(decorator).startswith("cocotb.test") for decorator in function.decorator_list)
    ]


def run_bench(bench: str, samples_per_word: int, core: Path) -> dict[str, str]:
    """Run a bench on the simulator in folder `core`; returns each test's failure by name, empty when it passed.

    A simulator that ends too early leaves out the tests it did not reach; `log` holds the end of its output.
    """
    place = core / "runs" / bench
    place.mkdir(parents=True, exist_ok=True)
    results, log = place / "results.xml", place / "log.txt"
    results.unlink(missing_ok=True)
    # The runner exits when a test fails, and raises when the simulator does; what failed stands in the results.
    with suppress(SystemExit, RuntimeError):
        get_runner("verilator").test(
            test_module=bench,
            hdl_toplevel=MODULE_NAME,
            hdl_toplevel_lang="verilog",
            build_dir=core,
            test_dir=place,
            results_xml=str(results),
            extra_env={SAMPLES_VARIABLE: str(samples_per_word), "COCOTB_ANSI_OUTPUT": "0"},
            log_file=log,
            seed=1,
        )
    outcome = {"log": log.read_text(errors="replace")[-3000:] if log.exists() else ""}
    if results.exists():
        for case in ElementTree.parse(results).iter("testcase"):
            failure = next((part for part in case if part.tag in ("failure", "error", "skipped")), None)
            outcome[case.get("name")] = "" if failure is None else _describe(failure)
    return outcome


def _describe(failure) -> str:
    parts = [failure.tag, failure.get("error_type"), failure.get("message"), failure.get("error_msg"), failure.text]
    return "\n".join(part for part in parts if part)


class BenchRuns:
    """All the runs of a session: builds first, then the benches, no more at a time than there are processors."""

    def __init__(self, needed: set[tuple[str, int]]):
        """`needed` are pairs of bench and word size."""
        self._pool = ThreadPoolExecutor(os.cpu_count())
        kinds = sorted({(size, bench in LINKED_BENCHES) for bench, size in needed})
        cores = {(size, linked): self._pool.submit(build_core, size, linked=linked) for size, linked in kinds}
        # A run waits for its core inside the pool; all builds were started before, so none can wait for ever.
        self._runs = {
            (bench, size): self._pool.submit(self._run, bench, size, cores[size, bench in LINKED_BENCHES])
            for size, bench in sorted((size, bench) for bench, size in needed)
        }

    @staticmethod
    def _run(bench: str, size: int, core: Future) -> dict[str, str]:
        return run_bench(bench, size, core.result())

    def outcome(self, bench: str, size: int) -> dict[str, str]:
        """What `run_bench` returned; waits for it."""
        return self._runs[bench, size].result()

    def stop(self) -> None:
        """Forget the runs that have not begun."""
        self._pool.shutdown(cancel_futures=True)
