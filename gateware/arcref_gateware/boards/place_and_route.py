"""From a board's design to a placed, routed and packed one whose timing holds.

Amaranth writes the netlist, the constraints and the commands; they are run here one by one, so that a seed can follow
another and the timing is judged by `timing_report` and not by an exit status. The same inputs give the same bytes:
nothing that depends on the place or the time goes into them.
"""

import json
import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from arcref_gateware.boards.bitstream import board_comment
from arcref_gateware.boards.board import Board
from arcref_gateware.boards.board_platform import board_platform
from arcref_gateware.boards.timing_report import UNCONSTRAINED_MHZ, TimingReport, read_timing_report
from arcref_gateware.memory_attributes import FORGET_INITIAL_VALUES
from arcref_gateware.toolchain import run_tool

DESIGN = "arcref"
"""Name of the top module and of every file."""

TOOLS = {"ice40": ("yosys", "nextpnr-ice40", "icepack"), "ecp5": ("yosys", "nextpnr-ecp5", "ecppack")}

SUFFIX = {"ice40": ".bin", "ecp5": ".bit"}
"""Ending of a bitstream's name."""

STAGES = (
    (re.compile(r"Packing"), "packing", 0.05),
    (re.compile(r"Creating initial|Running main analytical|Placed \d+ cells"), "placing", 0.1),
    (re.compile(r"at iteration #\d+|Running simulated annealing|Running refinement"), "placing", 0.3),
    (re.compile(r"Routing\.\.|Setting up routing"), "routing", 0.6),
    (re.compile(r"Routing complete|Router\d time"), "checking the timing", 0.95),
)
"""What a line of the log says about how far nextpnr is."""

WIRE_DELAY_PS = {"ice40": 1000, "ecp5": 900}
"""What synthesis takes for the delay of a wire, by family. Its own figures are those of the shortest wires; with them
it shares logic over more levels than the real ones bear."""

PLACER_OPTIONS = {"iCE40UP5K": ("--placer-heap-critexp", "4")}
"""By device, where nextpnr's own choice is bettered: an UP5K gains about 3 MHz, others lose."""

MOST_ROUTING_STEPS = 8
"""Steps of the router for each connection, after which a seed is given up: a design that can be routed takes one or
two, and on an iCE40 the router has been seen to go on without end."""

_CONNECTIONS, _ROUTING_STEP = re.compile(r"Routing (\d+) arcs"), re.compile(r"Info:\s+(\d+) \|")

Progress = Callable[[str, float], None]
"""Called with what is being done and the part of all seeds' work that is behind, 0 to 1."""


class TimingFailed(RuntimeError):
    """No seed gave a design whose timing holds; `reports` has what each gave."""

    def __init__(self, text: str, reports: dict[int, TimingReport], log: str):
        super().__init__(text)
        self.reports = reports
        self.log = log


class _NotRouted(RuntimeError):
    """The router went on and on."""


@dataclass(frozen=True)
class PlacedDesign:
    """A design whose timing holds."""

    bitstream: bytes
    report: TimingReport
    seed: int
    log: str
    tried: dict[int, TimingReport | None] = field(default_factory=dict)
    """The report of every seed that was tried, this one the last; None where the router came to no end."""


def place_and_route(board: Board, top, progress: Progress = lambda text, part: None) -> PlacedDesign:
    """Synthesise `top` and try the board's seeds until the timing holds.

    Raises `TimingFailed`; `ToolError` when a tool cannot do its work, for instance when the design does not fit.
    """
    with tempfile.TemporaryDirectory(prefix="arcref-") as folder:
        folder = Path(folder)
        progress("writing the netlist", 0.0)
        platform = board_platform(board)
        plan = platform.prepare(
            top,
            DESIGN,
            emit_src=False,
            script_after_read=_before_synthesis(board.family),
            synth_opts=list(board.synthesis_options),
            nextpnr_opts=[
                *("--report", "report.json", "--freq", str(UNCONSTRAINED_MHZ), "--timing-allow-fail"),
                *PLACER_OPTIONS.get(platform.device, ()),
            ],
        )
        for name, content in plan.files.items():
            (folder / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        synthesis, routing, _ = json.loads(plan.files[f"build_{DESIGN}.json"])["commands"]
        progress("synthesis", 0.0)
        run_tool(synthesis[0], synthesis[1:], folder)
        routing = [argument for argument in routing if argument != "--quiet"]
        tried = {}
        for number, seed in enumerate(board.seeds):
            try:
                log, report = _try_seed(board, routing, seed, folder, number, progress)
            except _NotRouted:
                tried[seed] = None
                continue
            tried[seed] = report
            if report.misuse:
                raise TimingFailed("; ".join(report.problems), {seed: report}, log)
            if not report.missed:
                progress("packing the bitstream", 1.0)
                return PlacedDesign(_pack(board, folder), report, seed, log, tried)
    routed = {seed: report for seed, report in tried.items() if report is not None}
    if not routed:
        raise TimingFailed(f"the router came to no end with any of {len(tried)} seeds", {}, "")
    best = max(routed, key=lambda seed: _margin(routed[seed]))
    seeds = f"seed {best}" if len(tried) == 1 else f"the best of {len(tried)} seeds, {best}"
    text = f"the timing does not hold with {seeds}: {'; '.join(routed[best].missed)}"
    raise TimingFailed(text, routed, log)


def _before_synthesis(family: str) -> str:
    """Yosys commands once the design is read."""
    return f"{FORGET_INITIAL_VALUES}\nscratchpad -set synth_{family}.abc9.W {WIRE_DELAY_PS[family]}"


def _try_seed(board: Board, routing: list[str], seed: int, folder: Path, number: int, progress: Progress):
    stage, connections = 0.0, None

    def follow(line: str) -> None:
        nonlocal stage, connections
        if found := _CONNECTIONS.search(line):
            connections = int(found[1])
        elif connections and (found := _ROUTING_STEP.match(line)) and int(found[1]) > MOST_ROUTING_STEPS * connections:
            raise _NotRouted
        for pattern, text, part in STAGES:
            if part > stage and pattern.search(line):
                stage = part
                progress(f"seed {seed}: {text}", (number + part) / len(board.seeds))

    progress(f"seed {seed}: packing", number / len(board.seeds))
    log = run_tool(routing[0], [*routing[1:], "--seed", str(seed)], folder, follow)
    report = json.loads((folder / "report.json").read_text())
    return log, read_timing_report(report, log, board.family, board.word_clock_hz)


def _pack(board: Board, folder: Path) -> bytes:
    comment = board_comment(board.name)
    target = folder / f"packed{SUFFIX[board.family]}"
    if board.family == "ice40":
        text = folder.joinpath(f"{DESIGN}.asc").read_text()
        # In this text the comment's lines follow the keyword's own line.
        (folder / "commented.asc").write_text(re.sub(r"\A\.comment[^\n]*\n", f".comment\n{comment}\n", text))
        run_tool("icepack", ["commented.asc", target.name], folder)
    else:
        text = folder.joinpath(f"{DESIGN}.config").read_text()
        (folder / "commented.config").write_text(f"{text.rstrip()}\n\n.comment {comment}\n")
        run_tool("ecppack", ["--input", "commented.config", "--bit", target.name], folder)
    return target.read_bytes()


def _margin(report: TimingReport) -> float:
    """By how much the worst clock reaches its constraint; below 1 it does not."""
    return min(clock.reached_hz / clock.constraint_hz for clock in report.clocks)
