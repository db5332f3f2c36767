"""Clocks of an iCE40 board: oscillator -> SB_PLL40 -> word clock."""

from amaranth.hdl import ClockDomain, ClockSignal, Const, Instance, Module, ResetSignal, Signal
from amaranth.lib import io, wiring
from amaranth.lib.cdc import AsyncFFSynchronizer
from amaranth.lib.wiring import Out

from arcref_gateware.boards.board import Board
from arcref_gateware.boards.constrained_clock import constrained_clock
from arcref_gateware.boards.pin_tables import package_balls
from arcref_gateware.boards.start_up import StartUp
from arcref_gateware.boards.word_clock import word_clock_pll


class Ice40Clocks(wiring.Component):
    """Drives the clock of the domain `word`, and its reset until everything has started.

    An oscillator on the pad of a PLL feeds that PLL directly (SB_PLL40_PAD), another one through the fabric.
    """

    def __init__(self, board: Board):
        self.board = board
        super().__init__({"ready": Out(1)})

    ready: Out
    """1 when the start-up sequence is through."""

    def elaborate(self, platform):
        m = Module()
        board = self.board
        pll = word_clock_pll(board.family, board.samples_per_word, board.oscillator_hz, board.word_clock_hz)
        port = platform.request(platform.default_clk, dir="-")
        word_clock = constrained_clock(platform, "word_clock", board.word_clock_hz)
        oscillator = constrained_clock(platform, "oscillator_clock", board.oscillator_hz)
        m.domains.start = start = ClockDomain(reset_less=True)
        m.d.comb += [start.clk.eq(oscillator), ClockSignal("word").eq(word_clock)]
        locked = Signal()
        settings = {
            "p_DIVR": Const(pll.divr, 4),
            "p_DIVF": Const(pll.divf, 7),
            "p_DIVQ": Const(pll.divq, 3),
            "p_FILTER_RANGE": Const(pll.filter_range, 3),
            "p_FEEDBACK_PATH": "SIMPLE",
            "i_RESETB": Const(1),
            "i_BYPASS": Const(0),
            "o_LOCK": locked,
        }
        if package_balls(board.device, board.package)[board.oscillator_ball].pll_reference:
            m.submodules.pll = Instance(
                "SB_PLL40_2_PAD",
                **settings,
                i_PACKAGEPIN=port.io,
                o_PLLOUTGLOBALA=oscillator,
                o_PLLOUTGLOBALB=word_clock,
                p_PLLOUT_SELECT_PORTB="GENCLK",
            )
        else:
            m.submodules.oscillator = pad = io.Buffer("i", port)
            m.d.comb += oscillator.eq(pad.i)
            m.submodules.pll = Instance(
                "SB_PLL40_CORE",
                **settings,
                i_REFERENCECLK=oscillator,
                o_PLLOUTGLOBAL=word_clock,
                p_PLLOUT_SELECT="GENCLK",
            )
        m.submodules.start_up = start_up = StartUp(board.oscillator_hz)
        m.d.comb += [start_up.locked.eq(locked), self.ready.eq(start_up.ready)]
        # Its registers are 0 at power-up: behind the last 1 of the synchroniser there is an inverter, and behind that
        # a register, so that the reset has a clock for the way across the chip.
        released = Signal()
        m.submodules.word_reset = AsyncFFSynchronizer(~start_up.ready, released, o_domain="word")
        word_reset = Signal(reset_less=True)
        m.d.word += word_reset.eq(released)
        m.d.comb += ResetSignal("word").eq(word_reset)
        return m
