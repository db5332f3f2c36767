"""Strobes that wait for their due word: kept in a memory in groups of words, and read back when their time has come.

A delay is the same for all, so strobes leave in the order in which they came. Words are written in groups of eight, and
a group keeps its place in the memory when a strobe came in it. A second count of words runs as far behind the first as
the strobes must wait; when it comes to the number of the oldest group kept, that group is read out word by word. So
every comparison has eight clocks, and one memory does for any delay.
"""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.buffer_memory import BufferMemory
from arcref_gateware.register_stages import sum_and_carry

PENDING_STROBES = 16
"""Strobes that may wait at once."""

LEAST_WAIT_WORDS = 12
"""Shortest wait in words: what a strobe needs to get into the memory and out again. Fewer than `PENDING_STROBES`, so
that shorter waits, one strobe a word, never have to refuse one."""

GROUP_BITS = 3
"""Bits of a word's place in its group."""

SLOT_BITS = 5
"""Bits of a group's place in the memory: groups of one strobe each, and the one that is being written."""

LOW_BITS = 8
"""Bits of the lower part of a word's number, which is a clock ahead of the upper one."""

COMPARED_BITS = 4
"""Bits of a group's number that are compared together."""

FIRST_LINE_ARRIVES, HEAD_MOVES = 6, 1
"""Places in its group, of the second count, at which the first line of a group comes out of the memory, and at which
the memory has been asked for the last one."""

GROUP_ENDS = 3
"""Place in its group, of the first count, at which the last line of a group is written."""


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
    """The strobe's sample in its word, one-hot; not 0 without `arrives`."""
    full: Out
    """1 while `PENDING_STROBES` wait. A strobe makes room in the word after the one in which it is due."""
    leaving: Out
    """The sample of the strobe that leaves, one-hot; 0 when none does."""

    def elaborate(self, platform):
        m = Module()
        words, samples = len(self.wait), len(self.sample)

        # How many wait.
        pending = Signal(range(PENDING_STROBES + 1))
        leaves, accept = Signal(), Signal()
        less = leaves & ~accept
        m.d.comb += [self.full.eq(pending[-1]), accept.eq(self.arrives & ~self.full)]
        m.d.sync += pending.eq(pending + Cat(accept ^ leaves, less.replicate(len(pending) - 1)))

        # The number of a word counts down, so that adding the wait to it gives that of the word which came so long ago.
        # Both upper parts are a clock late, which nobody sees who looks in the middle of a group.
        # It begins where a group does: all its lines are written anew, and what a reset left in them is gone.
        low, high = Signal(LOW_BITS, init=GROUP_ENDS - 1), Signal(words - LOW_BITS)
        due_low, due_high = Signal(LOW_BITS), Signal(words - LOW_BITS)
        borrow, carry = Signal(), Signal()
        m.d.sync += [
            low.eq(low - 1),
            borrow.eq(low == 0),
            high.eq(high - borrow),
            Cat(due_low, carry).eq(sum_and_carry(m, low, self.wait[:LOW_BITS])),
            due_high.eq(high + self.wait[LOW_BITS:] + carry),
        ]
        place, due_place = low[:GROUP_BITS], due_low[:GROUP_BITS]
        number, due_number = Cat(low[GROUP_BITS:], high), Cat(due_low[GROUP_BITS:], due_high)

        # Two words to a line of the memory, four lines to a group, each with the group's number. The slot is written
        # again with the next group if none of its words had a strobe.
        m.submodules.memory = memory = BufferMemory(2 * samples + len(number), 1 << SLOT_BITS + GROUP_BITS - 1)
        pair = Signal(2 * samples)
        slot, head = Signal(SLOT_BITS), Signal(SLOT_BITS)
        has_strobe, occupied = Signal(), Signal()
        group_ends = place == GROUP_ENDS
        m.d.sync += [
            pair.eq(Cat(pair[samples:], self.sample & accept.replicate(samples))),
            has_strobe.eq(accept | (has_strobe & ~group_ends)),
            slot.eq(slot + (group_ends & has_strobe)),
            occupied.eq(slot != head),
        ]
        m.d.comb += [
            memory.write.eq(place[0]),
            memory.write_address.eq(Cat(place[1:], slot)),
            memory.write_data.eq(Cat(pair, number)),
            memory.read_address.eq(Cat(due_place[1:], head)),
        ]

        # The oldest group: is it due? Its words follow each other as long as the next eight clocks last.
        kept_pair, kept_number = memory.read_data[: 2 * samples], memory.read_data[2 * samples :]
        first_line, head_moves = due_place == FIRST_LINE_ARRIVES, due_place == HEAD_MOVES
        matches = []
        for low_bit in range(0, len(number), COMPARED_BITS):
            part = slice(low_bit, min(low_bit + COMPARED_BITS, len(number)))
            match = Signal(name=f"match{low_bit}")
            m.d.sync += match.eq(Mux(first_line, kept_number[part] == due_number[part], match))
            matches.append(match)
        is_there = Signal()
        due = is_there & Cat(matches).all()
        following = Signal(2 * samples, reset_less=True)
        m.d.sync += [
            is_there.eq(Mux(first_line, occupied, is_there)),
            head.eq(head + (head_moves & due)),
            following.eq(Mux(due_place[0], following >> samples, kept_pair)),
            self.leaving.eq(following[:samples] & due.replicate(samples)),
            leaves.eq(following[:samples].any() & due),
        ]
        return m
