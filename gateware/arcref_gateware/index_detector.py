"""Finding the index: the moment Z is high while (A, B) is the gate state.

The latched place is one quadrature state, so it is the same in both directions and at any width of Z up to four states.
"""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

INDEX_SAMPLE_CLOCKS = 1
"""Clocks from the gate bits of a word to `index_sample`."""

INDEX_CLOCKS = 2
"""Clocks from the gate bits of a word to `index`, `home` and `homed`."""


def first_rise(levels, before):
    """The first sample of a word at which `levels` rises, as one-hot bits; `before` is the level before the word.

    Returns `(first, second)`: the one-hot bits, and 1 when the word holds another rise after that.
    """
    rises = [levels[i] & ~(levels[i - 1] if i else before) for i in range(len(levels))]
    first, seen, second = [], 0, 0
    for rise in rises:
        first.append(rise & ~seen if first else rise)
        second = second | (rise & seen)
        seen = seen | rise
    return Cat(*first), second


class IndexDetector(wiring.Component):
    """Places the index in its word and decides which one homes.

    A word reports one index at most: steps of one count cannot leave a gate state and reach the next inside a word,
    so a second entry is the same place again. Sitting in the zero mark at the first sample counts as an index.
    """

    def __init__(self, samples_per_word: int):
        super().__init__(
            {
                "gate": In(samples_per_word),
                "rehome": In(1),
                "index_sample": Out(samples_per_word),
                "index": Out(1),
                "home": Out(1),
                "homed": Out(1),
            }
        )

    gate: In
    """Bit i: at sample i, Z is high and (A, B) is the gate state."""
    rehome: In
    """1 for one clock: the next index homes again."""
    index_sample: Out
    """Bit i: the index was entered at sample i; `INDEX_SAMPLE_CLOCKS` clocks after `gate`."""
    index: Out
    """1 with a word in which the index was entered; `INDEX_CLOCKS` clocks after `gate`."""
    home: Out
    """1 with the word of the first index."""
    homed: Out
    """1 from the word of the first index on."""

    def elaborate(self, platform):
        m = Module()
        last_gate = Signal()
        first, _ = first_rise(self.gate, last_gate)
        m.d.sync += [last_gate.eq(self.gate[-1]), self.index_sample.eq(first)]
        entered = self.index_sample.any()
        waits = Signal(init=1)  # the next index homes
        m.d.sync += [
            self.index.eq(entered),
            self.home.eq(entered & waits),
            self.homed.eq(self.homed | entered),
            waits.eq((waits & ~entered) | self.rehome),
        ]
        return m
