"""Runs of samples made from known signals: at equal angles, or in time at an uneven speed."""

from dataclasses import dataclass

import numpy as np

from arcref.subdivision.signal_model import SignalModel


def write_columns(path, names: str, columns, metadata: dict | None = None) -> None:
    """A run file of these columns, 12 digits each."""
    lines = [f"# {key}: {value}" for key, value in (metadata or {}).items()] + [names]
    lines += [",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


@dataclass(frozen=True)
class UnevenSpeed:
    """Phase over time: `periods` in a second, speed with `ripple` (relative) that repeats `waves` times a second."""

    periods: float
    ripple: float = 0.0
    waves: float = 3.0
    start_rad: float = 0.7

    def theta_rad(self, time_s) -> np.ndarray:
        wave = 2 * np.pi * self.waves
        return self.start_rad + 2 * np.pi * self.periods * (time_s + self.ripple / wave * np.sin(wave * time_s))


def at_equal_angles(model: SignalModel, periods: int, rate: int = 64, noise_v: float = 0.0, seed: int = 0):
    """Sample numbers, sine and cosine, `rate` to a period from phase 0."""
    number = np.arange(periods * rate)
    return number, *noisy(model, 2 * np.pi * number / rate, noise_v, seed)


def in_time(model: SignalModel, speed: UnevenSpeed, rate: float = 71.3, noise_v: float = 0.0, seed: int = 0):
    """Times, sine and cosine, sampled at an even rate in time: `rate` to a mean period, for one second."""
    count = int(rate * speed.periods)
    time = np.arange(count) / count
    return time, *noisy(model, speed.theta_rad(time), noise_v, seed)


def noisy(model: SignalModel, theta_rad, noise_v: float, seed: int):
    """Both channels at these phases with normal noise."""
    noise = noise_v * np.random.default_rng(seed).standard_normal((2, np.size(theta_rad)))
    sine, cosine = model.signals_v(theta_rad)
    return sine + noise[0], cosine + noise[1]
