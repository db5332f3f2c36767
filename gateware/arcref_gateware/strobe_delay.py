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

CHAIN_WORDS = 5
"""Coarse delays below this go through the chain; the slots need five words to answer."""


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

        arrived = Signal()
        waits = Signal()
        full = Signal()
        m.d.comb += [
            arrived.eq(arrived_sample.any()),
            waits.eq(arrived & (coarse >= CHAIN_WORDS)),
            self.refused.eq(crowded | (waits & full)),
        ]
        waiting_sample = self._slots(m, arrived_sample, waits & ~full, full, coarse)
        chain = [Signal(samples, name=f"chain{words}") for words in range(CHAIN_WORDS)]
        for words, stage in enumerate(chain):
            enters = Mux(coarse == words, arrived_sample, 0)
            later = chain[words + 1] if words + 1 < CHAIN_WORDS else 0
            m.d.sync += stage.eq(enters | later | (waiting_sample if words == 0 else 0))
        m.d.comb += [self.due_sample.eq(chain[0]), self.due.eq(chain[0].any())]
        return m

    @staticmethod
    def _slots(m, arrived_sample, accepted, full, coarse):
        """The ring of waiting strobes. Drives `full`; returns the one-hot sample that falls due in the next word."""
        now = Signal(len(coarse))
        # The word whose strobes must leave now: three words before they are due.
        then = Signal(len(coarse))
        lead = Signal(len(coarse))
        m.d.sync += [now.eq(now + 1), lead.eq(4 - coarse), then.eq(now + lead)]

        # The strobe is written a clock after it is accepted, which keeps the slots' enables short.
        write_now = delayed(m, accepted, 1, name="accepted")
        write_arrival = delayed(m, now, 1, name="now")
        write_sample = delayed(m, arrived_sample, 1, name="accepted_sample")
        write_slot = Signal(PENDING_STROBES, init=1)
        used = Signal(PENDING_STROBES)
        left = Signal(PENDING_STROBES)
        pending = Signal(range(PENDING_STROBES + 1))
        left_sample = Signal(len(arrived_sample))
        m.d.comb += full.eq(pending[-1])
        m.d.sync += pending.eq(pending + accepted - left_sample.any())
        chosen = 0
        for slot in range(PENDING_STROBES):
            arrival = Signal(len(coarse), name=f"arrival{slot}", reset_less=True)
            sample = Signal(len(arrived_sample), name=f"sample{slot}", reset_less=True)
            # Compared in two clocks, half the bits to a register each.
            half = len(then) // 2
            low_equal, high_equal = Signal(name=f"low_equal{slot}"), Signal(name=f"high_equal{slot}")
            m.d.sync += [
                low_equal.eq(arrival[:half] == then[:half]),
                high_equal.eq(arrival[half:] == then[half:]),
                left[slot].eq(used[slot] & low_equal & high_equal),
            ]
            with m.If(write_now & write_slot[slot]):
                m.d.sync += [arrival.eq(write_arrival), sample.eq(write_sample)]
            chosen = chosen | Mux(left[slot], sample, 0)
        m.d.sync += used.eq((used | Mux(write_now, write_slot, 0)) & ~left)
        with m.If(write_now):
            m.d.sync += write_slot.eq(write_slot.rotate_left(1))
        m.d.sync += left_sample.eq(chosen)
        return left_sample
