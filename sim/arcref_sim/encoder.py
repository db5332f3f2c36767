"""The synthetic encoder: sampled A, B, Z and strobe for any motion, with the truth beside them."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from arcref_gateware.golden.signal_changes import Z_BIT, SignalChanges
from arcref_sim.edge_times import EdgeSource
from arcref_sim.faults import Fault, LineOverlay
from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.square_waves import AB_OF_LOW_BYTE, SquareWaves, ZeroMark

SAMPLES_PER_PIECE = 1 << 20
"""Samples of a piece unless told otherwise: 1.3 ms at 800 M samples/s, 110 000 edges at 10 turns a second. Small enough
to stay in a processor's cache: four times as many make a long run a fifth slower."""


@dataclass(frozen=True)
class EncoderPiece:
    """One piece of the stream: what the core is given, and the count an ideal counter would show.

    `changes` are the lines. `count` (int64) holds the ideal count from each sample in `count_sample` (int64, rising)
    on; the first entry stands at the piece's start. Faults change the lines, not these counts.
    """

    changes: SignalChanges
    count_sample: np.ndarray
    count: np.ndarray

    def count_at(self, sample):
        """Ideal count at samples of this piece (number or array)."""
        return self.count[np.searchsorted(self.count_sample, sample, side="right") - 1]


@dataclass(frozen=True)
class SyntheticEncoder:
    """An encoder whose true angle is known at any sample.

    Sample s is taken at `s / sample_rate_hz` seconds and shows every edge up to that instant. Count 0 is the quadrature
    state (1,1) that begins at reading 0, where Z has its mark; the ideal counter shows floor(reading).
    """

    motion: Motion
    sample_rate_hz: float
    graduation: GraduationError = field(default_factory=GraduationError.none)
    waves: SquareWaves = field(default_factory=SquareWaves)
    zero_mark: ZeroMark = field(default_factory=ZeroMark)
    faults: tuple[Fault, ...] = ()
    seed: int = 0

    @property
    def number_of_samples(self) -> int:
        """Samples of the whole motion, a multiple of 4 so that they fill words of 1, 2 or 4."""
        return int(self.motion.duration_s * self.sample_rate_hz) // 4 * 4

    @property
    def start_count(self) -> int:
        """The count at sample 0. A counter that starts from 0 there reads counts less this one until it homes."""
        return self._source().start_count

    def true_angle_at(self, sample):
        """True angle in counts (float64, turns included) at samples, the delay of the square waves not counted."""
        return self.motion.true_counts_at(np.asarray(sample) / self.sample_rate_hz)

    def error_at(self, sample):
        """The graduation's error in counts at the true angle of samples."""
        return self.graduation.error_at(self.true_angle_at(sample))

    def samples_at_count(self, count: int) -> list[int]:
        """The samples that first show `count` when the shaft passes into it forward, or leaves it in reverse.

        They follow from the clean motion alone: jitter, delay and conversions are not counted.
        """
        reading = count + float(self.waves.edge_shift_counts[count & 3])
        true = np.asarray(self.graduation.true_at_reading(reading))
        found = []
        for start_s, segment in zip(self.motion.start_times_s, self.motion.segments, strict=True):
            low, high = sorted((segment.counts_at(0.0), segment.counts_at(segment.duration_s)))
            if segment.direction and low < true <= high:
                found.append(int(np.ceil((start_s + float(segment.time_at(true))) * self.sample_rate_hz)))
        return found

    def pieces(self, samples_per_piece: int = SAMPLES_PER_PIECE) -> Iterator[EncoderPiece]:
        """The whole run as a row of pieces of `samples_per_piece` samples (a multiple of 4), the last one shorter."""
        if samples_per_piece <= 0 or samples_per_piece % 4:
            raise ValueError("a piece must be a positive multiple of 4 samples")
        overlay, source, end = LineOverlay(self.faults), self._source(), self.number_of_samples
        held = [(np.zeros(1, np.int64), np.array([source.start_count]), np.array([source.start_z], np.uint8))]
        starts = iter(range(0, end, samples_per_piece))
        start = next(starts, None)
        for chunk in source.chunks():
            if start is None:
                return
            sample = np.ceil(chunk.time_s * self.sample_rate_hz).astype(np.int64)
            if len(sample) == 0:
                continue
            np.maximum(sample, held[-1][0][-1], out=sample)
            held.append((sample, chunk.count, chunk.z))
            # The last sample may get more edges from the next chunk, so a piece is cut only behind it.
            while start is not None and sample[-1] >= min(start + samples_per_piece, end):
                left, piece = cut_piece(held, start, min(start + samples_per_piece, end), overlay)
                held, start = [left], next(starts, None)
                yield piece
        while start is not None:
            left, piece = cut_piece(held, start, min(start + samples_per_piece, end), overlay)
            held, start = [left], next(starts, None)
            yield piece

    def whole(self) -> EncoderPiece:
        """A short run as one piece."""
        return next(self.pieces(max(self.number_of_samples, 4)))

    def _source(self) -> EdgeSource:
        return EdgeSource(self.motion, self.graduation, self.waves, self.zero_mark, self.seed)


def cut_piece(held: list, start: int, end: int, overlay: LineOverlay):
    """Takes the samples from `start` up to `end` off the held edges; returns what is left, and the piece.

    `held` is a row of (samples, counts, Z) of edges, in order, the first of them at or before `start`.
    """
    held = [np.concatenate(arrays) for arrays in zip(*held, strict=True)]
    behind = int(np.searchsorted(held[0], end))
    sample, count, z = (array[:behind] for array in held)
    left = [array[max(behind - 1, 0) :].copy() for array in held]
    left[0][0] = max(left[0][0], end)  # the next piece begins with the state that this one ends with
    last = np.append(sample[1:] != sample[:-1], True)
    if not last.all():
        sample, count, z = sample[last], count[last], z[last]
    line_sample, line_count, line_z = sample, count, z
    borders = overlay.borders(start, end)
    borders = borders[sample[np.searchsorted(sample, borders, side="right") - 1] != borders]
    if len(borders):
        place = np.searchsorted(sample, borders)
        line_sample = np.insert(sample, place, borders)
        line_count, line_z = np.insert(count, place, count[place - 1]), np.insert(z, place, z[place - 1])
    line_count = line_count + overlay.shift(start, end, line_sample)
    state = AB_OF_LOW_BYTE.take(line_count.astype(np.uint8)) | (line_z << Z_BIT)
    overlay.apply(start, end, line_sample, state)
    changed = np.append(True, state[1:] != state[:-1])
    if not changed.all():
        line_sample, state = line_sample[changed], state[changed]
    return tuple(left), EncoderPiece(SignalChanges(line_sample, state, end), sample, count)
