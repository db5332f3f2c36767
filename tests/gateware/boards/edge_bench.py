"""A board's edge with models of Lattice's primitives, in Verilator: pads in, sample words and the verdict out."""

import subprocess
from pathlib import Path

import numpy as np
from amaranth.back import verilog
from amaranth.hdl import Cat, ClockSignal, DomainRenamer, Elaboratable, Fragment, Module, ResetSignal, Signal

from arcref_gateware.boards.alignment_check import AlignmentCheck
from arcref_gateware.boards.board import ALIGNMENT, SAMPLED_SIGNALS, Board
from arcref_gateware.boards.board_edge import BoardEdge, alignment_pattern
from arcref_gateware.boards.board_platform import RESOURCE_PREFIX, board_platform
from arcref_gateware.boards.word_domains import add_word_domains
from arcref_gateware.toolchain import use_installed_yosys
from arcref_sim.verilator_build import verilator_command, verilator_environment

HERE = Path(__file__).parent
LINES = (*SAMPLED_SIGNALS, ALIGNMENT)

BENCH = """
`timescale 1ps/1ps
module bench;
    reg oscillator = 0;
    always #({half_period_ps}) oscillator = ~oscillator;
    reg [3:0] pads = 0;
    wire loop;
    wire [{top}:0] words;
    wire word_clock, passed, failed;
    wire sample_clock = {sample_clock};
    top dut (.{oscillator}(oscillator), .{a}(pads[0]), .{b}(pads[1]), .{z}(pads[2]), .{strobe}(pads[3]),
             .{alignment}(loop), .words(words), .word_clock(word_clock),
             .passed(passed), .failed(failed));

    // Each line changes at random, never near an edge of the sample clock, so that every sample is certain.
    reg [31:0] noise = {seed};
    always @(sample_clock) begin
        $display("s %b", pads);
        #({sample_ps} / 2);
        noise = noise ^ (noise << 13);
        noise = noise ^ (noise >> 17);
        noise = noise ^ (noise << 5);
        pads = pads ^ {{noise[9:8] == 0, noise[7:6] == 0, noise[3], noise[1]}};
    end
    always @(posedge word_clock) begin
        #1 $display("w %b %b%b", words, passed, failed);
        if (passed || failed) after = after + 1;
        if (after == 40) $finish;
    end
    integer after = 0;
    initial begin #({limit_ps}) $display("timeout"); $finish; end
endmodule
"""


class _EdgeTop(Elaboratable):
    """The edge and the alignment check as one module with everything of interest as ports."""

    def __init__(self, board: Board):
        self.board = board
        self.words = Signal(len(LINES) * board.samples_per_word, name="words")
        self.word_clock = Signal(name="word_clock")
        self.passed = Signal(name="passed")
        self.failed = Signal(name="failed")
        self.ports = [self.words, self.word_clock, self.passed, self.failed]

    def elaborate(self, platform):
        m = Module()
        board = self.board
        add_word_domains(m)
        m.submodules.board_edge = edge = BoardEdge(board)
        check = AlignmentCheck(board.samples_per_word, alignment_pattern(board))
        m.submodules.check = DomainRenamer("word")(check)
        m.d.comb += [
            ResetSignal("sync").eq(0),
            self.words.eq(Cat(getattr(edge, name) for name in LINES)),
            self.word_clock.eq(ClockSignal("word")),
            check.word.eq(edge.alignment),
            edge.alignment_drive.eq(check.drive),
            self.passed.eq(check.passed),
            self.failed.eq(check.failed),
        ]
        return m


def edge_verilog(board: Board) -> str:
    """Verilog of the edge of `board`, module `top`."""
    use_installed_yosys()
    platform = board_platform(board)
    top = _EdgeTop(board)
    fragment = Fragment.get(top, platform)
    ports = top.ports
    return verilog.convert(fragment, name="top", ports=ports, platform=platform, emit_src=False)


class EdgeBench:
    """The bench of one board, compiled once."""

    def __init__(self, board: Board, folder: Path, seed: int = 1):
        self.board = board
        text = edge_verilog(board)
        port_names = {name: f"{RESOURCE_PREFIX}{name}_0__io" for name in LINES}
        oscillator = next(line.split()[-1].strip(";") for line in text.splitlines() if _is_oscillator(line, port_names))
        bench = BENCH.format(
            half_period_ps=f"{0.5e12 / board.oscillator_hz:.3f}",
            sample_ps=f"{1e12 / board.samples_per_s:.3f}",
            limit_ps=200_000_000,
            top=len(LINES) * board.samples_per_word - 1,
            oscillator=oscillator,
            sample_clock="dut.board_edge.clocks.edge_clock" if board.samples_per_word == 4 else "word_clock",
            seed=seed,
            **port_names,
        )
        primitives = (HERE / f"lattice_{board.family}.v").read_text(encoding="utf-8")
        for file, content in {"top.v": text, "bench.v": bench, "primitives.v": primitives}.items():
            (folder / file).write_text(content, encoding="utf-8")
        command, root = verilator_command()
        options = ["--binary", "--timing", "-Wno-fatal", "-Wno-lint", "-O1", "--Mdir", "obj", "-o", "bench"]
        subprocess.run(
            [*command, *options, "--top-module", "bench", "bench.v", "top.v", "primitives.v"],
            cwd=folder,
            env=verilator_environment(root),
            check=True,
            capture_output=True,
        )
        self.executable = folder / "obj" / "bench"

    def run(self, *faults: str) -> "EdgeRun":
        """Run from power-up until the alignment check has its verdict, with `faults` of the models ("+order=123")."""
        output = subprocess.run([self.executable, *faults], capture_output=True, text=True, check=True).stdout
        return EdgeRun(output.splitlines(), self.board.samples_per_word)


class EdgeRun:
    """One run: `samples` of the pads at each edge of the sample clock, `words` by line, and the verdict.

    Words are rows of samples, the oldest first. `passed` and `failed` are what the alignment check says at the end.
    """

    def __init__(self, lines: list[str], samples_per_word: int):
        samples = np.array([[int(bit) for bit in line[2:]] for line in lines if line.startswith("s ")])
        self.samples = {name: samples[:, -1 - k] for k, name in enumerate(SAMPLED_SIGNALS)}
        rows = [line.split() for line in lines if line.startswith("w ")]
        bits = np.array([[int(bit) for bit in row[1][::-1]] for row in rows])
        bits = bits.reshape(len(rows), len(LINES), samples_per_word)
        self.words = {name: bits[:, k] for k, name in enumerate(LINES)}
        self.passed, self.failed = (rows[-1][2][k] == "1" for k in range(2))
        self.timed_out = "timeout" in lines

    def offset(self, name: str, words: int = 500) -> int | None:
        """Where in the samples of the pad the last `words` words of a line are; None when nowhere, or not as they are.

        Counted from the end, so that two lines that are delayed alike have the same offset.
        """
        stream = "".join(map(str, self.words[name][-words:].ravel()))
        found = "".join(map(str, self.samples[name])).find(stream)
        return None if found < 0 else len(self.samples[name]) - found - len(stream)


def _is_oscillator(line: str, port_names: dict) -> bool:
    words = line.split()
    return (
        words[:1] in (["input"], ["inout"])
        and words[-1].endswith("__io;")
        and words[-1][:-1] not in port_names.values()
    )
