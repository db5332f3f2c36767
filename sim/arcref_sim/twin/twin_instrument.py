"""The instrument of a board with its on-board test generator, with the ports of the core, for the twin."""

from amaranth.hdl import DomainRenamer, Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.correction_rom import CorrectionRom
from arcref_gateware.boards.instrument import Instrument
from arcref_gateware.boards.self_test import SelfTest
from arcref_gateware.core_ports import CORE_PORTS

ON_BOTH = ("a", "b", "z", "strobe", "spi_sck", "spi_cs_n", "spi_copi", "spi_cipo", "uart_rx", "uart_tx", "compare")
"""Ports that the instrument has; the others are the core's inside it."""


class TwinInstrument(wiring.Component):
    """What is flashed on a board as `arcref build --self-test` builds it, but for pads, clocks and alignment check.

    The generator is off, as its registers are at reset here, until the host turns it. Parameters and attributes that
    describe it are those of `ConnectedEncoder`.
    """

    def __init__(self, rom: CorrectionRom, samples_per_word: int, *, word_clock_hz: float, baud: float):
        self.instrument = Instrument(
            rom, samples_per_word, word_clock_hz, self_test=_OffAtReset(), has_link=True, baud=baud
        )
        core = self.instrument.core
        self.rom, self.samples_per_word, self.word_clock_hz = rom, samples_per_word, word_clock_hz
        self.divisor = core.divisor
        self.strobe_delay_init, self.gate_state_init = core.strobe_delay_init, core.gate_state_init
        members = core.signature.members
        super().__init__({port.name: members[port.name] for port in CORE_PORTS if port.name in members})

    def elaborate(self, platform):
        m = Module()
        m.submodules.instrument = DomainRenamer({"word": "sync"})(self.instrument)
        for name, member in self.signature.members.items():
            inner = getattr(self.instrument if name in ON_BOTH else self.instrument.core, name)
            if member.flow is In:
                m.d.comb += inner.eq(getattr(self, name))
            else:
                assert member.flow is Out
                m.d.comb += getattr(self, name).eq(inner)
        return m


class _OffAtReset(SelfTest):
    """A generator that leaves the lines to the encoder until it is asked for."""

    def settings(self, samples_per_s: float) -> dict[str, int]:
        """The reset values of the declaration."""
        return {}
