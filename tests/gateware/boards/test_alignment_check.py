# amaranth: UnusedElaboratable=no
"""The start-up self-check of the sample order, against patterns that are right, torn, slipped and missing."""

import itertools

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits

from arcref_gateware.boards.alignment_check import RUNS, SETTLE_WORDS, AlignmentCheck, AlignmentPattern

RUNS_7_8 = AlignmentPattern(7, 8)


def verdict(samples, samples_per_word: int, runs: AlignmentPattern = RUNS_7_8) -> tuple[int, int, int]:
    """Whether it passed, whether it failed, and with which word the verdict came."""
    check = AlignmentCheck(samples_per_word, runs)
    words = as_bits(np.asarray(samples).reshape(-1, samples_per_word))
    rows = Bench(check, ["word"], ["passed", "failed", "drive"]).run(len(words), word=words)
    done = rows["passed"] | rows["failed"]
    at = int(np.argmax(done)) if done.any() else -1
    assert not rows["drive"][at + 2 :].any() if done.any() else rows["drive"][2:].all()
    return int(rows["passed"][-1]), int(rows["failed"][-1]), at


def pattern(samples_per_word: int, runs: AlignmentPattern = RUNS_7_8, phase: float = 0.0, late_rise: float = 0.0):
    """Samples of the pattern, enough of them for a verdict."""
    period_samples = runs.high_samples + runs.low_samples
    words = int(SETTLE_WORDS + (RUNS / 2 + 20) * period_samples / samples_per_word) + 20
    place = (np.arange(words * samples_per_word) + phase) % period_samples
    return ((place >= late_rise) & (place < runs.high_samples)).astype(int)


@pytest.mark.parametrize("samples_per_word", [2, 4])
@pytest.mark.parametrize("runs", [RUNS_7_8, AlignmentPattern(7, 14), AlignmentPattern(44 / 3, 22)])
@pytest.mark.parametrize("phase", [0.0, 2.6, 5.0])
def test_the_right_order_passes_at_every_phase(samples_per_word, runs, phase):
    assert verdict(pattern(samples_per_word, runs, phase), samples_per_word, runs)[:2] == (1, 0)


@pytest.mark.parametrize("runs", [RUNS_7_8, AlignmentPattern(7, 14)])
@pytest.mark.parametrize("late_rise", [-1.0, 0.5, 1.0, 1.7])
def test_a_pad_that_rises_and_falls_unequally_fast_passes(runs, late_rise):
    assert verdict(pattern(4, runs, 0.3, late_rise), 4, runs)[:2] == (1, 0)


@pytest.mark.parametrize(
    "order", [order for n in (2, 4) for order in itertools.permutations(range(n)) if list(order) != sorted(order)]
)
def test_every_wrong_order_fails_within_a_few_runs(order):
    n = len(order)
    samples = pattern(n).reshape(-1, n)[:, order].ravel()
    passed, failed, at = verdict(samples, n)
    assert (passed, failed) == (0, 1)
    assert at < SETTLE_WORDS + 60


@pytest.mark.parametrize("samples_per_word", [2, 4])
@pytest.mark.parametrize("stuck", [0, 1])
def test_one_bit_of_the_word_that_is_stuck_fails(samples_per_word, stuck):
    for place in range(samples_per_word):
        samples = pattern(samples_per_word).reshape(-1, samples_per_word)
        samples[:, place] = stuck
        assert verdict(samples.ravel(), samples_per_word)[:2] == (0, 1)


@pytest.mark.parametrize("change", [-1, 1])
def test_a_word_lost_or_taken_twice_fails(change):
    words = list(pattern(4).reshape(-1, 4))
    at = 700
    words = words[:at] + words[at + 1 :] if change < 0 else words[:at] + [words[at]] + words[at:]
    passed, failed, when = verdict(np.array(words).ravel(), 4)
    assert (passed, failed) == (0, 1)
    assert abs(when - at) < 16


@pytest.mark.parametrize("samples_per_word", [2, 4])
@pytest.mark.parametrize("level", [0, 1])
def test_no_pattern_at_all_fails_when_the_time_is_over(samples_per_word, level):
    limit = 1 << AlignmentCheck(samples_per_word, RUNS_7_8).time_limit_words.bit_length()
    passed, failed, at = verdict(np.full((limit + 10) * samples_per_word, level), samples_per_word)
    assert (passed, failed) == (0, 1)
    assert at >= limit // 2


def test_a_pattern_that_shows_its_edges_at_some_places_only_does_not_pass():
    runs = AlignmentPattern(8, 8)
    assert verdict(pattern(4, runs), 4, runs)[0] == 0


@pytest.mark.parametrize(("samples_per_word", "high", "low"), [(1, 7, 8), (4, 5, 8), (4, 8, 3), (2, 7, 40)])
def test_runs_that_could_show_no_order_are_refused(samples_per_word, high, low):
    with pytest.raises(ValueError, match="cannot show the order"):
        AlignmentCheck(samples_per_word, AlignmentPattern(high, low))
