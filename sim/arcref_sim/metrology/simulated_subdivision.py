"""Simulated runs of the error within a line: samples of the signals, edge times, and a fine scan of one face."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN, LINES_PER_TURN, counts_to_deg
from arcref_sim.optics.optical_encoder import OpticalEncoder

_ROUNDS_TO_INVERT = 30


@dataclass(frozen=True)
class EvenMotion:
    """A shaft at `speed_rps` turns a second, negative in reverse, whose speed ripples by `ripples`.

    `ripples`: (order of the turn, amplitude relative to the speed, phase_deg) of each.
    """

    speed_rps: float = 1.0
    ripples: tuple[tuple[float, float, float], ...] = ()

    def true_turns(self, time_s) -> np.ndarray:
        """True angle in turns, 0 at time 0."""
        even = self.speed_rps * np.asarray(time_s, float)
        return even + self._ahead_turns(even)

    def time_s(self, true_turns) -> np.ndarray:
        """When the shaft stands at true angles in turns."""
        true_turns = np.asarray(true_turns, float)
        even = true_turns
        for _ in range(_ROUNDS_TO_INVERT):
            before, even = even, true_turns - self._ahead_turns(even)
            if not (np.abs(even - before) > 1e-15 * (1 + np.abs(even))).any():
                break
        return even / self.speed_rps

    def _ahead_turns(self, even_turns) -> np.ndarray:
        ahead = np.zeros(np.shape(even_turns))
        for order, amplitude, phase_deg in self.ripples:
            angle, phase = 2 * np.pi * order * np.asarray(even_turns), np.radians(phase_deg)
            ahead += amplitude / (2 * np.pi * order) * (np.sin(angle + phase) - np.sin(phase))
        return ahead


def simulate_edge_times(
    encoder: OpticalEncoder,
    motion: EvenMotion,
    rng: np.random.Generator,
    *,
    turns: float = 1.0,
    every: int = 61,
    start_count: int = 0,
    clock_ns: float = 1.25,
    jitter_ns: float = 0.0,
) -> dict[str, np.ndarray]:
    """Columns `count,time_s`: when every so many counts began, as a clock of `clock_ns` stamps them."""
    direction = 1 if motion.speed_rps > 0 else -1
    count = start_count + direction * np.arange(1, int(turns * COUNTS_PER_TURN) + 1, every)
    # In reverse a count begins at its upper end.
    reading_deg = counts_to_deg((count + (direction < 0)).astype(float))
    start_deg = float(encoder.true_deg(counts_to_deg(float(start_count)), direction))
    time = motion.time_s((encoder.true_deg(reading_deg, direction) - start_deg) / 360.0)
    chip = encoder.interpolator
    if chip.conversion_rate_hz:
        time = np.ceil(time * chip.conversion_rate_hz) / chip.conversion_rate_hz
    time = time + chip.delay_ns * 1e-9 + jitter_ns * 1e-9 * rng.standard_normal(time.size)
    stamp = np.ceil(time / (clock_ns * 1e-9)) * (clock_ns * 1e-9) if clock_ns else time
    return {"count": count, "time_s": np.maximum.accumulate(stamp)}


def simulate_fine_scan(
    encoder: OpticalEncoder,
    rng: np.random.Generator,
    *,
    lines: float = 3.0,
    readings: int = 360,
    start_count: int = 0,
    noise_arcsec: float = 0.1,
    scale_error: float = 0.0,
    drift_arcsec: float = 0.0,
    sign: int = 1,
) -> dict[str, np.ndarray]:
    """Columns `count,autocollimator_x_arcsec`: the shaft in small steps forward, one face in view throughout."""
    step = np.arange(readings) / readings
    reading = start_count + lines * COUNTS_PER_LINE * (step + 0.3 / readings * rng.standard_normal(readings))
    true_deg = encoder.true_deg(counts_to_deg(np.sort(reading)))
    # The face turns away as the encoder counts up: x falls where it adds to the error.
    x = -sign * (true_deg - true_deg.mean()) * 3600.0 * (1 + scale_error)
    x = x + drift_arcsec * step + noise_arcsec * rng.standard_normal(readings)
    return {"count": encoder.count(true_deg), "autocollimator_x_arcsec": x}


def simulate_samples(
    encoder: OpticalEncoder,
    motion: EvenMotion,
    rng: np.random.Generator,
    *,
    periods: float = 50.0,
    samples_per_period: float = 64.0,
    start_deg: float = 0.0,
    noise_v: float = 0.0,
) -> dict[str, np.ndarray]:
    """Columns `time_s,sine_v,cosine_v`: both signals at an even rate in time."""
    duration_s = periods / LINES_PER_TURN / abs(motion.speed_rps)
    time = np.arange(int(periods * samples_per_period) + 1) * (duration_s / (periods * samples_per_period))
    sine, cosine = encoder.signals_v(start_deg + 360.0 * motion.true_turns(time))
    noise = noise_v * rng.standard_normal((2, time.size))
    return {"time_s": time, "sine_v": sine + noise[0], "cosine_v": cosine + noise[1]}
