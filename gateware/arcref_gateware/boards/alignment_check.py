"""The start-up self-check of the sample order: a known pattern goes out on a spare pad and comes back sampled.

The pattern is high and low for a fixed number of samples, each longer than a word, in a period that brings its
rising and its falling edges to every place in the word in turn. Read in the right order, every run comes back with
its length, to within what a pad's edges cost. Any other order of the samples in a word tears the edges that lie
inside it and makes runs of a few samples; a word lost or taken twice shortens or lengthens a run by a word. The check
passes when edges were seen at every place and `RUNS` runs were right; it fails with the first wrong run, or when the
pattern does not come at all.

What it cannot see: it looks at the spare pad's own path. That A, B, Z and strobe are cut into words at the same
sample as it is rests on the start-up sequence (`start_up`), which starts all of them with the same edge of the clock.
"""

from dataclasses import dataclass
from math import ceil, floor

from amaranth.hdl import Cat, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref_gateware.register_stages import delayed

RUNS = 1024
"""Right runs that must come; a power of two."""

TOLERANCE_SAMPLES = 2
"""A run may be off by so many samples: edges that fall near a sample, and a pad that rises and falls unequally fast."""

SETTLE_WORDS = 64
"""Words before the first one that counts: the pad starts to be driven, registers fill. A power of two."""

WORDS_BITS = 4
"""Width of the counter of words within a run; at its end it stays, which is too long a run."""


@dataclass(frozen=True)
class AlignmentPattern:
    """What the pad sends: so many samples high, so many low, a fraction where the pattern has a clock of its own."""

    high_samples: float
    low_samples: float


class AlignmentCheck(wiring.Component):
    """Judges the words of the alignment pad.

    Raises ValueError for a `pattern` whose runs, with the tolerance taken off, are shorter than a word of
    `samples_per_word` samples, or too long to be measured.
    """

    def __init__(self, samples_per_word: int, pattern: AlignmentPattern):
        self.limits = [
            (floor(run_samples) - TOLERANCE_SAMPLES, ceil(run_samples) + TOLERANCE_SAMPLES)
            for run_samples in (pattern.low_samples, pattern.high_samples)
        ]
        shortest = min(low for low, _ in self.limits)
        longest_words = max(ceil(high / samples_per_word) for _, high in self.limits)
        if samples_per_word < 2 or shortest < samples_per_word or longest_words >= (1 << WORDS_BITS) - 1:
            raise ValueError(f"{pattern} cannot show the order of {samples_per_word!r} samples in a word")
        self.samples_per_word = samples_per_word
        self.time_limit_words = SETTLE_WORDS + 2 * RUNS * longest_words
        super().__init__({"word": In(samples_per_word), "drive": Out(1), "passed": Out(1), "failed": Out(1)})

    word: In
    """Samples of the alignment pad, bit 0 the oldest."""
    drive: Out
    """1 while the pattern must go out."""
    passed: Out
    """1 once the order of the samples has proved right; stays until reset."""
    failed: Out
    """1 once it has proved wrong, or no pattern came; stays until reset."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word

        # Where the level changes: between sample k and the one before it. A word torn apart changes more than once.
        last = Signal(reset_less=True)
        changes = Signal(samples, reset_less=True)
        m.d.sync += [last.eq(self.word[-1]), changes.eq(self.word ^ ((self.word << 1) | last))]
        torn = Signal(reset_less=True)
        change = Signal(reset_less=True)
        places = Signal(samples, reset_less=True)
        place = Signal(range(samples), reset_less=True)
        pairs = [changes[i] & changes[k] for k in range(samples) for i in range(k)]
        m.d.sync += [torn.eq(Cat(pairs).any()), change.eq(changes.any()), places.eq(changes)]
        for k in range(samples):
            with m.If(changes[k]):
                m.d.sync += place.eq(k)

        # Length of the run that a change ends: words since the change before it, and where in their words both are.
        words_since = Signal(WORDS_BITS, reset_less=True)
        place_before = Signal(range(samples), reset_less=True)
        with m.If(change):
            m.d.sync += [words_since.eq(1), place_before.eq(place)]
        with m.Elif(~words_since.all()):
            m.d.sync += words_since.eq(words_since + 1)
        run_words = Signal(WORDS_BITS, reset_less=True)
        run_places = Signal(signed(exact_log2(samples) + 1), reset_less=True)
        length = Signal(WORDS_BITS + exact_log2(samples) + 1, reset_less=True)  # 1 and more
        low_right = Signal(reset_less=True)
        high_right = Signal(reset_less=True)
        m.d.sync += [
            run_words.eq(words_since),
            run_places.eq(place - place_before),
            length.eq(run_words * samples + run_places),
        ]
        for right_length, (shortest, longest) in zip((low_right, high_right), self.limits, strict=True):
            m.d.sync += right_length.eq(length.matches(*range(shortest, longest + 1)))
        level = delayed(m, last, 5, name="level")  # of the run that ends: the last sample before the word of its end
        ended = delayed(m, change, 3, name="ended")
        was_torn = delayed(m, torn, 3, name="was_torn")
        wrong = Signal(reset_less=True)
        right = Signal(reset_less=True)
        in_limits = Mux(level, high_right, low_right)
        m.d.sync += [wrong.eq(was_torn | (ended & ~in_limits)), right.eq(ended & ~was_torn & in_limits)]
        good_places = delayed(m, places, 5, name="places")

        # The verdict. The run that is under way when the judging begins is whole: the pattern has run for a while.
        words = Signal(self.time_limit_words.bit_length() + 1)
        late = words[-1]
        settled = Signal()
        wrong_due = Signal()
        right_due = Signal()
        runs = Signal(RUNS.bit_length())
        all_places = Signal(samples)
        enough = Signal()
        m.d.sync += [
            settled.eq(settled | words[SETTLE_WORDS.bit_length() - 1]),
            wrong_due.eq(wrong & settled),
            right_due.eq(right & settled),
            enough.eq(runs[-1] & all_places.all()),
            self.drive.eq(~self.passed & ~self.failed),
        ]
        with m.If(~late):
            m.d.sync += words.eq(words + 1)
        with m.If(right_due):
            m.d.sync += all_places.eq(all_places | good_places)
        with m.If(right_due & ~runs[-1]):
            m.d.sync += runs.eq(runs + 1)
        with m.If(~self.passed & ~self.failed):
            with m.If(wrong_due | late):
                m.d.sync += self.failed.eq(1)
            with m.Elif(enough):
                m.d.sync += self.passed.eq(1)
        return m
