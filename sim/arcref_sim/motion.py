"""How the shaft moves: the true angle as a function of time, and its exact inverse.

A motion is a row of segments, and each of them is monotone, so the instant at which the shaft passes any place can be
solved without search. True angles are floats in counts (turns included), times are seconds from the motion's start.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from arcref.angle import COUNTS_PER_TURN


@dataclass(frozen=True)
class UniformSegment:
    """A stretch of constant acceleration in which the speed does not change its sign.

    `start_counts` in counts, `speed` in counts/s at its start, `acceleration` in counts/s^2, `duration_s` in seconds.
    """

    start_counts: float
    speed: float
    acceleration: float
    duration_s: float

    @property
    def end_speed(self) -> float:
        """Speed at the end, counts/s."""
        return self.speed + self.acceleration * self.duration_s

    @property
    def direction(self) -> int:
        """1 forward, -1 reverse, 0 at rest."""
        return int(np.sign(self.speed + self.end_speed))

    def counts_at(self, time_s):
        """True angle `time_s` after the start of the segment."""
        return self.start_counts + time_s * (self.speed + 0.5 * self.acceleration * time_s)

    def time_at(self, counts):
        """Time from the start of the segment at which the shaft stands at `counts`, which must lie inside it."""
        way = counts - self.start_counts
        if self.acceleration == 0:
            return way / self.speed
        # This form of the quadratic's root loses no digits when the acceleration is small.
        root = np.sqrt(np.maximum(self.speed**2 + 2 * self.acceleration * way, 0))
        speed_sum = self.speed + self.direction * root
        return np.divide(2 * way, speed_sum, out=np.zeros_like(way), where=speed_sum != 0)


@dataclass(frozen=True)
class SineSegment:
    """A monotone part of `centre + amplitude sin(phase)`, both in counts; `phase` runs from `start_phase` (rad) at
    `angular_speed` (rad/s) and stays between two turning points.
    """

    centre: float
    amplitude: float
    angular_speed: float
    start_phase: float
    duration_s: float

    @property
    def _quarter(self) -> int:
        """Number of the half wave: even where sin rises, odd where it falls."""
        middle = self.start_phase + 0.5 * self.angular_speed * self.duration_s
        return round(middle / np.pi)

    @property
    def end_speed(self) -> float:
        """Speed at the end, counts/s."""
        end_phase = self.start_phase + self.angular_speed * self.duration_s
        return self.amplitude * self.angular_speed * np.cos(end_phase)

    @property
    def direction(self) -> int:
        """1 forward, -1 reverse."""
        return int(np.sign(self.amplitude)) * (-1 if self._quarter & 1 else 1)

    def counts_at(self, time_s):
        """True angle `time_s` after the start of the segment."""
        return self.centre + self.amplitude * np.sin(self.start_phase + self.angular_speed * time_s)

    def time_at(self, counts):
        """Time from the start of the segment at which the shaft stands at `counts`, which must lie inside it."""
        from_middle = np.arcsin(np.clip((counts - self.centre) / self.amplitude, -1, 1))
        phase = self._quarter * np.pi + (-from_middle if self._quarter & 1 else from_middle)
        return (phase - self.start_phase) / self.angular_speed


@dataclass(frozen=True)
class Motion:
    """A row of monotone segments, built by appending: `Motion(-1000).standstill(1e-6).constant_speed(10, turns=2)`.

    `start_counts` is the true angle at time 0, in counts. Every method returns a new motion. Speeds are in turns per
    second, negative in reverse; unless a ramp joins them, they change at once.
    """

    start_counts: float = 0.0
    segments: tuple = field(default=())

    @property
    def duration_s(self) -> float:
        """Length of the whole motion in seconds."""
        return float(sum(segment.duration_s for segment in self.segments))

    @property
    def end_counts(self) -> float:
        """True angle at the end, in counts."""
        if not self.segments:
            return self.start_counts
        return float(self.segments[-1].counts_at(self.segments[-1].duration_s))

    @property
    def end_speed_rps(self) -> float:
        """Speed at the end, in turns per second."""
        return self.segments[-1].end_speed / COUNTS_PER_TURN if self.segments else 0.0

    @property
    def start_times_s(self) -> np.ndarray:
        """Start of each segment, in seconds."""
        return np.cumsum([0.0] + [segment.duration_s for segment in self.segments])[:-1]

    def standstill(self, duration_s: float) -> "Motion":
        """Rest for `duration_s`."""
        return self._append(UniformSegment(self.end_counts, 0.0, 0.0, duration_s))

    def constant_speed(
        self, speed_rps: float, duration_s: float | None = None, *, turns: float | None = None
    ) -> "Motion":
        """Turn at `speed_rps`, for `duration_s` or through `turns` turns (a magnitude)."""
        if (duration_s is None) == (turns is None):
            raise ValueError("constant_speed needs either a duration or a number of turns")
        if duration_s is None:
            duration_s = turns / abs(speed_rps)
        return self._append(UniformSegment(self.end_counts, speed_rps * COUNTS_PER_TURN, 0.0, duration_s))

    def ramp(self, speed_rps: float, duration_s: float, *, from_speed_rps: float | None = None) -> "Motion":
        """Change the speed evenly to `speed_rps` within `duration_s`, from the present one unless another is given."""
        first = self.end_speed_rps if from_speed_rps is None else from_speed_rps
        speed = first * COUNTS_PER_TURN
        acceleration = (speed_rps - first) * COUNTS_PER_TURN / duration_s
        if first * speed_rps >= 0:
            return self._append(UniformSegment(self.end_counts, speed, acceleration, duration_s))
        turning_s = -speed / acceleration
        motion = self._append(UniformSegment(self.end_counts, speed, acceleration, turning_s))
        return motion._append(UniformSegment(motion.end_counts, 0.0, acceleration, duration_s - turning_s))

    def swing(self, amplitude_counts: float, frequency_hz: float, cycles: float = 1.0) -> "Motion":
        """Move to and fro as a sine around the present place, forward first (reverse with a negative amplitude)."""
        motion, phase, end_phase = self, 0.0, 2 * np.pi * cycles
        angular_speed, centre = 2 * np.pi * frequency_hz, self.end_counts
        turning = np.pi / 2
        while phase < end_phase:
            to_phase = min(turning, end_phase)
            duration_s = (to_phase - phase) / angular_speed
            motion = motion._append(SineSegment(centre, amplitude_counts, angular_speed, phase, duration_s))
            phase, turning = to_phase, turning + np.pi
        return motion

    def true_counts_at(self, time_s):
        """True angle in counts (float64, turns included) at `time_s`, a number or an array.

        Before the start and after the end the shaft stands where it began and ended.
        """
        time_s = np.clip(np.asarray(time_s, dtype=np.float64), 0, self.duration_s)
        starts = self.start_times_s
        if len(starts) == 0:
            return np.full_like(time_s, self.start_counts)
        index = np.searchsorted(starts, time_s, side="right") - 1
        counts = np.empty_like(time_s)
        for number in np.unique(index):
            chosen = index == number
            counts[chosen] = self.segments[number].counts_at(time_s[chosen] - starts[number])
        return counts

    def _append(self, segment) -> "Motion":
        return replace(self, segments=(*self.segments, segment))
