"""Strobes that wait for their due sample, in the order in which they came.

Each is kept with the word it came in. As every strobe waits equally long they leave in order, so only the two oldest
count their time down; the others rest in a small memory.
"""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.register_stages import delayed

PENDING_STROBES = 16
"""Strobes that may wait at once."""

LEAST_WAIT_WORDS = 6
"""Shortest wait in words: what a strobe needs to get through the memory."""


class PendingStrobes(wiring.Component):
    """A queue that gives every strobe back a set number of words after it took it.

    `leaving` marks the sample of a strobe `wait` clocks after its `accept`. `wait` must be `LEAST_WAIT_WORDS` or
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
    """1 while `PENDING_STROBES` wait. A strobe makes room in the word after the one in which it leaves."""
    leaving: Out
    """The sample of the strobe that leaves, one-hot; 0 when none does."""

    def elaborate(self, platform):
        m = Module()
        words = len(self.wait)
        place_bits = exact_log2(len(self.sample))
        pending = Signal(range(PENDING_STROBES + 1))
        m.d.comb += self.full.eq(pending[-1])
        m.d.sync += pending.eq(pending + self.accept - self.leaving.any())

        now = Signal(words)
        # `arrival - then` is the time that is left, less what the way to `leaving` takes.
        then, lead = Signal(words), Signal(words)
        m.d.sync += [now.eq(now + 1), lead.eq(4 - self.wait), then.eq(now + lead)]

        m.submodules.memory = memory = Memory(shape=words + place_bits, depth=PENDING_STROBES, init=[])
        write, read = memory.write_port(), memory.read_port()
        place = Signal(place_bits)
        for i in range(1, len(self.sample)):
            with m.If(self.sample[i]):
                m.d.comb += place.eq(i)
        m.d.comb += [
            write.en.eq(delayed(m, self.accept, 1, name="accepted")),
            write.data.eq(delayed(m, Cat(place, now), 1, name="arrival")),
        ]
        # One bit more than an address tells a full memory from an empty one.
        write_place, read_place = Signal(len(write.addr) + 1), Signal(len(read.addr) + 1)
        m.d.comb += [write.addr.eq(write_place), read.addr.eq(read_place)]
        m.d.sync += write_place.eq(write_place + write.en)

        # Read word, second and first in the queue: each moves on when the one before it makes room.
        read_valid, second_valid, first_valid = Signal(), Signal(), Signal()
        second_left, first_left = Signal(signed(words + 1)), Signal(signed(words + 1))
        second_place, first_place = Signal(place_bits), Signal(place_bits)
        leaves, first_moves, second_moves, read_moves = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            leaves.eq(first_valid & first_left[-1]),
            first_moves.eq(leaves | ~first_valid),
            second_moves.eq(first_moves | ~second_valid),
            read_moves.eq(second_moves | ~read_valid),
            read.en.eq(read_moves & (write_place != read_place)),
        ]
        m.d.sync += [
            read_place.eq(read_place + read.en),
            read_valid.eq(read.en | (read_valid & ~read_moves)),
            second_valid.eq(read_valid | (second_valid & ~second_moves)),
            first_valid.eq(second_valid | (first_valid & ~first_moves)),
            second_left.eq(second_left - 1),
            first_left.eq(first_left - 1),
        ]
        with m.If(second_moves):
            m.d.sync += [second_left.eq((read.data[place_bits:] - then)[:words]), second_place.eq(read.data)]
        with m.If(first_moves):
            m.d.sync += [first_left.eq(second_left - 1), first_place.eq(second_place)]
        for i in range(len(self.sample)):
            m.d.sync += self.leaving[i].eq(leaves & (first_place == i))
        return m
