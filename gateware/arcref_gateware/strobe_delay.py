"""The strobe: its rising edge, delayed by a set number of samples, picks the sample whose position is captured.

The fine part of the delay, less than a word, moves the strobe's samples; the coarse part counts whole words. Short
delays go through a chain of registers, longer ones wait in a ring of slots that hold the word they arrived in.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.index_detector import first_rise
from arcref_gateware.register_stages import delayed

STROBE_DELAY_BITS = 16
"""Bits of the delay, in sample periods: 0..65535."""

PENDING_STROBES = 16
"""Strobes that may wait for their due sample at once."""

STROBE_CLOCKS = 4
"""Clocks from a sample word to the due sample in it."""

STROBE_REFUSED_CLOCKS = 3
"""Clocks from the word, moved by the fine delay, in which a strobe is refused, to `refused`."""

CHAIN_WORDS = 3
"""Coarse delays below this go through the chain; the slots need three words to answer."""


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
        coarse_bits = STROBE_DELAY_BITS - fine_bits
        fine = self.delay[:fine_bits] if fine_bits else Const(0, 1)
        coarse = self.delay[fine_bits:]

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
        crowded = Signal()
        m.d.sync += [last_moved.eq(moved[-1]), arrived_sample.eq(first), crowded.eq(second)]

        waits = Signal()
        waiting_sample, full = self._slots(m, arrived_sample, waits, coarse, coarse_bits)
        arrived = arrived_sample.any()
        m.d.comb += [
            waits.eq(arrived & (coarse >= CHAIN_WORDS)),
            self.refused.eq(crowded | (waits & full)),
        ]
        chain = [Signal(samples, name=f"chain{words}") for words in range(CHAIN_WORDS)]
        for words, stage in enumerate(chain):
            enters = Mux(coarse == words, arrived_sample, 0)
            m.d.sync += stage.eq(enters | (chain[words + 1] if words + 1 < CHAIN_WORDS else 0))
        m.d.sync += chain[0].eq(Mux(coarse == 0, arrived_sample, chain[1]) | waiting_sample)
        m.d.comb += [self.due_sample.eq(chain[0]), self.due.eq(chain[0].any())]
        return m

    def _slots(self, m, arrived_sample, waits, coarse, coarse_bits):
        """The ring of waiting strobes. Returns the sample due two words on, one-hot, and whether the ring is full."""
        now = Signal(coarse_bits)
        # The word whose strobes must leave the ring now: two words before they are due, less the clock of `then`.
        then = Signal(coarse_bits)
        lead = Signal(coarse_bits)
        m.d.sync += [now.eq(now + 1), lead.eq(3 - coarse), then.eq(now + lead)]

        used = Signal(PENDING_STROBES)
        next_slot = Signal(range(PENDING_STROBES))
        write = Signal(PENDING_STROBES)
        leaves = Signal(PENDING_STROBES)
        full = Signal()
        m.d.comb += full.eq(used.bit_select(next_slot, 1))
        with m.If(waits & ~full):
            m.d.sync += next_slot.eq(next_slot + 1)
            m.d.comb += write.eq(1 << next_slot)
        m.d.sync += used.eq((used | write) & ~leaves)

        arrivals = [Signal(coarse_bits, name=f"arrival{slot}") for slot in range(PENDING_STROBES)]
        waiting = [Signal(len(arrived_sample), name=f"sample{slot}") for slot in range(PENDING_STROBES)]
        for slot in range(PENDING_STROBES):
            with m.If(write[slot]):
                m.d.sync += [arrivals[slot].eq(now), waiting[slot].eq(arrived_sample)]
            with m.If(used.any()):
                m.d.comb += leaves[slot].eq(used[slot] & (arrivals[slot] == then))
        left = delayed(m, leaves, 1, name="left")
        chosen = 0
        for slot in range(PENDING_STROBES):
            chosen = chosen | Mux(left[slot], waiting[slot], 0)
        return delayed(m, chosen, 1, name="left_sample"), full
