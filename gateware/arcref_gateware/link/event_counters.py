"""Counters whose totals stand in the register file's memory: one adder goes round over all of them.

Each source has a small counter of its own that runs over. The lowest bits of a total are those of its small counter as
it was last looked at, so the difference of the two is what came since: the small counter is never cleared, and nothing
is lost as long as it does not run once round between two looks. A look takes four clocks, a round `ROUND_CLOCKS`.

A total of two words is two looks, one behind the other; the second takes the carry of the first. A total that
saturates stays at its largest value by itself: every difference makes it run over again, and then all its bits are
set. After reset, and after a clear, a total is taken from a place that holds 0.
"""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.register import WORD_BITS
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_layout import COUNTED, PLACE_BITS, TALLY_BITS, ZERO_PLACE
from arcref_gateware.link.register_memory import PHASES
from arcref_gateware.register_stages import delayed, sum_and_carry

LOOKS = [(counted, word) for counted in COUNTED for word in range(REGISTERS[counted.name].words)]
"""Counted register and its word, look by look."""

ROUND_CLOCKS = PHASES * len(LOOKS)
"""Clocks between two looks at one total."""

LOOK_ENDS = 0
"""Phase in which the next look begins; it overlaps with the one before it."""

_HALF = WORD_BITS // 2
_LOOK_BITS = 4

assert len(LOOKS) == 1 << _LOOK_BITS
assert ROUND_CLOCKS < 1 << TALLY_BITS, "a small counter could run round unseen"


class EventCounters(wiring.Component):
    """One input for each counted register, by its name; besides the following.

    A count of `TALLY_BITS` bits may change by one in every clock; a level, of a rare event, once in `ROUND_CLOCKS`.
    """

    def __init__(self):
        super().__init__(
            {counted.name: In(counted.bits) for counted in COUNTED}
            | {
                "clear": In(1),
                "phase": In(PHASES),
                "word": In(WORD_BITS),
                "read_place": Out(PLACE_BITS, init=ZERO_PLACE),
                "write_place": Out(PLACE_BITS),
                "total": Out(WORD_BITS),
                "round_ends": Out(1),
            }
        )

    clear: In
    """1 for one clock: registers that are cleared start from 0, as their small counters do in the next clock."""
    phase: In
    """The memory's phase."""
    word: In
    """The memory's word."""
    read_place: Out
    """Word that is wanted."""
    write_place: Out
    """Word to write, in the memory's phase `COUNTER_WRITE`."""
    total: Out
    """What to write there."""
    round_ends: Out
    """1 for one clock as a round ends."""

    def elaborate(self, platform):
        m = Module()
        look, is_last, steps_on = Signal(_LOOK_BITS), Signal(), self.phase[LOOK_ENDS]
        m.d.sync += [is_last.eq(look == len(LOOKS) - 1), self.round_ends.eq(is_last & steps_on)]
        with m.If(steps_on):
            m.d.sync += look.eq(look + 1)

        # Where the total is read: at its own place, or from the zero when it starts anew.
        first_round, from_zero, fresh, starts_anew = Signal(init=1), Signal(init=1), Signal(), Signal()
        places = [REGISTERS[counted.name].address + word for counted, word in LOOKS]
        place, write_place = Signal(PLACE_BITS, reset_less=True), Signal(PLACE_BITS, reset_less=True)
        m.d.comb += self.write_place.eq(write_place)
        cleared = [counted.cleared for counted, _ in LOOKS]
        before_cleared = Signal()
        takes_fresh = steps_on & before_cleared
        m.d.sync += [
            before_cleared.eq(look == cleared.index(True) - 1),
            fresh.eq(self.clear | (fresh & ~takes_fresh)),
            first_round.eq(first_round & ~(is_last & steps_on)),
            from_zero.eq(first_round | (starts_anew & _choice(look, cleared))),
            place.eq(_choice(look, places)),
            # The sum is of the look before.
            write_place.eq(_choice(look, _one_later(places))),
            self.read_place.eq(
                (place & ~from_zero.replicate(PLACE_BITS)) | (ZERO_PLACE & from_zero.replicate(PLACE_BITS))
            ),
        ]
        with m.If(takes_fresh):
            m.d.sync += starts_anew.eq(fresh)

        # The small counter. What is not told of a look stands as its neighbour has it, which makes the choice smaller.
        low, upper = [], []
        for counted, _ in LOOKS:
            tally = getattr(self, counted.name)
            low.append(tally[0])
            upper.append(upper[-1] if counted.rare else tally[1:])
        tally = Signal(TALLY_BITS)
        groups = []
        for k in range(0, len(LOOKS), 4):
            group = Signal(TALLY_BITS, name=f"tally{k}")
            m.d.sync += group.eq(Cat(Array(low[k : k + 4])[look[:2]], Array(upper[k : k + 4])[look[:2]]))
            groups.append(group)
        halves = [Signal(TALLY_BITS, name=f"half{k}") for k in range(2)]
        m.d.sync += [half.eq(Mux(look[2], *groups[2 * k : 2 * k + 2][::-1])) for k, half in enumerate(halves)]
        m.d.sync += tally.eq(Mux(delayed(m, look[3], 1, name="look_half"), halves[1], halves[0]))

        # What came since, in phase 2, and the sum in two halves, in phases 3 and 0, while the word is there.
        second_word = [word == 1 for _, word in LOOKS]
        narrow = [word == 1 or counted.rare for counted, word in LOOKS]
        saturating = _one_later([counted.saturates for counted, _ in LOOKS])
        looks_at = Signal(3, reset_less=True)
        m.d.sync += looks_at.eq(Cat(_choice(look, second_word), _choice(look, narrow), _choice(look, saturating)))
        is_second, is_narrow = delayed(m, looks_at[:2], 1, name="looks_at")
        saturates = looks_at[2]
        came = Signal(TALLY_BITS, reset_less=True)
        difference = Signal(TALLY_BITS)
        sum_low, sum_high = Signal(_HALF + 1), Signal(_HALF + 1)
        carry = Signal()  # of the look before
        m.d.comb += difference.eq(tally - self.word[:TALLY_BITS])
        m.d.sync += came.eq(Cat(Mux(is_second, carry, tally[0] ^ self.word[0]), difference[1:]))
        with m.If(is_narrow):
            m.d.sync += came[1:].eq(0)
        m.d.sync += [
            sum_low.eq(sum_and_carry(m, self.word[:_HALF], Cat(came, Const(0, _HALF - TALLY_BITS)))),
            sum_high.eq(sum_and_carry(m, self.word[_HALF:], Const(0, _HALF), sum_low[-1])),
            carry.eq(sum_high[-1]),
        ]
        full = (sum_high[-1] & saturates).replicate(WORD_BITS)
        m.d.comb += self.total.eq(Cat(delayed(m, sum_low[:_HALF], 1, name="low"), sum_high[:_HALF]) | full)
        return m


def _choice(look, values: list[int]):
    """Entry `look` of a list of numbers."""
    return Array([Const(int(value), max(values).bit_length() or 1) for value in values])[look]


def _one_later(values: list) -> list:
    """The list in which each look finds the value of the one before it."""
    return values[-1:] + values[:-1]
