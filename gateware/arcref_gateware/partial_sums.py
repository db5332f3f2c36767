"""Sums of the steps inside one sample word: the whole word, and what comes after each of its samples."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed

WAY_BACK_CLOCKS = 2
"""Clocks from the steps of a word to the sums after each of its samples."""

PARTIAL_SUM_CLOCKS = 3
"""Clocks from the steps of a word to what the position is to advance by."""


def value_at(values, one_hot):
    """The member of `values` (signed, one a sample) that `one_hot` marks; 0 when it marks none."""
    chosen = 0
    for sample, value in enumerate(values):
        chosen = chosen | (value & one_hot[sample].replicate(len(value)).as_signed())
    return chosen


class PartialSums(wiring.Component):
    """Sums of a word's steps: what the position advances by, and the part that falls after each sample.

    The position at sample i is the position after the word plus `way_back[i]`: that places an event inside a word.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "forward": In(samples_per_word),
                "reverse": In(samples_per_word),
                "index_sample": In(samples_per_word),
                "home": In(1),
                "way_back": Out(signed(3)).array(samples_per_word),
                "advance": Out(signed(4)),
                "index_way_back": Out(signed(3)),
            }
        )

    forward: In
    """Bit i: sample i counted +1."""
    reverse: In
    """Bit i: sample i counted -1."""
    index_sample: In
    """Bit i: the index was entered at sample i of the word, given one clock after its steps."""
    home: In
    """1 when that index homes, given two clocks after the steps."""
    way_back: Out
    """`way_back[i]`: minus the sum of the steps after sample i, -(N-1)..N-1; `WAY_BACK_CLOCKS` after the steps."""
    advance: Out
    """Sum of all steps of the word, -N..N, or of those after the index that homes; `PARTIAL_SUM_CLOCKS` after them."""
    index_way_back: Out
    """`way_back` at the index, with `advance`."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        step = [Cat(self.forward[i] | self.reverse[i], self.reverse[i]).as_signed() for i in range(samples)]
        # First clock: sums of neighbours, -2..2, in gates: a carry chain would be longer.
        held = [delayed(m, step[i], 1, name=f"step{i}") for i in range(samples)]
        pair = [Signal(signed(3), name=f"pair{i}") for i in range(0, samples, 2)]
        for i, sum_of_two in enumerate(pair):
            first, second = step[2 * i], step[2 * i + 1] if samples > 1 else Const(0, signed(2))
            negative = (first[1] & ~(second[0] & ~second[1])) | (second[1] & ~(first[0] & ~first[1]))
            both = first[0] & second[0]
            m.d.sync += sum_of_two.eq(Cat(first[0] ^ second[0], negative | (both & ~first[1] & ~second[1]), negative))
        # Second clock: pairs into the total and the remainders.
        total = Signal(signed(4))
        remainder = [Signal(signed(3), name=f"remainder{i}") for i in range(samples)]
        for i in range(samples):
            after = held[i + 1 : i + 2] if i % 2 == 0 else []
            sum_after = sum(after) + sum(pair[i // 2 + 1 :])
            m.d.sync += [remainder[i].eq(sum_after), self.way_back[i].eq(-sum_after)]
        m.d.sync += total.eq(sum(pair))
        # Third clock: what counts. A word that homes counts from its index on.
        index_sample = delayed(m, self.index_sample, 1, name="index_sample")
        m.d.sync += [
            self.advance.eq(Mux(self.home, value_at(remainder, index_sample), total)),
            self.index_way_back.eq(value_at(self.way_back, index_sample)),
        ]
        return m
