"""The whole design for a board: clocks, pads, samplers and the instrument behind them."""

from amaranth.hdl import Module, ResetSignal
from amaranth.lib import io, wiring

from arcref.correction_rom import CorrectionRom
from arcref_gateware.boards.alignment_pattern import SampledPattern, ToggledPattern
from arcref_gateware.boards.board import ALIGNMENT, SAMPLED_SIGNALS, Board
from arcref_gateware.boards.board_platform import port
from arcref_gateware.boards.clocks_ecp5 import Ecp5Clocks
from arcref_gateware.boards.clocks_ice40 import Ice40Clocks
from arcref_gateware.boards.ddr_sampler import DdrSampler
from arcref_gateware.boards.gearing_sampler import GearingSampler
from arcref_gateware.boards.instrument import Instrument
from arcref_gateware.boards.pattern_clock import RUN_SAMPLES, pattern_divider
from arcref_gateware.boards.plain_sampler import PlainSampler
from arcref_gateware.boards.word_clock import word_clock_pll
from arcref_gateware.boards.word_domains import add_word_domains

INSTRUMENT_PINS = ("spi_sck", "spi_cs_n", "spi_copi", "spi_cipo", "led_homed", "led_fault", "led_heartbeat")
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
            run_samples=alignment_run_samples(board),
            self_test=self_test,
            strobe_delay=strobe_delay,
        )
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        board = self.board
        word_clock = add_word_domains(m)
        m.submodules.clocks = clocks = (Ecp5Clocks if board.family == "ecp5" else Ice40Clocks)(board, word_clock)
        m.submodules.instrument = instrument = self.instrument
        m.d.comb += ResetSignal("sync").eq(instrument.hold)
        sampler = self._sampler(m, platform, clocks, instrument)
        for name in SAMPLED_SIGNALS:
            m.d.comb += getattr(instrument, name).eq(getattr(sampler, name))

        for name in INSTRUMENT_PINS:
            pin = board.pins.get(name)
            if pin is not None:
                m.submodules[name] = buffer = io.Buffer(pin.direction, port(platform, name))
                signal = getattr(instrument, name)
                m.d.comb += buffer.o.eq(signal) if pin.direction == "o" else signal.eq(buffer.i)
        return m

    def _sampler(self, m, platform, clocks, instrument):
        board = self.board
        ports = {name: port(platform, name) for name in SAMPLED_SIGNALS}
        if board.samples_per_word == 1:
            m.submodules.sampler = sampler = PlainSampler(ports)
            return sampler
        ports[ALIGNMENT] = port(platform, ALIGNMENT)
        if board.family == "ice40":
            m.submodules.sampler = sampler = DdrSampler(ports, (ALIGNMENT,))
            m.submodules.pattern = pattern = SampledPattern()
            m.d.comb += sampler.alignment_out.eq(pattern.samples)
        else:
            m.submodules.sampler = sampler = GearingSampler(ports, board.samples_per_word, (ALIGNMENT,))
            m.submodules.pattern = pattern = ToggledPattern()
            m.d.comb += [
                pattern.drive.eq(instrument.alignment_drive),
                sampler.alignment_out.eq(pattern.level),
                sampler.reset.eq(clocks.gearing_reset),
            ]
        m.d.comb += [
            sampler.alignment_drive.eq(instrument.alignment_drive),
            instrument.alignment.eq(sampler.alignment),
        ]
        return sampler


def alignment_run_samples(board: Board) -> float | None:
    """Samples from edge to edge of the alignment pattern; None for one sample a word, which has no order."""
    if board.samples_per_word == 1:
        return None
    if board.family == "ice40":
        return RUN_SAMPLES
    pll = word_clock_pll(board.family, board.samples_per_word, board.oscillator_hz, board.word_clock_hz)
    return board.samples_per_s * pattern_divider(pll.output_divider) / pll.vco_hz
