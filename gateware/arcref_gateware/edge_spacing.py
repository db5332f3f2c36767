"""The watch on edge spacing: how close together the edges of A and B have come, in sample periods.

At one sample from edge to edge every count is still seen, but there is no margin left: faster, and samples can no
longer tell. So the limit is reported there, before the first count is lost.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.register_stages import delayed, sum_and_carry
from arcref_gateware.running_largest import RunningLargest

SPACING_BITS = 12
"""Bits of a spacing; the largest value stands for none."""


def longest_quiet_words(samples_per_word: int) -> int:
    """Words without an edge after which a spacing is no longer measured: half the range of a spacing, 2048 samples."""
    return (1 << SPACING_BITS - 1) // samples_per_word


EDGE_SPACING_CLOCKS = 4
"""Clocks from the steps of a word to `at_limit`."""


def marked_number(marks, numbers):
    """The one of `numbers` whose mark is 1; 0 when none is."""
    pairs = list(zip(marks, numbers, strict=True))
    width = max(number for _, number in pairs).bit_length()
    return Cat(Cat(mark for mark, number in pairs if number >> bit & 1).any() for bit in range(width))


class EdgeSpacing(wiring.Component):
    """Shortest spacing of two edges of A and B since reset or `clear`.

    An illegal step has no spacing of its own, as it is reported by itself, but the next spacing is measured from it.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "counted": In(samples_per_word),
                "edge": In(samples_per_word),
                "clear": In(1),
                "shortest": Out(SPACING_BITS),
                "at_limit": Out(1),
            }
        )

    counted: In
    """Bit i: sample i was counted, up or down."""
    edge: In
    """Bit i: sample i was counted, or A and B both changed at it."""
    clear: In
    """1 starts the search for the shortest spacing again."""
    shortest: Out
    """Shortest spacing seen, in sample periods; 4095 when none below 2048 was. It shows a word's spacing
    `RunningLargest.CLOCKS` after `at_limit`, and keeps it when `clear` came with that."""
    at_limit: Out
    """1 for each word in which two edges were one sample apart."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        place_bits = exact_log2(samples)
        edge, counted = self.edge, self.counted

        # First clock: the first and last edge of the word, and the pairs of neighbouring edges inside it.
        is_first = [edge[i] & ~edge[:i].any() for i in range(samples)]
        is_last = [edge[i] & ~edge[i + 1 :].any() for i in range(samples)]
        any_edge = Signal()
        first_counted = Signal()
        first = Signal(range(samples))
        after_last = Signal(range(samples))
        has_pair = Signal(samples)
        m.d.sync += [
            any_edge.eq(edge.any()),
            first_counted.eq(Cat(mark & counted[i] for i, mark in enumerate(is_first)).any()),
            first.eq(marked_number(is_first, range(samples))),
            after_last.eq(marked_number(is_last, reversed(range(samples)))),
        ]
        for gap in range(1, samples):
            pairs = [edge[i - gap] & counted[i] & ~edge[i - gap + 1 : i].any() for i in range(gap, samples)]
            m.d.sync += has_pair[gap].eq(Cat(pairs).any())

        # Second clock: words without an edge before this one, and the samples after the last edge.
        # The count may run over: `in_range` says that the last edge is not too far back, and that there was one.
        longest = longest_quiet_words(samples)
        quiet_words = Signal(range(longest), reset_less=True)
        at_longest = Signal(reset_less=True)
        in_range = Signal()
        quiet_samples = Signal(place_bits)
        words_between = Signal.like(quiet_words, reset_less=True)
        neighbours = Signal(reset_less=True)
        near_part = Signal(place_bits + 1, reset_less=True)
        cross_valid = Signal()
        m.d.sync += [
            quiet_words.eq(quiet_words + 1),
            at_longest.eq(quiet_words == longest - 2),
            in_range.eq(any_edge | (in_range & ~at_longest)),
        ]
        with m.If(any_edge):
            m.d.sync += [quiet_words.eq(0), at_longest.eq(0), quiet_samples.eq(after_last)]
        m.d.sync += [
            words_between.eq(quiet_words),
            neighbours.eq(delayed(m, any_edge, 1, name="any_edge")),
            near_part.eq(quiet_samples + first + 1),
            cross_valid.eq(any_edge & first_counted & in_range),
        ]
        # The closest pair inside the word.
        inner_2 = Signal(range(samples))
        closest = [has_pair[gap] & ~has_pair[:gap].any() for gap in range(samples)]
        m.d.sync += inner_2.eq(marked_number(closest, range(samples)))

        # Third clock: the spacing across words, and whether it is the shorter one. A pair inside a word is closer
        # than any across words with a word between them.
        cross = Signal(SPACING_BITS, reset_less=True)
        far_part = Cat(near_part[place_bits], Const(0, len(words_between) - 1))
        cross_is_shorter = Signal()
        cross_at_limit = Signal()
        m.d.sync += [
            cross.eq(Cat(near_part[:place_bits], sum_and_carry(m, words_between, far_part))),
            cross_is_shorter.eq(cross_valid & ((inner_2 == 0) | (neighbours & (near_part <= inner_2)))),
            cross_at_limit.eq(cross_valid & neighbours & (near_part == 1)),
        ]
        inner_3 = delayed(m, inner_2, 1, name="inner_2")

        # Fourth clock: the word's shortest spacing, turned over, so that the shortest is the largest.
        turned = Signal(SPACING_BITS, reset_less=True)
        spacing_valid = Signal()
        has_spacing = cross_is_shorter | (inner_3 != 0)
        m.d.sync += [
            turned.eq(~Mux(cross_is_shorter, cross, inner_3) & has_spacing.replicate(SPACING_BITS)),
            spacing_valid.eq(has_spacing),
            self.at_limit.eq(cross_at_limit | (inner_3 == 1)),
        ]
        m.submodules.search = search = RunningLargest(SPACING_BITS)
        m.d.comb += [
            search.number.eq(turned),
            search.valid.eq(spacing_valid),
            search.clear.eq(self.clear),
            self.shortest.eq(~search.largest),
        ]
        return m
