"""The test generator's square waves in numpy, word for word what `SquareWaveGenerator` makes."""

import numpy as np

from arcref.link.registers import GENERATOR_FAULTS
from arcref_gateware.boards.square_wave_generator import (
    FAULT_PERIOD,
    GENERATOR_CLOCKS,
    PERIODS_BITS,
    RATE_BITS,
    START_COUNT,
)


def square_wave_samples(samples_per_word: int, rate, *, run=True, reverse=False, fault=0, strobe_words: int = 256):
    """Samples of the first words after reset, oldest first, as the words are asked for by the inputs.

    `rate` has an entry a word; `run`, `reverse` and `fault` have one, too, or are one number for all. Gives a dict of
    boolean arrays `a`, `b`, `z`, `strobe`, each of `len(rate) * samples_per_word` samples, and `count`, the count
    (int64, not modulo a turn) that the encoder shows at each sample. What is asked of the last `GENERATOR_CLOCKS`
    words is not seen any more.
    """
    words = len(rate)
    rate, run, reverse, fault = (np.broadcast_to(value, words)[:, None] for value in (rate, run, reverse, fault))
    rate = rate.astype(np.int64) * run.astype(bool)
    onward = np.concatenate((np.zeros(1, np.int64), np.cumsum(rate * samples_per_word)))[:-1, None]
    ahead = onward + rate * np.arange(1, samples_per_word + 1)
    steps = np.where(reverse, -1, 1) * ((ahead >> RATE_BITS) - (onward >> RATE_BITS))
    start = START_COUNT + np.concatenate((np.zeros(1, np.int64), np.cumsum(steps[:, -1])))[:-1, None]
    count = start + steps

    state, period = count & 3, (count >> 2) % (1 << PERIODS_BITS)
    has = {name: fault >> bit & 1 == 1 for bit, name in enumerate(GENERATOR_FAULTS)}
    backwards = reverse.astype(bool)
    at_fault = (period == FAULT_PERIOD) & ~backwards
    b = state >= 2
    a = ((state == 1) | (state == 2)) & ~(at_fault & (has["dropped_edge"] | has["doubled_step"] & ~b))
    z = ((period == 0) | (period == 1) & has["wide_index"]) & ~(has["missing_index"] & backwards)
    strobe = np.zeros_like(a)
    strobed = np.arange(strobe_words - 1, words, strobe_words)
    strobe[strobed, np.arange(len(strobed)) % samples_per_word] = True

    still = np.zeros((GENERATOR_CLOCKS, samples_per_word), bool)
    lines = {"a": a, "b": b, "z": z, "strobe": strobe}
    lines = {name: np.concatenate((still, line))[:words].ravel() for name, line in lines.items()}
    lines["count"] = np.concatenate((np.full(still.shape, START_COUNT), count))[:words].ravel()
    return lines
