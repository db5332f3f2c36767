"""The synthetic encoder made up as it goes: speed, strobes and faults may be set between two pieces."""

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref_sim.edge_times import EdgeSource
from arcref_sim.encoder import EncoderPiece, cut_piece
from arcref_sim.faults import Fault, LineOverlay, PhaseShift
from arcref_sim.graduation import GraduationError
from arcref_sim.square_waves import SquareWaves, ZeroMark
from arcref_sim.twin.live_motion import LiveMotion
from arcref_sim.twin.live_strobes import LiveStrobes

_JITTER_SIGMAS = 8
"""Edges are made this many standard deviations of their jitter ahead."""


class LiveEncoder:
    """An encoder of which the next piece is asked for, and whose truth is known at any sample so far.

    Sample, count and truth mean what they mean in `SyntheticEncoder`. Raises ValueError for square waves with a
    conversion interval.
    """

    def __init__(
        self,
        motion: LiveMotion,
        sample_rate_hz: float,
        samples_per_word: int,
        *,
        graduation: GraduationError | None = None,
        waves: SquareWaves | None = None,
        zero_mark: ZeroMark | None = None,
        seed: int = 0,
    ):
        self.motion, self.sample_rate_hz, self.samples_per_word = motion, sample_rate_hz, samples_per_word
        if waves and waves.conversion_interval_ns:
            raise ValueError("a motion made up as it goes has no conversions")
        self.graduation, self.waves = graduation or GraduationError.none(), waves or SquareWaves()
        self.strobes = LiveStrobes(sample_rate_hz, samples_per_word, seed)
        self.sample = 0
        """The first sample of the next piece."""
        self._source = EdgeSource(motion, self.graduation, self.waves, zero_mark or ZeroMark(), seed)
        self._planned_s = 0.0
        self._end_s = 0.0
        self._edges = self._source.chunks(self._segments())
        first = (
            np.zeros(1, np.int64),
            np.array([self._source.start_count]),
            np.array([self._source.start_z], np.uint8),
        )
        self._held = [first]
        self._faults: list[Fault] = []
        self._slipped = 0

    @property
    def start_count(self) -> int:
        """The count at sample 0; a counter that starts from 0 there reads counts less this one until it homes."""
        return self._source.start_count

    @property
    def time_s(self) -> float:
        """Time of the next piece."""
        return self.sample / self.sample_rate_hz

    @property
    def speed_rps(self) -> float:
        """Speed at the next piece."""
        return self.motion.speed_rps_at(self.time_s)

    def true_counts_at(self, sample):
        """True angle of the shaft in counts (float64, turns included) at samples."""
        return self.motion.true_counts_at(np.asarray(sample) / self.sample_rate_hz)

    def ideal_count_at(self, sample):
        """The count that the square waves stand at, delay included, jitter and faults not. Number or array."""
        time_s = np.asarray(sample) / self.sample_rate_hz - self.waves.delay_ns * 1e-9
        return self.waves.count_at_reading(self.graduation.reading_at(self.motion.true_counts_at(time_s)))

    def set_speed(self, speed_rps: float, acceleration_rps2: float | None = None) -> None:
        """From the next piece on."""
        self.motion.set_speed(self._planned_s, speed_rps, acceleration_rps2)

    def add_faults(self, faults: list[Fault]) -> None:
        """Faults at samples of pieces to come."""
        self._faults += faults

    def drop_next_zero_mark(self) -> None:
        """The zero mark that comes next does not come."""
        turn = self._turn_ahead()
        mark = self._source.zero_mark
        self._source.zero_mark = ZeroMark(
            mark.width_states, mark.centre_counts, mark.missing_turns | {turn}, mark.extra_counts
        )

    def add_zero_mark(self, distance_counts: int) -> None:
        """One more zero mark, `distance_counts` ahead in the direction of turning, in the gate state."""
        reading = float(self.graduation.reading_at(self.motion.true_counts_at(self._planned_s)))
        direction = -1 if self.speed_rps < 0 else 1
        count = int(reading + direction * distance_counts) // 4 * 4
        mark = self._source.zero_mark
        self._source.zero_mark = ZeroMark(
            mark.width_states, mark.centre_counts, mark.missing_turns, (*mark.extra_counts, count)
        )

    def next_piece(self, words: int) -> tuple[EncoderPiece, list[int]]:
        """The next `words` words, and the samples at which strobes rise in them."""
        start, end = self.sample, self.sample + words * self.samples_per_word
        self._end_s = end / self.sample_rate_hz + _JITTER_SIGMAS * self.waves.jitter_ns * 1e-9
        while self._planned_s < self._end_s:
            chunk = next(self._edges)
            if len(chunk.time_s):
                sample = np.ceil(chunk.time_s * self.sample_rate_hz).astype(np.int64)
                np.maximum(sample, self._held[-1][0][-1], out=sample)
                self._held.append((sample, chunk.count, chunk.z))
        rises, pulses = self.strobes.pulses_up_to(end)
        self._faults += pulses
        slipped = [PhaseShift(0, self._slipped)] if self._slipped else []
        overlay = LineOverlay([*slipped, *self._faults])
        left, piece = cut_piece(self._held, start, end, overlay)
        self._held = [left]
        self.sample = end
        self._forget_faults(end)
        return piece, rises

    def _segments(self):
        """The motion as far as edges are wanted; the edges of one segment have all come when the next is asked for."""
        while True:
            end_s = self._end_s
            yield from self.motion.between(self._planned_s, end_s)
            self._planned_s = end_s

    def _forget_faults(self, end: int) -> None:
        """A fault that is over has no effect any more; a shift that stays is added up."""
        kept = []
        for fault in self._faults:
            if fault.end is None and fault.start < end:
                self._slipped += fault.counts
            elif fault.end is None or fault.end > end:
                kept.append(fault)
        self._faults = kept

    def _turn_ahead(self) -> int:
        reading = float(self.graduation.reading_at(self.motion.true_counts_at(self._planned_s)))
        turn = int(np.floor((reading - 0.5) / COUNTS_PER_TURN))
        return turn if self.speed_rps < 0 else turn + 1
