"""A shaft whose speed is set while it turns, and where it was at any time."""

import bisect

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.motion import UniformSegment


class LiveMotion:
    """Starts at `start_counts` with `speed_rps`. Angles are in counts, turns included; times in seconds.

    Kept are the changes of speed, so the truth is known over the whole run whatever its length.
    """

    def __init__(self, start_counts: float, speed_rps: float = 0.0):
        self.start_counts = start_counts
        self._starts_s = [0.0]
        self._segments = [UniformSegment(start_counts, speed_rps * COUNTS_PER_TURN, 0.0, np.inf)]
        self.target_rps = speed_rps

    def set_speed(self, time_s: float, speed_rps: float, acceleration_rps2: float | None = None) -> None:
        """From `time_s` on change the speed to `speed_rps`, at once or with an acceleration (a magnitude).

        What was set for later is dropped. Raises ValueError for a time before the last change that has begun.
        """
        place = bisect.bisect_right(self._starts_s, time_s)
        if place < 1:
            raise ValueError("the shaft's past cannot be changed")
        del self._starts_s[place:], self._segments[place:]
        counts, speed = self._at(time_s)
        target = speed_rps * COUNTS_PER_TURN
        if acceleration_rps2:
            acceleration = np.copysign(acceleration_rps2 * COUNTS_PER_TURN, target - speed)
            turning = [0.0] if speed * target < 0 else []  # a segment does not change its direction
            for until in (*turning, target):
                if until != speed:
                    self._append(time_s, UniformSegment(counts, speed, acceleration, np.inf))
                    time_s += (until - speed) / acceleration
                    counts, speed = float(self.true_counts_at(time_s)), until
        self._append(time_s, UniformSegment(counts, target, 0.0, np.inf))
        self.target_rps = speed_rps

    def true_counts_at(self, time_s):
        """True angle at a time, number or array; before the start the shaft stood."""
        time_s = np.maximum(np.asarray(time_s, dtype=np.float64), 0.0)
        index = np.searchsorted(self._starts_s, time_s, side="right") - 1
        counts = np.empty_like(time_s)
        for number in np.unique(index):
            chosen = index == number
            counts[chosen] = self._segments[number].counts_at(time_s[chosen] - self._starts_s[number])
        return counts

    def speed_rps_at(self, time_s: float) -> float:
        """Speed at a time, in turns per second."""
        return self._at(time_s)[1] / COUNTS_PER_TURN

    def between(self, begin_s: float, end_s: float) -> list[UniformSegment]:
        """The motion from `begin_s` to `end_s` as segments."""
        borders = [start for start in self._starts_s if begin_s < start < end_s]
        segments = []
        for low, high in zip([begin_s, *borders], [*borders, end_s], strict=True):
            whole = self._segments[bisect.bisect_right(self._starts_s, low) - 1]
            counts, speed = self._at(low)
            segments.append(UniformSegment(counts, speed, whole.acceleration, high - low))
        return segments

    def _at(self, time_s: float) -> tuple[float, float]:
        """Angle (counts) and speed (counts/s)."""
        place = bisect.bisect_right(self._starts_s, time_s) - 1
        segment, since_s = self._segments[place], time_s - self._starts_s[place]
        return float(segment.counts_at(since_s)), segment.speed + segment.acceleration * since_s

    def _append(self, start_s: float, segment: UniformSegment) -> None:
        if start_s == self._starts_s[-1]:
            self._segments[-1] = segment
            return
        self._starts_s.append(start_s)
        self._segments.append(segment)
