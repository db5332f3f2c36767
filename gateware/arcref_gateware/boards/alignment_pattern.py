"""The pattern of the alignment check: what the spare pad sends.

iCE40: samples of the word clock, through the pad's double-data-rate output. ECP5: a level that changes with a PLL
clock of its own, because IDDR and ODDR on one pin are not supported there, and because a level that changes with the
word clock would show its edges at one place in the word only.
"""

from amaranth.hdl import Array, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from arcref_gateware.boards.alignment_check import AlignmentPattern
from arcref_gateware.boards.pattern_clock import pattern_clocks, pattern_divider
from arcref_gateware.boards.pll_ecp5 import Ecp5Pll

SAMPLED_RUNS = AlignmentPattern(high_samples=7, low_samples=8)
"""Of `SampledPattern`. Their sum is odd, so that rising and falling edges both visit every place in a word."""


class SampledPattern(wiring.Component):
    """The pattern `SAMPLED_RUNS` as words of two samples, in the domain `word`."""

    def __init__(self):
        super().__init__({"samples": Out(2)})

    samples: Out
    """The next two samples, bit 0 first."""

    def elaborate(self, platform):
        m = Module()
        levels = 2 * ([1] * int(SAMPLED_RUNS.high_samples) + [0] * int(SAMPLED_RUNS.low_samples))
        words = Array([levels[k] | levels[k + 1] << 1 for k in range(0, len(levels), 2)])
        place = Signal(range(len(words)))
        m.d.word += [self.samples.eq(words[place]), place.eq(place + 1)]
        with m.If(place == len(words) - 1):
            m.d.word += place.eq(0)
        return m


class ToggledPattern(wiring.Component):
    """High for some clocks of the domain `pattern`, low for others, again and again while `drive` is 1."""

    def __init__(self, high_clocks: int, low_clocks: int):
        self.high_clocks = high_clocks
        self.low_clocks = low_clocks
        super().__init__({"drive": In(1), "level": Out(1)})

    drive: In
    """1 while the pattern is wanted; from the domain `word`."""
    level: Out
    """The pattern."""

    def elaborate(self, platform):
        m = Module()
        drive = Signal()
        m.submodules.drive = FFSynchronizer(self.drive, drive, o_domain="pattern")
        ring = Signal(self.high_clocks + self.low_clocks, init=(1 << self.high_clocks) - 1)
        m.d.pattern += [ring.eq(ring.rotate_left(1)), self.level.eq(ring[0] & drive)]
        return m


def toggled_runs(pll: Ecp5Pll, samples_per_s: float) -> AlignmentPattern:
    """The runs of `ToggledPattern` in samples, for the clock that `pattern_divider` makes from `pll`."""
    clock_samples = samples_per_s * pattern_divider(pll.output_divider) / pll.vco_hz
    high_clocks, low_clocks = pattern_clocks(pll.output_divider)
    return AlignmentPattern(high_clocks * clock_samples, low_clocks * clock_samples)
