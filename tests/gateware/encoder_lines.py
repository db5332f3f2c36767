"""Lines of an encoder, made from the count that each sample sees: for tests that know the truth."""

import numpy as np

from arcref_gateware.golden.signal_changes import B_BIT, STROBE_BIT, Z_BIT, SignalChanges

LINES_OF_STATE = np.array([0b00, 0b01, 0b11, 0b10], dtype=np.uint8)
"""A in bit 0 and B in bit 1, by the number of the quadrature state: forward is (A, B) = 00, 10, 11, 01."""

GATE_STATE_NUMBER = 2
"""Number of the default gate state, (A, B) = (1, 1)."""

assert B_BIT == 1


def lines_of_counts(counts, z=False, strobe=False, start: int = 0) -> SignalChanges:
    """The lines when sample i sees `counts[i]`. Count 2 lies in the default gate state, as every fourth from it."""
    counts = np.asarray(counts)
    samples = LINES_OF_STATE[counts & 3]
    samples = samples | np.asarray(z, bool).astype(np.uint8) << Z_BIT
    samples = samples | np.asarray(strobe, bool).astype(np.uint8) << STROBE_BIT
    return SignalChanges.from_samples(samples, start)


def hold_to_word(counts, samples_per_word: int) -> np.ndarray:
    """`counts` with the last one held until a word is full."""
    counts = np.asarray(counts)
    return np.concatenate((counts, np.repeat(counts[-1:], -len(counts) % samples_per_word)))


def random_walk(rng, samples: int, illegal: float = 0.0, stretch: int = 50) -> np.ndarray:
    """Counts that go up, down, to and fro and rest, in stretches; sometimes two at once."""
    step = rng.choice([-1, 0, 1, 2], p=[0.25, 0.4, 0.35 - illegal, illegal], size=samples)
    mode = rng.integers(0, 5, samples // stretch + 1).repeat(stretch)[:samples]
    sparse = rng.random(samples) < 0.2
    step = np.select([mode == 1, mode == 2, mode == 3, mode == 4], [1, -1, sparse * 1, sparse * -1], step)
    return np.cumsum(step)
