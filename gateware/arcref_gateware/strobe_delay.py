"""The strobe: its rising edge, delayed by a set number of samples, picks the sample whose position is captured.

The fine part of the delay, less than a word, moves the strobe's samples; the coarse part counts whole words. Short
delays go through a chain of registers, longer ones wait in a queue.
"""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.index_detector import first_rise
from arcref_gateware.pending_strobes import LEAST_WAIT_WORDS, PendingStrobes

STROBE_DELAY_BITS = 16
"""Bits of the delay, in sample periods: 0..65535."""

STROBE_CLOCKS = 4
"""Clocks from a sample word to the due sample in it."""

COARSE_LOW_BITS = 4
"""Bits of the coarse delay that tell the short ones apart."""

STROBE_REFUSED_CLOCKS = 3
"""Clocks from the word, moved by the fine delay, in which a strobe is refused, to `refused`."""


class StrobeDelay(wiring.Component):
    """Marks the due sample of every strobe, `STROBE_CLOCKS` clocks after the word that holds it.

    A word has one due sample at most. Two that fall due in one word, or a strobe that comes while
    `PENDING_STROBES` wait, are refused and told by `refused`. Change `delay` only while none waits.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "strobe": In(samples_per_word),
                "delay": In(STROBE_DELAY_BITS),
                "due_sample": Out(samples_per_word),
                "due": Out(1),
                "refused": Out(1),
            }
        )

    strobe: In
    """Samples of the strobe, bit 0 the oldest."""
    delay: In
    """Sample periods from the strobe's first high sample to its due sample."""
    due_sample: Out
    """Bit i: sample i of the word is due."""
    due: Out
    """1 with a word that has a due sample."""
    refused: Out
    """1 for each word that brought a strobe which is not captured."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        fine_bits = exact_log2(samples)
        fine = self.delay[:fine_bits] if fine_bits else Const(0, 1)
        coarse = self.delay[fine_bits:]

        # The delay is as good as constant: what it selects is decided a clock ahead.
        chain_words = Signal(LEAST_WAIT_WORDS, reset_less=True)
        waits_long = Signal(reset_less=True)
        coarse_low = Signal(COARSE_LOW_BITS, reset_less=True)
        coarse_high = Signal(reset_less=True)
        m.d.sync += [
            coarse_low.eq(coarse[:COARSE_LOW_BITS]),
            coarse_high.eq(coarse[COARSE_LOW_BITS:].any()),
            chain_words.eq(Cat(~coarse_high & (coarse_low == words) for words in range(LEAST_WAIT_WORDS))),
            waits_long.eq(coarse_high | (coarse_low >= LEAST_WAIT_WORDS)),
        ]

        # First clock: the word. Lines count as high before reset, so that a strobe stuck high captures nothing.
        word = Signal(samples, init=~0)
        before = Signal(samples, init=~0)
        m.d.sync += [word.eq(self.strobe), before.eq(word)]
        # Second clock: the word, moved by the fine delay.
        moved = Signal(samples, init=~0)
        m.d.sync += moved.eq((Cat(before, word) << fine)[samples : 2 * samples])
        # Third clock: the first rise in the moved word.
        last_moved = Signal(init=1)
        first, second = first_rise(moved, last_moved)
        arrived_sample = Signal(samples)
        waits = Signal()
        crowded = Signal()
        m.d.sync += [
            last_moved.eq(moved[-1]),
            arrived_sample.eq(first),
            waits.eq(waits_long & first.any()),
            crowded.eq(second),
        ]

        # Short delays go through the chain, long ones wait in the queue.
        m.submodules.pending = pending = PendingStrobes(samples, STROBE_DELAY_BITS - fine_bits)
        m.d.comb += [
            pending.wait.eq(coarse),
            pending.arrives.eq(waits),
            pending.sample.eq(arrived_sample),
            self.refused.eq(crowded | (waits & pending.full)),
        ]
        chain = 0
        for words in reversed(range(LEAST_WAIT_WORDS)):
            stage = Signal(samples, name=f"chain{words}")
            entering = arrived_sample & chain_words[words].replicate(samples)
            m.d.sync += stage.eq(entering | chain | (pending.leaving if words == 0 else 0))
            chain = stage
        m.d.comb += [self.due_sample.eq(chain), self.due.eq(chain.any())]
        return m
