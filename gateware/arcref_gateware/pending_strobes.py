"""Strobes that wait for their due sample: a ring of slots, each of which knows the word its strobe came in."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed

PENDING_STROBES = 16
"""Strobes that may wait at once."""

LEAST_WAIT_WORDS = 5
"""Shortest wait in words: what a strobe needs to get into a slot and out again."""

COMPARED_BITS = 5
"""Bits that are compared in one clock: two levels of logic."""


class PendingStrobes(wiring.Component):
    """Gives every strobe back a set number of words after it took it.

    `leaving` marks the sample of a strobe `wait` - 1 clocks after its `accept`. `wait` must be `LEAST_WAIT_WORDS` or
    more, and change only while none waits.
    """

    def __init__(self, samples_per_word: int, wait_bits: int):
        super().__init__(
            {
                "wait": In(wait_bits),
                "accept": In(1),
                "sample": In(samples_per_word),
                "full": Out(1),
                "leaving": Out(samples_per_word),
            }
        )

    wait: In
    """Words that a strobe waits."""
    accept: In
    """1 to take a strobe; not while `full`."""
    sample: In
    """The strobe's sample in its word, one-hot."""
    full: Out
    """1 while `PENDING_STROBES` wait. A strobe makes room in the word after the one in which it is due."""
    leaving: Out
    """The sample of the strobe that leaves, one-hot; 0 when none does."""

    def elaborate(self, platform):
        m = Module()
        words = len(self.wait)
        pending = Signal(range(PENDING_STROBES + 1))
        m.d.comb += self.full.eq(pending[-1])
        m.d.sync += pending.eq(pending + self.accept - self.leaving.any())

        now = Signal(words)
        # The word whose strobe must start on its way out now, three words before it is due.
        then, lead = Signal(words), Signal(words)
        m.d.sync += [now.eq(now + 1), lead.eq(4 - self.wait), then.eq(now + lead)]

        # A strobe is written a clock after it was taken, which keeps the enables of the slots short. A slot counts as
        # used a clock after that, when it has been compared with its new strobe and not with the one before.
        write = delayed(m, self.accept, 1, name="accepted")
        arrival = delayed(m, now, 1, name="now")
        sample = delayed(m, self.sample, 1, name="sample")
        slot = Signal(PENDING_STROBES, init=1)
        written = Signal(PENDING_STROBES)
        used = Signal(PENDING_STROBES)
        left = Signal(PENDING_STROBES)
        arrivals = [Signal(words, name=f"arrival{i}", reset_less=True) for i in range(PENDING_STROBES)]
        samples = [Signal(len(self.sample), name=f"sample{i}", reset_less=True) for i in range(PENDING_STROBES)]
        m.d.sync += written.eq(Mux(write, slot, 0))
        with m.If(write):
            m.d.sync += slot.eq(slot.rotate_left(1))
            for i in range(PENDING_STROBES):
                with m.If(slot[i]):
                    m.d.sync += [arrivals[i].eq(arrival), samples[i].eq(sample)]

        # Compared in two clocks, a few bits to a register each. Nothing moves here while no strobe waits.
        waiting = Signal()
        m.d.sync += waiting.eq(pending != 0)
        match = used
        for low in range(0, words, COMPARED_BITS):
            part = slice(low, min(low + COMPARED_BITS, words))
            equal = Signal(PENDING_STROBES, name=f"equal{low}", reset_less=True)
            with m.If(waiting):
                m.d.sync += equal.eq(Cat(arrival_word[part] == then[part] for arrival_word in arrivals))
            match = match & equal
        m.d.sync += [left.eq(match), used.eq((used | written) & ~left), self.leaving.eq(0)]
        with m.If(waiting):
            chosen = 0
            for i in range(PENDING_STROBES):
                chosen = chosen | Mux(left[i], samples[i], 0)
            m.d.sync += self.leaving.eq(chosen)
        return m
