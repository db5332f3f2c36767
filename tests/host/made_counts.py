"""Edge times and fine scans of an encoder whose error within a line is given, made without the simulation."""

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, ARCSEC_PER_TURN, COUNTS_PER_TURN


def random_wave(rng: np.random.Generator, orders=(1, 2, 3, 4, 6)):
    """A random error within a line, about 1 arcsec peak to peak, as a function of the reading in counts."""
    size = rng.dirichlet(np.ones(len(orders))) * 0.6
    phase = rng.uniform(0, 2 * np.pi, len(orders))

    def error_arcsec(reading_counts):
        theta = np.mod(reading_counts, 2048) * (2 * np.pi / 2048)
        return sum(a * np.sin(k * theta + p) for a, k, p in zip(size, orders, phase, strict=True))

    return error_arcsec


def edges(wave, *, ripple=0.0, order=8.0, phase=0.3, speed_rps=1.0, turns=1.0, every=61, over_turn_arcsec=5.0):
    """(count, time_s) at a speed that ripples by `ripple` (relative amplitude) `order` times a turn."""
    direction = 1 if speed_rps > 0 else -1
    count = 777 + direction * np.arange(0, int(turns * COUNTS_PER_TURN), every)
    reading = count + (direction < 0)
    turn = reading / COUNTS_PER_TURN
    true = reading * ARCSEC_PER_COUNT - wave(reading) - over_turn_arcsec * np.sin(2 * np.pi * 3 * turn)
    passed = np.abs(true - true[0]) / ARCSEC_PER_TURN
    even = passed.copy()
    for _ in range(30):
        wobble = np.sin(2 * np.pi * order * even + phase) - np.sin(phase)
        even = passed - ripple / (2 * np.pi * order) * wobble
    return count, even / abs(speed_rps)


def scan(wave, rng, *, lines=3.0, readings=360, noise_arcsec=0.1, sign=1, scale=1.0, bend_arcsec=0.0, start=123_456):
    """(count, x_arcsec) of a scan in one direction; the autocollimator drifts along a bend."""
    reading = (
        start + np.sort(np.arange(readings) / readings + 0.2 / readings * rng.uniform(size=readings)) * lines * 2048
    )
    true = reading * ARCSEC_PER_COUNT - wave(reading)
    place = np.arange(readings) / readings
    x = -sign * scale * (true - true.mean()) + bend_arcsec * place**2 + noise_arcsec * rng.standard_normal(readings)
    return np.floor(reading).astype(int), x


def write(path, columns: dict, metadata: dict | None = None):
    """A run file."""
    lines = [f"# {key}: {value}" for key, value in (metadata or {}).items()]
    lines.append(",".join(columns))
    lines += [",".join(map(repr, row)) for row in zip(*(np.asarray(c).tolist() for c in columns.values()), strict=True)]
    path.write_text("\n".join(lines) + "\n")
    return path
