"""The start-up self-check of the sample order: a known pattern goes out on a spare pad and comes back sampled.

The pattern stays at each level for `run_samples` samples, longer than a word, and its edges fall on every place in
the word in turn. Read in the right order, every run comes back with its length, to within what a pad's edges cost.
Any other order of the samples in a word tears the edges that lie inside it and makes runs of a few samples; a word
lost or taken twice shortens or lengthens a run by a word. The check passes when edges were seen at every place and
`RUNS` runs in a row were right; it fails with the first wrong run, or when the pattern does not come at all.

What it cannot see: it looks at the spare pad's own path. That A, B, Z and strobe are cut into words at the same
sample as it is rests on the start-up sequence (`start_up`), which starts all of them with the same edge of the clock.
"""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

RUNS = 1024
"""Right runs that must come one after the other."""

TOLERANCE_SAMPLES = 2
"""A run may be off by so many samples: edges that fall near a sample, and a pad that rises and falls unequally fast."""

SETTLE_WORDS = 64
"""Words before the first one that counts: the pad starts to be driven, registers fill."""


class AlignmentCheck(wiring.Component):
    """Judges the words of the alignment pad, in the domain `word`.

    `run_samples` is the length of the pattern's runs, a fraction where the pattern has a clock of its own. It must
    leave `samples_per_word` samples and more when the tolerance is taken off. Raises ValueError for others.
    """

    def __init__(self, samples_per_word: int, run_samples: float):
        self.shortest = int(run_samples) - TOLERANCE_SAMPLES
        self.longest = -int(-run_samples // 1) + TOLERANCE_SAMPLES
        if samples_per_word < 2 or self.shortest < samples_per_word:
            raise ValueError(f"runs of {run_samples!r} samples cannot show the order of {samples_per_word!r} in a word")
        self.samples_per_word = samples_per_word
        self.longest_words = SETTLE_WORDS + 2 * RUNS * (self.longest // samples_per_word + 1)
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

        # Where the level changes: between sample k and the one before it.
        last = Signal()
        changes = Signal(samples)
        m.d.word += [
            last.eq(self.word[-1]),
            changes.eq(self.word ^ ((self.word << 1) | last)),
        ]

        # Of a word without torn edges: its one change, and the length of the run that ends there.
        several = Signal()
        change = Signal()
        places = Signal(samples)
        place = Signal(range(samples))
        m.d.word += [several.eq((changes & (changes - 1)).any()), change.eq(changes.any()), places.eq(changes)]
        for k in range(samples):
            with m.If(changes[k]):
                m.d.word += place.eq(k)
        too_long = self.longest + 1
        since_change = Signal(range(too_long + samples + 1))  # samples of the present run before this word
        length = Signal(range(too_long + 2 * samples + 1))
        ended = Signal()
        torn = Signal()
        seen_places = Signal(samples)
        m.d.word += [
            length.eq(since_change + place),
            ended.eq(change),
            torn.eq(several),
            seen_places.eq(places),
            since_change.eq(
                Mux(change, samples - place, Mux(since_change >= too_long, too_long, since_change + samples))
            ),
        ]
        wrong = Signal()
        right = Signal()
        good_places = Signal(samples)
        in_limits = (length >= self.shortest) & (length <= self.longest)
        m.d.word += [
            wrong.eq(torn | (ended & ~in_limits)),
            right.eq(ended & ~torn & in_limits),
            good_places.eq(seen_places),
        ]

        # The verdict. The run that is under way when the judging begins is whole: the pattern has run for a while.
        words = Signal(range(self.longest_words + 1))
        settled = Signal()
        runs = Signal(range(RUNS + 1))
        all_places = Signal(samples)
        late = Signal()
        enough = Signal()
        m.d.word += [
            settled.eq(words >= SETTLE_WORDS),
            late.eq(words == self.longest_words),
            enough.eq((runs == RUNS) & all_places.all()),
        ]
        judging = Signal()
        m.d.comb += [judging.eq(~self.passed & ~self.failed), self.drive.eq(judging)]
        with m.If(judging):
            m.d.word += words.eq(words + 1)
            with m.If(settled):
                with m.If(right):
                    m.d.word += all_places.eq(all_places | good_places)
                    with m.If(runs != RUNS):
                        m.d.word += runs.eq(runs + 1)
                with m.If(wrong | late):
                    m.d.word += self.failed.eq(1)
                with m.Elif(enough):
                    m.d.word += self.passed.eq(1)
        return m
