"""The self-test's square waves in numpy, word for word what `SquareWaveGenerator` makes."""

import numpy as np

from arcref_gateware.boards.square_wave_generator import (
    FAULT_PERIOD,
    GENERATOR_CLOCKS,
    LEG_WORDS,
    PERIODS_BITS,
    RATE_BITS,
    START_COUNT,
)


def square_wave_samples(words: int, samples_per_word: int, rate: int, legs: int, fault: str | None = None):
    """Samples of the first `words` words after reset, oldest first.

    Gives a dict of boolean arrays `a`, `b`, `z`, `strobe`, each of `words * samples_per_word` samples, and `count`,
    the count (int64, not modulo a turn) that the encoder shows at each sample.
    """
    moving = max(0, words - GENERATOR_CLOCKS)
    word = np.arange(moving, dtype=np.int64)
    leg = word // (LEG_WORDS * legs)
    sign = np.where(leg % 2 == 0, 1, -1)
    place = word[:, None] * samples_per_word + np.arange(samples_per_word + 1)
    steps = (place * rate >> RATE_BITS) - (place[:, :1] * rate >> RATE_BITS)
    start = START_COUNT + np.concatenate(([0], np.cumsum(sign * steps[:, -1])))[:moving]
    count = start[:, None] + sign[:, None] * steps[:, 1:]

    state, period = count & 3, (count >> 2) % (1 << PERIODS_BITS)
    a, b, z = (state == 1) | (state == 2), state >= 2, period == 0
    due = (period == FAULT_PERIOD) & (leg == 0)[:, None]
    if fault == "dropped_edge":
        a &= ~due
    elif fault == "doubled_step":
        a &= ~(due & (state == 1))
    elif fault == "missing_index":
        z &= (leg != 1)[:, None]
    strobe = np.zeros_like(a)
    strobed = word[(word + 1) % LEG_WORDS == 0]
    strobe[strobed, (strobed // LEG_WORDS) % samples_per_word] = True

    still = np.zeros((min(words, GENERATOR_CLOCKS), samples_per_word), bool)
    lines = {name: np.concatenate((still, line)).ravel() for name, line in zip("abz", (a, b, z), strict=True)}
    lines["strobe"] = np.concatenate((still, strobe)).ravel()
    lines["count"] = np.concatenate((np.full(still.shape, START_COUNT), count)).ravel()
    return lines
