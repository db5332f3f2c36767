"""The pattern of the alignment check: what the spare pad sends.

iCE40: samples of the word clock, through the pad's double-data-rate output. ECP5: a level that toggles with a PLL
clock of its own, because IDDR and ODDR on one pin are not supported there, and because a level that changes with the
word clock would show its edges at one place in the word only.
"""

from amaranth.hdl import Array, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from arcref_gateware.boards.pattern_clock import RUN_SAMPLES


class SampledPattern(wiring.Component):
    """Runs of `RUN_SAMPLES` samples as words of two, in the domain `word`."""

    def __init__(self):
        super().__init__({"samples": Out(2)})

    samples: Out
    """The next two samples, bit 0 first."""

    def elaborate(self, platform):
        m = Module()
        levels = [1] * RUN_SAMPLES + [0] * RUN_SAMPLES
        words = Array([levels[k] | levels[k + 1] << 1 for k in range(0, len(levels), 2)])
        place = Signal(range(len(words)))
        m.d.word += [
            self.samples.eq(words[place]),
            place.eq(place + 1),
        ]
        with m.If(place == len(words) - 1):
            m.d.word += place.eq(0)
        return m


class ToggledPattern(wiring.Component):
    """A level that changes with every clock of the domain `pattern` while `drive` is 1."""

    def __init__(self):
        super().__init__({"drive": In(1), "level": Out(1)})

    drive: In
    """1 while the pattern is wanted; from the domain `word`."""
    level: Out
    """The pattern."""

    def elaborate(self, platform):
        m = Module()
        drive = Signal()
        m.submodules.drive = FFSynchronizer(self.drive, drive, o_domain="pattern")
        m.d.pattern += self.level.eq(~self.level & drive)
        return m
