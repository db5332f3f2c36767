"""Partial sums: the whole word, and the way back from its end to each of its samples."""

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

from arcref_gateware.partial_sums import PARTIAL_SUM_CLOCKS, WAY_BACK_CLOCKS, PartialSums
from arcref_gateware.quadrature import SAMPLES_PER_WORD


@pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
def test_advance_and_ways_back_of_every_word(samples_per_word, rng):
    every = np.stack(np.meshgrid(*[[-1, 0, 1]] * samples_per_word), axis=-1).reshape(-1, samples_per_word)
    step = np.concatenate((rng.permutation(every), rng.integers(-1, 2, (400, samples_per_word)), every))
    words = len(step)
    place = rng.integers(-1, samples_per_word, words)
    index_sample = np.where(place < 0, 0, 1 << np.maximum(place, 0))
    home = (place >= 0) & (rng.random(words) < 0.5)
    bench = Bench(
        PartialSums(samples_per_word),
        ["forward", "reverse", "index_sample", "home"],
        ["way_back", "advance", "index_way_back"],
    )
    rows = bench.run(
        words + PARTIAL_SUM_CLOCKS,
        forward=as_bits(step > 0),
        reverse=as_bits(step < 0),
        index_sample=np.concatenate(([0], index_sample)),
        home=np.concatenate(([0, 0], home)),
    )

    remainder = np.cumsum(step[:, ::-1], axis=1)[:, ::-1] - step
    chosen = np.where(place < 0, 0, remainder[np.arange(words), place])
    assert_rows("way back", rows["way_back"][WAY_BACK_CLOCKS:][:words], -remainder)
    assert_rows("advance", rows["advance"][PARTIAL_SUM_CLOCKS:], np.where(home, chosen, step.sum(axis=1)))
    assert_rows("way back to the index", rows["index_way_back"][PARTIAL_SUM_CLOCKS:], -chosen)
