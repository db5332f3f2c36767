"""Strobes that wait for their due sample: a ring of slots, each of which knows the word its strobe came in."""

from functools import reduce
from operator import and_

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed, sum_and_carry

PENDING_STROBES = 16
"""Strobes that may wait at once."""

LEAST_WAIT_WORDS = 7
"""Shortest wait in words: what a strobe needs to get into a slot and out again."""

COMPARED_BITS = 2
"""Bits that are compared in one clock: one level of logic, as the word to compare with goes to every slot."""

LOW_BITS = 8
"""Bits of the lower part of a word's number: the carry into the upper part is known a clock ahead."""

PARTS_JOINED = 4
"""Comparisons that are joined in one clock."""

SLOT_GROUP = 4
"""Slots whose samples are gathered in one clock."""


class PendingStrobes(wiring.Component):
    """Gives every strobe back a set number of words after it took it.

    `leaving` marks the sample of a strobe `wait` clocks after it came. `wait` must be `LEAST_WAIT_WORDS` or
    more, and change only while none waits.
    """

    def __init__(self, samples_per_word: int, wait_bits: int):
        super().__init__(
            {
                "wait": In(wait_bits),
                "arrives": In(1),
                "sample": In(samples_per_word),
                "full": Out(1),
                "leaving": Out(samples_per_word),
            }
        )

    wait: In
    """Words that a strobe waits."""
    arrives: In
    """1 when a strobe comes; it is taken unless `full`."""
    sample: In
    """The strobe's sample in its word, one-hot."""
    full: Out
    """1 while `PENDING_STROBES` wait. A strobe makes room in the word after the one in which it is due."""
    leaving: Out
    """The sample of the strobe that leaves, one-hot; 0 when none does."""

    def elaborate(self, platform):
        m = Module()
        words = len(self.wait)
        # How many wait: as many ones, from the lowest bit on. One that comes while it is full changes nothing by
        # itself, so that `full` need not be asked on the way to every bit.
        pending = Signal(PENDING_STROBES)
        leaves = Signal()
        accept = self.arrives & ~self.full
        m.d.comb += self.full.eq(pending[-1])
        with m.If(self.arrives & ~leaves):
            m.d.sync += pending.eq(Cat(1, pending))
        with m.Elif(leaves & ~self.arrives):
            m.d.sync += pending.eq(pending[1:])
        with m.Elif(leaves):
            m.d.sync += pending[-1].eq(0)

        # The number of the present word.
        low, high = Signal(LOW_BITS), Signal(words - LOW_BITS)
        low_full = Signal()
        m.d.sync += [low.eq(low + 1), low_full.eq(low == (1 << LOW_BITS) - 2), high.eq(high + low_full)]
        now = Cat(low, high)

        # The word whose strobe must start on its way out now, five words before it is due: the present word's number,
        # two clocks old, and 7 - wait. The lower part goes a clock ahead of the upper one.
        not_wait = Signal(words, reset_less=True)
        low_lead, high_lead = Signal(LOW_BITS + 1, reset_less=True), Signal(words - LOW_BITS, reset_less=True)
        low_then, high_then = Signal(LOW_BITS + 1, reset_less=True), Signal(words - LOW_BITS, reset_less=True)
        m.d.sync += [
            not_wait.eq(~self.wait),
            low_lead.eq(sum_and_carry(not_wait[:LOW_BITS], Const(8, LOW_BITS))),
            high_lead.eq(not_wait[LOW_BITS:] + low_lead[-1]),
            low_then.eq(sum_and_carry(low, low_lead[:LOW_BITS])),
            high_then.eq(delayed(m, high, 1, name="high") + high_lead + low_then[-1]),
        ]
        then = Cat(delayed(m, low_then[:LOW_BITS], 1, name="low_then"), high_then)

        # A strobe is written a clock after it was taken, which keeps the enables of the slots short. A slot counts as
        # used some clocks after that, when it has been compared with its new strobe and not with the one before.
        arrival = delayed(m, now, 1, name="now")
        sample = delayed(m, self.sample, 1, name="sample")
        slot = Signal(PENDING_STROBES, init=1)
        writes, written = Signal(PENDING_STROBES), Signal(PENDING_STROBES)
        used = Signal(PENDING_STROBES)
        left = Signal(PENDING_STROBES)
        arrivals = [Signal(words, name=f"arrival{i}", reset_less=True) for i in range(PENDING_STROBES)]
        samples = [Signal(len(self.sample), name=f"sample{i}", reset_less=True) for i in range(PENDING_STROBES)]
        m.d.sync += [
            writes.eq(slot & accept.replicate(PENDING_STROBES)),
            written.eq(delayed(m, writes, 1, name="writes")),
        ]
        with m.If(accept):
            m.d.sync += slot.eq(slot.rotate_left(1))
        for i in range(PENDING_STROBES):
            with m.If(writes[i]):
                m.d.sync += [arrivals[i].eq(arrival), samples[i].eq(sample)]

        # Compared in three clocks, a few bits to a register each. Nothing moves here while no strobe waits.
        waiting = Signal()
        m.d.sync += waiting.eq(pending[0])
        parts = []
        for place in range(0, words, COMPARED_BITS):
            part = slice(place, min(place + COMPARED_BITS, words))
            equal = Signal(PENDING_STROBES, name=f"equal{place}", reset_less=True)
            with m.If(waiting):
                m.d.sync += equal.eq(Cat(arrival_word[part] == then[part] for arrival_word in arrivals))
            parts.append(equal)
        match = used
        for first in range(0, len(parts), PARTS_JOINED):
            joined = Signal(PENDING_STROBES, name=f"joined{first}")
            m.d.sync += joined.eq(reduce(and_, parts[first : first + PARTS_JOINED]))
            match = match & joined
        m.d.sync += [left.eq(match), used.eq((used | written) & ~left)]
        # The sample of the one that left, gathered in two clocks.
        gathered, any_left = 0, []
        for first in range(0, PENDING_STROBES, SLOT_GROUP):
            group = range(first, first + SLOT_GROUP)
            group_sample = Signal(len(self.sample), name=f"group{first}")
            group_left = Signal(name=f"left{first}")
            chosen = 0
            for i in group:
                chosen = chosen | (left[i].replicate(len(self.sample)) & samples[i])
            m.d.sync += [group_sample.eq(chosen), group_left.eq(left[first : first + SLOT_GROUP].any())]
            gathered = gathered | group_sample
            any_left.append(group_left)
        m.d.sync += [self.leaving.eq(gathered), leaves.eq(Cat(any_left).any())]
        return m
