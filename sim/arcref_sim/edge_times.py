"""Edges of A, B and Z from a motion: when each comes, solved exactly, in chunks that keep the memory small."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.square_waves import SquareWaves, ZeroMark

CHUNK_EDGES = 1 << 15
"""Edges made at a time: small enough that every array of a chunk stays in the processor's cache."""

CHUNK_CONVERSIONS = 1 << 12


@dataclass(frozen=True)
class Edges:
    """Edges in the order of time: `time_s` (float64, never falling), and after each `count` (int64) and `z` (uint8).

    An edge of Z alone repeats the count before it.
    """

    time_s: np.ndarray
    count: np.ndarray
    z: np.ndarray


class EdgeSource:
    """Makes the edges of one encoder in one motion, chunk after chunk. Each call of `chunks` starts anew."""

    def __init__(
        self, motion: Motion, graduation: GraduationError, waves: SquareWaves, zero_mark: ZeroMark, seed: int = 0
    ):
        self._motion, self._graduation, self._waves = motion, graduation, waves
        self.zero_mark = zero_mark
        self._seed = seed
        self.start_reading = float(graduation.reading_at(motion.start_counts))
        self.start_count = int(waves.count_at_reading(self.start_reading))
        if waves.conversion_interval_ns:
            self.start_z = int(zero_mark.level_at(self.start_count + 0.5))
        else:
            self.start_z = int(zero_mark.level_at(self.start_reading))

    def chunks(self, segments: Iterable | None = None) -> Iterator[Edges]:
        """All edges after time 0 in chunks.

        `segments` replaces those of the motion, one after the other as they are asked for, so that a motion may be
        made up as it goes; an empty chunk follows each of them. With a conversion interval there is no such row.
        """
        source = self._conversions() if self._waves.conversion_interval_ns else self._continuous(segments)
        random = np.random.default_rng(self._seed)
        last_s = -np.inf
        z = self.start_z
        for time_s, count, z_times_s in source:
            time_s = self._shape(time_s, last_s, random)
            before_s, last_s = last_s, time_s[-1] if len(time_s) else last_s
            if self._waves.conversion_interval_ns:
                yield Edges(time_s, count, self.zero_mark.level_at(count + 0.5))
                continue
            level = np.full(len(time_s), z, dtype=np.uint8)
            if len(z_times_s):
                # Jitter may have moved the edges before a chunk past an edge of Z that belongs to it.
                z_times_s = np.maximum(z_times_s + self._waves.delay_ns * 1e-9, before_s)
                time_s, count, level = self._with_z_edges(time_s, count, z_times_s, z)
                z, last_s = int(level[-1]), time_s[-1]
            yield Edges(time_s, count, level)

    def _shape(self, time_s, last_s: float, random) -> np.ndarray:
        """Adds delay and jitter, and keeps the shortest spacing; `last_s` is the time of the edge before all."""
        waves = self._waves
        if waves.delay_ns:
            time_s = time_s + waves.delay_ns * 1e-9
        if waves.jitter_ns:
            time_s = time_s + random.standard_normal(len(time_s)) * (waves.jitter_ns * 1e-9)
        if len(time_s) and (waves.jitter_ns or waves.shortest_edge_spacing_ns or waves.conversion_interval_ns):
            own = np.arange(1, len(time_s) + 1) * (waves.shortest_edge_spacing_ns * 1e-9)
            time_s = np.maximum(np.maximum.accumulate(time_s - own), last_s) + own
        return time_s

    def _with_z_edges(self, time_s, count, z_times_s, z: int):
        """Merges edges of Z, which come at `z_times_s` and start from level `z`."""
        place = np.searchsorted(time_s, z_times_s, side="right")
        before = np.append(self._count_before_chunk, count)
        level = (z + np.searchsorted(z_times_s, time_s, side="right")) & 1
        time_s = np.insert(time_s, place, z_times_s)
        level = np.insert(level, place, (z + 1 + np.arange(len(z_times_s))) & 1).astype(np.uint8)
        return time_s, np.insert(count, place, before[place]), level

    def _continuous(self, segments: Iterable | None):
        """Times (s) and counts of the edges of A and B, with the times of the edges of Z that fall among them."""
        count, begin_s, begin_reading = self.start_count, 0.0, self.start_reading
        for segment in self._motion.segments if segments is None else segments:
            end = self._graduation.reading_at(segment.counts_at(segment.duration_s))
            end_reading = float(self._waves.shown_reading(begin_reading, [end])[0])
            direction = segment.direction
            # In reverse the reading is lower than what is shown.
            lag = self._waves.hysteresis_counts if direction < 0 else 0.0
            passed = int(self._waves.count_at_reading(end_reading)) - count
            z_times_s = self._z_times(segment, begin_reading, end_reading, lag) + begin_s
            for start in range(0, max(passed * direction, 1), CHUNK_EDGES):
                number = max(min(passed * direction - start, CHUNK_EDGES), 0)
                if number == 0 and len(z_times_s) == 0:
                    continue
                self._count_before_chunk = count
                low = count + 1 if direction > 0 else count - number + 1
                way_s = segment.time_at(self._true_at_edges(low, number, lag)) if number else np.zeros(0)
                time_s = np.clip(way_s, 0, segment.duration_s)
                time_s += begin_s
                counts = np.arange(count + direction, count + direction * (number + 1), direction or 1)
                if direction < 0:
                    time_s = time_s[::-1]
                last_chunk = start + CHUNK_EDGES >= passed * direction
                now = len(z_times_s) if last_chunk else np.searchsorted(z_times_s, time_s[-1], side="right")
                yield time_s, counts, z_times_s[:now]
                z_times_s = z_times_s[now:]
                count += direction * number
            begin_s += segment.duration_s
            begin_reading = end_reading
            if segments is not None:
                yield np.zeros(0), np.zeros(0, np.int64), np.zeros(0)

    def _true_at_edges(self, low: int, number: int, lag: float) -> np.ndarray:
        """True angles of the edges between count k - 1 and k for k from `low` on, rising."""
        shift = self._waves.edge_shift_counts
        if not shift.any() and not lag:
            return self._graduation.true_at_counts(low, number)
        k = np.arange(low, low + number)
        return self._graduation.true_at_reading(k + shift[k & 3] - lag)

    def _z_times(self, segment, begin_reading: float, end_reading: float, lag: float) -> np.ndarray:
        """Times of the edges of Z from the start of a segment, rising."""
        low, high = sorted((begin_reading, end_reading))
        edges = self.zero_mark.intervals(low, high).reshape(-1)
        # Forward an edge belongs to the segment that reaches it; in reverse, to the one that leaves it: as level_at.
        if segment.direction > 0:
            edges = edges[(edges > low) & (edges <= high)]
        else:
            edges = edges[(edges > low) & (edges <= high)][::-1]
        return segment.time_at(self._graduation.true_at_reading(edges - lag)) if len(edges) else np.zeros(0)

    def _conversions(self):
        """Times (s) and counts of edges that a converter asks for, all of a bunch at the conversion's own time."""
        interval_s = self._waves.conversion_interval_ns * 1e-9
        count, shown = self.start_count, self.start_reading
        total = int(self._motion.duration_s / interval_s)
        for first in range(1, total + 1, CHUNK_CONVERSIONS):
            time_s = np.arange(first, min(first + CHUNK_CONVERSIONS, total + 1)) * interval_s
            reading = self._graduation.reading_at(self._motion.true_counts_at(time_s))
            reading = self._waves.shown_reading(shown, reading)
            shown = float(reading[-1])
            steps = np.diff(self._waves.count_at_reading(reading), prepend=count)
            counts = count + np.cumsum(np.repeat(np.sign(steps), np.abs(steps)))
            if len(counts):
                count = int(counts[-1])
            yield np.repeat(time_s, np.abs(steps)), counts, np.zeros(0)
