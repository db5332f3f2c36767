"""Illegal steps: counted up to the largest number and no further; the place of the first one is kept."""

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

import arcref_gateware.illegal_steps as illegal_steps
from arcref_gateware.quadrature import SAMPLES_PER_WORD

CLOCKS = illegal_steps.IllegalSteps.CLOCKS


def run(illegal):
    """Rows for words of samples that are illegal or not; position and time of word k are 1000 + k and 16 k."""
    words, samples_per_word = illegal.shape
    bench = Bench(
        illegal_steps.IllegalSteps(samples_per_word),
        ["illegal", "position", "time"],
        ["count", "first_position", "first_time"],
    )
    wait = [0] * CLOCKS
    rows = bench.run(
        words + CLOCKS + 1,
        illegal=np.append(as_bits(illegal), 0),
        position=[*wait, *(-1000 - np.arange(words + 1))],
        time=[*wait, *(16 * np.arange(words + 1))],
    )
    return {name: column[CLOCKS + (name != "count") :][:words] for name, column in rows.items()}


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_every_illegal_sample_is_counted_and_the_first_word_of_one_is_kept(samples_per_word, rng):
    illegal = rng.random((300, samples_per_word)) < 0.3
    illegal[:20] = False
    rows = run(illegal)
    count = np.cumsum(illegal.sum(axis=1))
    first = int(np.argmax(count > 0))
    assert_rows("count", rows["count"], count)
    word = np.arange(300)
    assert_rows("first position", rows["first_position"], np.where(word >= first, -1000 - first, 0))
    assert_rows("first time", rows["first_time"], np.where(word >= first, 16 * first, 0))


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_the_count_stays_at_its_largest_value(samples_per_word, monkeypatch, rng):
    """The block is made narrower, so that the end is reached: the same logic, 6 bits in place of 16."""
    monkeypatch.setattr(illegal_steps, "ILLEGAL_COUNT_BITS", 6)
    for density in (0.3, 0.9, 1.0):
        illegal = rng.random((400, samples_per_word)) < density
        assert_rows("count", run(illegal)["count"], np.minimum(np.cumsum(illegal.sum(axis=1)), 63))
