"""The watch on edge spacing: how close together the edges of A and B have come, in sample periods.

At one sample from edge to edge every count is still seen, but there is no margin left: faster, and samples can no
longer tell. So the limit is reported there, before the first count is lost.
"""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.register_stages import delayed

SPACING_BITS = 12
"""Bits of a spacing; the largest value stands for none."""


def longest_quiet_words(samples_per_word: int) -> int:
    """Words without an edge after which a spacing is no longer measured: half the range of a spacing, 2048 samples."""
    return (1 << SPACING_BITS - 1) // samples_per_word


EDGE_SPACING_CLOCKS = 4
"""Clocks from the steps of a word to `at_limit`."""


class EdgeSpacing(wiring.Component):
    """Shortest spacing of two edges of A and B since reset or `clear`.

    An illegal step has no spacing of its own, as it is reported by itself, but the next spacing is measured from it.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "forward": In(samples_per_word),
                "reverse": In(samples_per_word),
                "illegal": In(samples_per_word),
                "clear": In(1),
                "shortest": Out(SPACING_BITS, init=(1 << SPACING_BITS) - 1),
                "at_limit": Out(1),
            }
        )

    forward: In
    """Bit i: sample i counted +1."""
    reverse: In
    """Bit i: sample i counted -1."""
    illegal: In
    """Bit i: A and B both changed at sample i."""
    clear: In
    """1 starts the search for the shortest spacing again."""
    shortest: Out
    """Shortest spacing seen, in sample periods; 4095 when none below 2048 was. One clock after `at_limit`."""
    at_limit: Out
    """1 for each word in which two edges were one sample apart."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        place_bits = exact_log2(samples)
        counted = self.forward | self.reverse
        edges = counted | self.illegal

        # First clock: the first and last edge of the word, and the closest pair inside it.
        any_edge = Signal()
        first_counted = Signal()
        first = Signal(range(samples))
        after_last = Signal(range(samples))
        inner = Signal(range(samples))
        # `first` and `after_last` mean nothing without an edge; giving them a value then saves their clock enables.
        m.d.sync += [any_edge.eq(edges.any()), first_counted.eq(0), first.eq(0), after_last.eq(0), inner.eq(0)]
        for i in reversed(range(samples)):
            with m.If(edges[i]):
                m.d.sync += [first.eq(i), first_counted.eq(counted[i])]
        for i in range(samples):
            with m.If(edges[i]):
                m.d.sync += after_last.eq(samples - 1 - i)
        for gap in reversed(range(1, samples)):
            pairs = [edges[i - gap] & counted[i] & ~edges[i - gap + 1 : i].any() for i in range(gap, samples)]
            with m.If(sum(pairs) != 0):
                m.d.sync += inner.eq(gap)

        # Second clock: words without an edge before this one, and the samples after the last edge.
        # Its highest bit says that the last edge lies too far back, or that there was none.
        start = longest_quiet_words(samples)
        quiet_words = Signal(range(start + 1), init=start)
        quiet_samples = Signal(place_bits)
        words_between = Signal.like(quiet_words)
        neighbours = Signal()
        near_part = Signal(place_bits + 1)
        cross_valid = Signal()
        with m.If(any_edge):
            m.d.sync += [quiet_words.eq(0), quiet_samples.eq(after_last)]
        with m.Elif(~quiet_words[-1]):
            m.d.sync += quiet_words.eq(quiet_words + 1)
        m.d.sync += [
            words_between.eq(quiet_words),
            neighbours.eq(quiet_words == 0),
            near_part.eq(quiet_samples + first + 1),
            cross_valid.eq(any_edge & first_counted & ~quiet_words[-1]),
        ]
        inner_2 = delayed(m, inner, 1, name="inner")

        # Third clock: the spacing across words, and whether it is the shorter one. A pair inside a word is closer
        # than any across words with a word between them.
        cross = Signal(SPACING_BITS)
        cross_is_shorter = Signal()
        cross_at_limit = Signal()
        m.d.sync += [
            cross.eq((words_between << place_bits) + near_part),
            cross_is_shorter.eq(cross_valid & ((inner_2 == 0) | (neighbours & (near_part <= inner_2)))),
            cross_at_limit.eq(cross_valid & neighbours & (near_part == 1)),
        ]
        inner_3 = delayed(m, inner_2, 1, name="inner_2")

        # Fourth clock: the word's shortest spacing.
        spacing = Signal(SPACING_BITS)
        spacing_valid = Signal()
        m.d.sync += [
            spacing.eq(Mux(cross_is_shorter, cross, inner_3)),
            spacing_valid.eq(cross_is_shorter | (inner_3 != 0)),
            self.at_limit.eq(cross_at_limit | (inner_3 == 1)),
        ]
        with m.If(self.clear):
            m.d.sync += self.shortest.eq(self.shortest.init)
        with m.Elif(spacing_valid & (spacing < self.shortest)):
            m.d.sync += self.shortest.eq(spacing)
        return m
