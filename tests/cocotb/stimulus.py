"""Samples of A, B, Z and strobe for the benches: made from the count that A and B show at each sample.

Count 0 is the gate state, so a core that homed there reads the count itself.
"""

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref_gateware.golden.signal_changes import STROBE_BIT, Z_BIT
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.square_waves import AB_OF_COUNT

SAMPLE_RATE_HZ = float(COUNTS_PER_TURN)
"""At this sample rate a turn a second is one count a sample."""

SAMPLE_S = 1 / SAMPLE_RATE_HZ
SAMPLE_NS = 1e9 / SAMPLE_RATE_HZ


def lines(count, *, z=0, strobe=0) -> np.ndarray:
    """One state (bits A, B, Z, strobe) a sample, where A and B show `count`."""
    count = np.asarray(count)
    z, strobe = np.asarray(z, dtype=np.uint8), np.asarray(strobe, dtype=np.uint8)
    return AB_OF_COUNT[count & 3] | z << Z_BIT | strobe << STROBE_BIT


def mark(count, begin: int = 0, width: int = 1) -> np.ndarray:
    """Z with one mark, high at the counts from `begin` on, `width` of them."""
    return (begin <= np.asarray(count)) & (np.asarray(count) < begin + width)


def ride(start: int, *targets: int, samples_per_count: float = 2.0) -> np.ndarray:
    """The count at each sample of a shaft that goes from `start` to each of `targets` in turn, the start left out."""
    parts = []
    for target in targets:
        way = abs(target - start)
        passed = (np.arange(1, round(way * samples_per_count) + 1) / samples_per_count + 1e-9).astype(np.int64)
        parts.append(start + np.sign(target - start) * passed)
        start = target
    return np.concatenate(parts)


def rest(count: int, samples: int) -> np.ndarray:
    """The count at each sample of a shaft that stands still."""
    return np.full(samples, count)


def hold_steps(count, random, longest: int) -> np.ndarray:
    """Each entry of `count` held for 1 up to `longest` samples."""
    return np.repeat(count, random.integers(1, longest, len(count), endpoint=True))


def random_walk(random, start: int, steps: int, chances=(0.2, 0.2, 0.6)) -> np.ndarray:
    """The count of a shaft that steps by -1, 0 or 1 at each sample, with these chances, reversed now and then."""
    step = random.choice([-1, 0, 1], p=chances, size=steps)
    turned = np.cumsum(random.random(steps) < 0.01) & 1
    return start + np.cumsum(np.where(turned, -step, step))


def strobes(samples: int, at, width: int = 1) -> np.ndarray:
    """A strobe line of `samples` samples with a pulse of `width` samples from each of `at` on."""
    line = np.zeros(samples, dtype=bool)
    for first in at:
        line[first : first + width] = True
    return line


def encoder_run(motion, **encoder) -> tuple[np.ndarray, np.ndarray]:
    """States and true counts of the synthetic encoder in `motion`, one each a sample."""
    piece = SyntheticEncoder(motion, SAMPLE_RATE_HZ, **encoder).whole()
    return piece.changes.to_samples(), piece.count_at(np.arange(piece.changes.end))
