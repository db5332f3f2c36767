"""Sums of the steps inside one sample word: the whole word, and what comes after each of its samples."""

from amaranth.hdl import Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed

PARTIAL_SUM_CLOCKS = 2
"""Clocks from the steps of a word to their sums."""


def value_at(values, one_hot):
    """The member of `values` (signed, one a sample) that `one_hot` marks; 0 when it marks none."""
    chosen = 0
    for sample, value in enumerate(values):
        chosen = chosen | Mux(one_hot[sample], value, 0)
    return chosen


class PartialSums(wiring.Component):
    """Total of a word's steps, and the part of it that falls after each sample, `PARTIAL_SUM_CLOCKS` clocks later.

    The position at sample i is the position after the word plus `way_back[i]`: that places an event inside a word.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "forward": In(samples_per_word),
                "reverse": In(samples_per_word),
                "index_sample": In(samples_per_word),
                "total": Out(signed(4)),
                "way_back": Out(signed(3)).array(samples_per_word),
                "index_remainder": Out(signed(3)),
            }
        )

    forward: In
    """Bit i: sample i counted +1."""
    reverse: In
    """Bit i: sample i counted -1."""
    index_sample: In
    """Bit i: the index was entered at sample i of the word, given one clock after its steps."""
    total: Out
    """Sum of all steps of the word, -N..N."""
    way_back: Out
    """`way_back[i]`: minus the sum of the steps of the samples after sample i, -(N-1)..N-1."""
    index_remainder: Out
    """Sum of the steps after the sample that `index_sample` marks."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        step = [Signal(signed(2), name=f"step{i}") for i in range(samples)]
        for i in range(samples):
            m.d.comb += step[i].eq(self.forward[i] - self.reverse[i])
        # First clock: sums of neighbours, so that no sum takes more than four inputs a bit.
        pair = [Signal(signed(3), name=f"pair{i}") for i in range(0, samples, 2)]
        held = [delayed(m, step[i], 1, name=f"step{i}") for i in range(samples)]
        for i, sum_of_two in enumerate(pair):
            m.d.sync += sum_of_two.eq(sum(step[2 * i : 2 * i + 2]))
        # Second clock: pairs into the total and the remainders.
        remainder = [Signal(signed(3), name=f"remainder{i}") for i in range(samples)]
        for i in range(samples):
            after = held[i + 1 : i + 2] if i % 2 == 0 else []
            m.d.comb += remainder[i].eq(sum(after) + sum(pair[i // 2 + 1 :]))
            m.d.sync += self.way_back[i].eq(-remainder[i])
        m.d.sync += [
            self.total.eq(sum(pair)),
            self.index_remainder.eq(value_at(remainder, self.index_sample)),
        ]
        return m
