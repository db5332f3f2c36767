"""The whole design for a board: its edge, and the instrument behind it."""

from amaranth.hdl import Module, ResetSignal
from amaranth.lib import io, wiring

from arcref.correction_rom import CorrectionRom
from arcref_gateware.boards.board import ALIGNMENT, SAMPLED_SIGNALS, Board
from arcref_gateware.boards.board_edge import BoardEdge, alignment_pattern
from arcref_gateware.boards.board_platform import port
from arcref_gateware.boards.instrument import Instrument
from arcref_gateware.boards.word_domains import add_word_domains

INSTRUMENT_PINS = (
    "spi_sck",
    "spi_cs_n",
    "spi_copi",
    "spi_cipo",
    "uart_rx",
    "uart_tx",
    "compare",
    "led_homed",
    "led_fault",
    "led_heartbeat",
)
"""Signals of the instrument that go to a pad as they are."""


class BoardTop(wiring.Component):
    """The design that is built for `board`, with the correction `rom`, or None for one that gets its ROM later.

    `self_test`, a `SelfTest`, puts a square-wave generator in place of the encoder. `strobe_delay` is the delay at
    power-up in sample periods. Elaborates on the platform of `board_platform(board)`.
    """

    def __init__(self, board: Board, rom: CorrectionRom | None, *, self_test=None, strobe_delay: int = 0):
        self.board = board
        self.instrument = Instrument(
            rom,
            board.samples_per_word,
            board.word_clock_hz,
            pattern=alignment_pattern(board),
            self_test=self_test,
            strobe_delay=strobe_delay,
            has_link=board.has_link,
            baud=board.baud,
            capture_depth=board.capture_depth,
        )
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        add_word_domains(m)
        m.submodules.board_edge = edge = BoardEdge(self.board)
        m.submodules.instrument = instrument = self.instrument
        m.d.comb += [ResetSignal("sync").eq(instrument.hold), edge.alignment_drive.eq(instrument.alignment_drive)]
        for name in (*SAMPLED_SIGNALS, ALIGNMENT):
            m.d.comb += getattr(instrument, name).eq(getattr(edge, name))
        for name in INSTRUMENT_PINS:
            pin = self.board.pins.get(name)
            if pin is not None:
                m.submodules[f"{name}_pad"] = buffer = io.Buffer(pin.direction, port(platform, name))
                signal = getattr(instrument, name)
                m.d.comb += buffer.o.eq(signal) if pin.direction == "o" else signal.eq(buffer.i)
        return m
