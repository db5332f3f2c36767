"""Index detector: the first sample of the gate in a word, and which index homes."""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

from arcref_gateware.index_detector import INDEX_CLOCKS, INDEX_SAMPLE_CLOCKS, IndexDetector
from arcref_gateware.quadrature import SAMPLES_PER_WORD

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)


@cache
def bench(samples_per_word: int) -> Bench:
    return Bench(IndexDetector(samples_per_word), ["gate", "rst"], ["index_sample", "index", "home", "homed"])


def detect(samples_per_word, gate, **controls):
    """Rows of the outputs for each word of `gate`, a list of samples."""
    gate = np.asarray(gate, dtype=bool).reshape(-1, samples_per_word)
    rows = bench(samples_per_word).run(len(gate) + INDEX_CLOCKS, gate=as_bits(gate), **controls)
    late = {name: INDEX_SAMPLE_CLOCKS if name == "index_sample" else INDEX_CLOCKS for name in rows}
    return {name: column[late[name] :][: len(gate)] for name, column in rows.items()}


def first_entries(samples_per_word, gate):
    """One-hot sample of the first entry in each word, 0 where there is none: sample by sample."""
    entries, before = [], False
    for place, level in enumerate(gate):
        if place % samples_per_word == 0:
            entries.append(0)
        if level and not before and not entries[-1]:
            entries[-1] = 1 << place % samples_per_word
        before = level
    return np.array(entries)


@each_word_size
def test_the_first_entry_of_each_word_is_placed_to_the_sample(samples_per_word, rng):
    for density in (0.02, 0.2, 0.5, 0.9):
        gate = rng.random(300 * samples_per_word) < density
        rows = detect(samples_per_word, gate)
        expected = first_entries(samples_per_word, gate)
        entered = expected != 0
        places = {0, *(1 << place for place in range(samples_per_word))}
        assert set(expected.tolist()) == places or density == 0.02
        assert_rows("index sample", rows["index_sample"], expected)
        assert_rows("index", rows["index"], entered)
        assert_rows("home", rows["home"], entered & (np.cumsum(entered) == 1))
        assert_rows("homed", rows["homed"], np.cumsum(entered) > 0)


@each_word_size
@pytest.mark.parametrize("words", [1, 5])
def test_a_level_that_stays_is_one_index(samples_per_word, words):
    for place in range(samples_per_word):
        gate = np.zeros(12 * samples_per_word, bool)
        start = 3 * samples_per_word + place
        gate[start : start + words * samples_per_word] = True
        rows = detect(samples_per_word, gate)
        assert np.flatnonzero(rows["index"]).tolist() == [3]
        assert rows["index_sample"][3] == 1 << place


@each_word_size
def test_sitting_in_the_index_at_the_first_sample_is_an_index(samples_per_word):
    rows = detect(samples_per_word, np.ones(5 * samples_per_word))
    assert rows["index_sample"].tolist() == [1, 0, 0, 0, 0]
    assert rows["home"].tolist() == [1, 0, 0, 0, 0]
    assert rows["homed"].all()


@each_word_size
def test_reset_forgets_the_zero(samples_per_word):
    gate = np.zeros((30, samples_per_word), bool)
    gate[[4, 20], -1] = True
    rows = detect(samples_per_word, gate.ravel(), rst=[0] * 10 + [1, 0])
    assert np.flatnonzero(rows["home"]).tolist() == [4, 20]
    assert not rows["homed"][10:20].any()
