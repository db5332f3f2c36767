"""Edge spacing: the margin before a count is lost, told before one is."""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

from arcref_gateware.edge_spacing import EDGE_SPACING_CLOCKS, EdgeSpacing, longest_quiet_words
from arcref_gateware.golden.steps import NO_SPACING, EdgeSpacingModel
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_gateware.running_largest import RunningLargest

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
ILLEGAL = 2
"""Stands for an illegal step in a list of steps."""


@cache
def bench(samples_per_word: int) -> Bench:
    return Bench(EdgeSpacing(samples_per_word), ["counted", "edge", "clear"], ["shortest", "at_limit"])


def run(samples_per_word, step, clear=0):
    """Shortest spacing after each word, and whether the word was at the limit."""
    step = np.asarray(step).reshape(-1, samples_per_word)
    shown = EDGE_SPACING_CLOCKS + RunningLargest.CLOCKS
    clocks = len(step) + shown
    lines = {"counted": as_bits(np.abs(step) == 1), "edge": as_bits(step != 0)}
    rows = bench(samples_per_word).run(clocks, **{name: np.append(row, 0) for name, row in lines.items()}, clear=clear)
    return rows["shortest"][shown:], rows["at_limit"][EDGE_SPACING_CLOCKS:][: len(step)]


def by_hand(samples_per_word, step):
    """The same, sample by sample, for runs without long rests."""
    shortest, last_edge, rows = NO_SPACING, None, []
    at_limit = []
    for sample, change in enumerate(step):
        if sample % samples_per_word == 0:
            rows.append(shortest)
            at_limit.append(False)
        if change and last_edge is not None and change != ILLEGAL:
            shortest = min(shortest, sample - last_edge)
            at_limit[-1] |= sample - last_edge == 1
        if change:
            last_edge = sample
        rows[-1] = shortest
    return np.array(rows), np.array(at_limit)


@each_word_size
@pytest.mark.parametrize("density", [0.01, 0.1, 0.5, 1.0])
def test_random_edges_at_every_sample_of_a_word(samples_per_word, density, rng):
    for length in (200, 40, 40, 40):
        samples = length * samples_per_word
        step = np.where(rng.random(samples) < density, rng.choice([-1, 1], samples), 0)
        shortest, at_limit = run(samples_per_word, step)
        expected_shortest, expected_at_limit = by_hand(samples_per_word, step)
        assert_rows("shortest", shortest, expected_shortest)
        assert_rows("at limit", at_limit, expected_at_limit)


@each_word_size
def test_an_illegal_step_starts_a_spacing_and_ends_none(samples_per_word, rng):
    step = rng.choice([0, 1, -1, ILLEGAL], 300 * samples_per_word, p=[0.94, 0.02, 0.02, 0.02])
    shortest, at_limit = run(samples_per_word, step)
    expected_shortest, expected_at_limit = by_hand(samples_per_word, step)
    assert_rows("shortest", shortest, expected_shortest)
    assert_rows("at limit", at_limit, expected_at_limit)


@each_word_size
def test_every_spacing_at_every_place(samples_per_word):
    """One pair of edges a run: falling spacings, so that each is the shortest so far when it comes."""
    step = []
    for spacing in (37, *range(17, 0, -1)):
        for _ in range(samples_per_word):
            step += [1] + [0] * (spacing - 1) + [1] + [0] * (50 + (spacing + 1) % 2)
    step += [0] * (-len(step) % samples_per_word)
    shortest, at_limit = run(samples_per_word, step)
    expected_shortest, expected_at_limit = by_hand(samples_per_word, step)
    assert_rows("shortest", shortest, expected_shortest)
    assert_rows("at limit", at_limit, expected_at_limit)


@each_word_size
def test_the_limit_is_told_before_the_first_count_is_lost(samples_per_word):
    """A speed that ramps up through one count a sample: samples, not time, decide what is seen."""
    speed = np.linspace(0.05, 3.5, 500 * samples_per_word)
    change = np.diff(np.floor(np.cumsum(speed)).astype(int), prepend=0)
    step = np.select([change == 1, change == 2, change == 3], [1, ILLEGAL, -1], 0)  # what quadrature makes of it
    _, at_limit = run(samples_per_word, step)
    told = int(np.argmax(at_limit))
    first_lost = int(np.argmax(change > 1)) // samples_per_word
    assert at_limit[told]
    assert told < first_lost


@each_word_size
def test_clear_starts_the_search_again(samples_per_word):
    """Both edges of a spacing that is found after the clear may lie on either side of it."""
    n = samples_per_word
    step = np.zeros(120 * n, int)
    step[[10 * n, 11 * n, 60 * n, 64 * n, 100 * n]] = 1
    shortest, _ = run(n, step, clear=[0] * (EDGE_SPACING_CLOCKS + 40) + [1, 0])
    assert set(shortest[11:40].tolist()) == {n}
    assert set(shortest[41:60].tolist()) == {NO_SPACING}
    assert set(shortest[60:64].tolist()) == {49 * n}
    assert set(shortest[64:].tolist()) == {4 * n}


@each_word_size
def test_a_rest_beyond_the_range_is_no_spacing_and_never_a_short_one(samples_per_word, rng):
    """Around the longest rest that is measured, and around the range of the counter and its multiples."""
    longest = longest_quiet_words(samples_per_word)
    for quiet in (longest - 2, longest - 1, longest, longest + 1, 2 * longest, 2 * longest + 1, 4 * longest + 3):
        rest = [0] * (quiet * samples_per_word)
        edges = rng.permutation([1] + [0] * (samples_per_word - 1)).tolist()
        step = edges + rest + edges[::-1]
        shortest, at_limit = run(samples_per_word, step)
        model = EdgeSpacingModel(samples_per_word)
        step = np.array(step)
        model.run(np.arange(len(step)), step, np.zeros(len(step), bool))
        assert shortest[-1] == model.shortest
        assert (model.shortest == NO_SPACING) == (quiet >= longest)
        assert not at_limit.any()


@each_word_size
def test_the_golden_model_agrees_with_a_plain_loop(samples_per_word, rng):
    step = rng.choice([0, 1, -1, ILLEGAL], 2000, p=[0.97, 0.01, 0.01, 0.01])
    expected_shortest, expected_at_limit = by_hand(samples_per_word, step)
    model = EdgeSpacingModel(samples_per_word)
    for start in range(0, 2000, 100):
        part = step[start : start + 100]
        word = model.run(np.arange(start, start + 100), np.where(part == ILLEGAL, 0, part), part == ILLEGAL)
        words = slice(start // samples_per_word, (start + 100) // samples_per_word)
        assert model.shortest == expected_shortest[words][-1]
        at = np.flatnonzero(expected_at_limit[words])
        assert word == (start // samples_per_word + at[0] if len(at) else None)
