"""Clocks of an ECP5 board: oscillator -> EHXPLLL -> word clock, through the edge clock when four samples make a word.

four samples a word:  CLKOP -> ECLKSYNCB -> edge clock -> CLKDIVF / 2 -> word clock
one or two:           CLKOP -> word clock
"""

from amaranth.hdl import ClockDomain, ClockSignal, Const, Instance, Module, Signal
from amaranth.lib import io, wiring
from amaranth.lib.cdc import ResetSynchronizer
from amaranth.lib.wiring import Out

from arcref_gateware.boards.board import Board
from arcref_gateware.boards.constrained_clock import constrained_clock
from arcref_gateware.boards.pattern_clock import pattern_divider
from arcref_gateware.boards.start_up import StartUp
from arcref_gateware.boards.word_clock import word_clock_pll


class Ecp5Clocks(wiring.Component):
    """Drives the clocks of the domains `word`, `pattern` and, for four samples a word, `edge`.

    `word` is in reset until everything has started; the others have no reset.
    """

    def __init__(self, board: Board):
        self.board = board
        super().__init__({"gearing_reset": Out(1), "ready": Out(1)})

    gearing_reset: Out
    """Reset of the input gearing, released while the edge clock stands still."""
    ready: Out
    """1 when the start-up sequence is through."""

    def elaborate(self, platform):
        m = Module()
        board = self.board
        pll = word_clock_pll(board.family, board.samples_per_word, board.oscillator_hz, board.word_clock_hz)
        divider = pattern_divider(pll.output_divider)

        oscillator = constrained_clock(platform, "oscillator_clock", board.oscillator_hz)
        m.submodules.oscillator = pad = io.Buffer("i", platform.request(platform.default_clk, dir="-"))
        m.d.comb += oscillator.eq(pad.i)
        m.domains.start = start = ClockDomain(reset_less=True)
        word_clock = constrained_clock(platform, "word_clock", board.word_clock_hz)
        pattern_clock = constrained_clock(platform, "pattern_clock", pll.vco_hz / divider)
        m.d.comb += [
            start.clk.eq(oscillator),
            ClockSignal("pattern").eq(pattern_clock),
            ClockSignal("word").eq(word_clock),
        ]

        geared = board.samples_per_word == 4
        pll_clock = constrained_clock(platform, "pll_clock", pll.output_hz) if geared else word_clock
        locked = Signal()
        m.submodules.pll = Instance(
            "EHXPLLL",
            a_FREQUENCY_PIN_CLKI=str(pll.reference_hz / 1e6),
            a_FREQUENCY_PIN_CLKOP=str(pll.output_hz / 1e6),
            a_FREQUENCY_PIN_CLKOS=str(pll.vco_hz / divider / 1e6),
            a_ICP_CURRENT="12",
            a_LPF_RESISTOR="8",
            p_PLLRST_ENA="DISABLED",
            p_INTFB_WAKE="DISABLED",
            p_STDBY_ENABLE="DISABLED",
            p_DPHASE_SOURCE="DISABLED",
            p_OUTDIVIDER_MUXA="DIVA",
            p_OUTDIVIDER_MUXB="DIVB",
            p_CLKI_DIV=pll.reference_divider,
            p_CLKFB_DIV=pll.feedback_divider,
            p_FEEDBK_PATH="CLKOP",
            p_CLKOP_ENABLE="ENABLED",
            p_CLKOP_DIV=pll.output_divider,
            p_CLKOP_CPHASE=pll.output_divider - 1,
            p_CLKOP_FPHASE=0,
            p_CLKOS_ENABLE="ENABLED",
            p_CLKOS_DIV=divider,
            p_CLKOS_CPHASE=divider - 1,
            p_CLKOS_FPHASE=0,
            i_CLKI=oscillator,
            i_CLKFB=pll_clock,
            i_RST=Const(0),
            i_STDBY=Const(0),
            i_PHASESEL0=Const(0),
            i_PHASESEL1=Const(0),
            i_PHASEDIR=Const(0),
            i_PHASESTEP=Const(0),
            i_PHASELOADREG=Const(0),
            i_PLLWAKESYNC=Const(0),
            i_ENCLKOP=Const(0),
            i_ENCLKOS=Const(0),
            o_CLKOP=pll_clock,
            o_CLKOS=pattern_clock,
            o_LOCK=locked,
        )

        m.submodules.start_up = start_up = StartUp(board.oscillator_hz)
        m.d.comb += [
            start_up.locked.eq(locked),
            self.gearing_reset.eq(start_up.gearing_reset),
            self.ready.eq(start_up.ready),
        ]

        if geared:
            edge_clock = constrained_clock(platform, "edge_clock", pll.output_hz)
            m.d.comb += ClockSignal("edge").eq(edge_clock)
            m.submodules.edge_clock = Instance("ECLKSYNCB", i_ECLKI=pll_clock, i_STOP=start_up.stop, o_ECLKO=edge_clock)
            m.submodules.word_clock = Instance(
                "CLKDIVF",
                p_DIV="2.0",
                p_GSR="DISABLED",
                i_CLKI=edge_clock,
                i_RST=start_up.gearing_reset,
                i_ALIGNWD=Const(0),
                o_CDIVX=word_clock,
            )
        m.submodules.word_reset = ResetSynchronizer(~start_up.ready, domain="word")
        return m
