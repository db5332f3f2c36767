"""The edge of a board: clocks, pads and samplers. What comes out of it are sample words."""

from amaranth.hdl import ClockDomain, Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.boards.alignment_check import AlignmentPattern
from arcref_gateware.boards.alignment_pattern import SAMPLED_RUNS, SampledPattern, ToggledPattern, toggled_runs
from arcref_gateware.boards.board import ALIGNMENT, SAMPLED_SIGNALS, Board
from arcref_gateware.boards.board_platform import port
from arcref_gateware.boards.clocks_ecp5 import Ecp5Clocks
from arcref_gateware.boards.clocks_ice40 import Ice40Clocks
from arcref_gateware.boards.ddr_sampler import DdrSampler
from arcref_gateware.boards.gearing_sampler import GearingSampler
from arcref_gateware.boards.pattern_clock import pattern_clocks
from arcref_gateware.boards.plain_sampler import PlainSampler
from arcref_gateware.boards.word_clock import word_clock_pll


class BoardEdge(wiring.Component):
    """Drives clock and reset of the domain `word`, and brings a word of each line with every clock of it.

    Elaborates on the platform of `board_platform(board)`.
    """

    def __init__(self, board: Board):
        self.board = board
        lines = (*SAMPLED_SIGNALS, ALIGNMENT)
        super().__init__({name: Out(board.samples_per_word) for name in lines} | {"alignment_drive": In(1)})

    a: Out
    """Samples of A, bit 0 the oldest."""
    b: Out
    """Samples of B, bit 0 the oldest."""
    z: Out
    """Samples of the zero pulse, bit 0 the oldest."""
    strobe: Out
    """Samples of the strobe, bit 0 the oldest."""
    alignment: Out
    """Samples of the alignment pad, bit 0 the oldest; 0 for one sample a word, which needs no check."""
    alignment_drive: In
    """1 while the alignment pad must send its pattern."""

    def elaborate(self, platform):
        m = Module()
        board = self.board
        if board.family == "ecp5":
            m.domains.pattern = ClockDomain(reset_less=True)
            if board.samples_per_word == 4:
                m.domains.edge = ClockDomain(reset_less=True)
            m.submodules.clocks = clocks = Ecp5Clocks(board)
        else:
            m.submodules.clocks = Ice40Clocks(board)
        ports = {name: port(platform, name) for name in SAMPLED_SIGNALS}
        if board.samples_per_word == 1:
            m.submodules.sampler = sampler = PlainSampler(ports)
        else:
            ports[ALIGNMENT] = port(platform, ALIGNMENT)
            if board.family == "ice40":
                m.submodules.sampler = sampler = DdrSampler(ports, (ALIGNMENT,))
                m.submodules.pattern = pattern = SampledPattern()
                m.d.comb += sampler.alignment_out.eq(pattern.samples)
            else:
                m.submodules.sampler = sampler = GearingSampler(ports, board.samples_per_word, (ALIGNMENT,))
                m.submodules.pattern = pattern = ToggledPattern(*pattern_clocks(_pll(board).output_divider))
                m.d.comb += [
                    pattern.drive.eq(self.alignment_drive),
                    sampler.alignment_out.eq(pattern.level),
                    sampler.reset.eq(clocks.gearing_reset),
                ]
            m.d.comb += sampler.alignment_drive.eq(self.alignment_drive)
        for name in ports:
            m.d.comb += getattr(self, name).eq(getattr(sampler, name))
        return m


def alignment_pattern(board: Board) -> AlignmentPattern | None:
    """What the alignment pad of `board` sends; None for one sample a word, which has no order."""
    if board.samples_per_word == 1:
        return None
    if board.family == "ice40":
        return SAMPLED_RUNS
    return toggled_runs(_pll(board), board.samples_per_s)


def _pll(board: Board):
    return word_clock_pll(board.family, board.samples_per_word, board.oscillator_hz, board.word_clock_hz)
