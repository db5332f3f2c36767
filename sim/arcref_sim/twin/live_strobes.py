"""Strobes on the pin that are set while the twin runs."""

import numpy as np

from arcref_sim.faults import LineHold, strobe_pulses


class LiveStrobes:
    """Rising edges of the strobe pin: at a rate, even or random, and bursts besides. Times are in samples."""

    def __init__(self, sample_rate_hz: float, samples_per_word: int, seed: int = 0):
        self._sample_rate_hz = sample_rate_hz
        self._pulse = max(samples_per_word // 2, 1)
        self._random = np.random.default_rng(seed)
        self._next: float | None = None
        self._burst: list[int] = []
        self.rate_hz = 0.0
        self.is_random = False
        self.number = 0

    def set_rate(self, sample: int, rate_hz: float, *, is_random: bool = False) -> None:
        """From `sample` on strobe `rate_hz` times a second, at even distances or at random ones; 0 stops it.

        Raises ValueError for a rate at which the pulses would meet.
        """
        if rate_hz < 0 or (rate_hz and self._sample_rate_hz / rate_hz < 2 * self._pulse):
            raise ValueError(f"{rate_hz:g} strobes/s: it must lie in 0 .. {self._sample_rate_hz / (2 * self._pulse):g}")
        self.rate_hz, self.is_random = rate_hz, is_random
        self._next = sample + self._distance() if rate_hz else None

    def burst(self, sample: int, number: int, spacing: int) -> None:
        """`number` strobes, `spacing` samples apart, the first at `sample`. Raises ValueError if they would meet."""
        if number < 1 or spacing < 2 * self._pulse:
            raise ValueError(f"a burst needs 1 strobe or more, {2 * self._pulse} samples or more apart")
        self._burst += [sample + n * spacing for n in range(number)]

    def pulses_up_to(self, end: int) -> tuple[list[int], list[LineHold]]:
        """Strobes that rise from the last call's end up to `end`: their samples, and the pulses."""
        rises = [sample for sample in self._burst if sample < end]
        self._burst = self._burst[len(rises) :]
        while self._next is not None and self._next < end:
            rises.append(int(self._next))
            self._next += self._distance()
        rises.sort()
        self.number += len(rises)
        return rises, strobe_pulses(rises, self._pulse)

    def _distance(self) -> float:
        mean = self._sample_rate_hz / self.rate_hz
        if not self.is_random:
            return mean
        least = 2 * self._pulse
        return least + self._random.exponential(mean - least) if mean > least else mean
