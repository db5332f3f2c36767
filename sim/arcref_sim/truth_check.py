"""Holds what the core showed against the synthetic encoder's truth, piece by piece."""

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref.flags import Flag
from arcref_gateware.golden.core import POSITION_CHANGE, STATUS_CHANGE
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, Z_BIT
from arcref_sim.core_log import CoreLog
from arcref_sim.encoder import EncoderPiece, SyntheticEncoder
from arcref_sim.zero_return_result import ErrorFigures, ErrorOverTurn, IndexPass, Waveform

CELLS_PER_TURN = 720
READINGS_APART = 16
"""One in so many position changes is held against the true angle; against the ideal count, every one is."""

WAVEFORM_COUNTS = 7
GATE_LINES = 1 << A_BIT | 1 << B_BIT | 1 << Z_BIT


class TruthCheck:
    """Gathers lost counts, errors against the true angle, indices with their waveforms, and positions for SPI frames.

    Give it every piece with the log that came with it, in order; logs lag by the core's latency, which must be less
    than a piece. The encoder's graduation error must be the curve that the correction is to take away.
    """

    def __init__(self, encoder: SyntheticEncoder, samples_per_word: int, snapshot_words):
        """`snapshot_words`: the words, rising, whose positions are wanted for the SPI frames."""
        self._encoder, self._samples = encoder, samples_per_word
        self._snapshot_words = np.asarray(snapshot_words, dtype=np.int64)
        self._before: EncoderPiece | None = None
        self._position, self._status = np.zeros(1, POSITION_CHANGE), np.zeros(1, STATUS_CHANGE)
        self._snapshots: list[np.ndarray] = []
        self._before_sum = self._after_sum = 0.0
        self._readings = 0
        self._limits = np.array([[np.inf], [-np.inf], [np.inf], [-np.inf]]).repeat(CELLS_PER_TURN, axis=1)
        self.lost_counts = 0
        self.correction_deviation_counts = 0.0
        self.index_passes: list[IndexPass] = []
        self.waveforms: list[Waveform] = []
        self.flags = Flag(0)

    def add(self, piece: EncoderPiece | None, log: CoreLog) -> None:
        """Take the next piece (None at the end) and the log of the core's run over it."""
        pieces = [one for one in (self._before, piece) if one is not None]
        positions = np.concatenate((self._position, log.positions))
        status = np.concatenate((self._status, log.status))
        self._take_indices(pieces, positions, status)
        homed = status["word"][status["homed"] == 1]
        if len(homed):
            shown = log.positions[log.positions["word"] >= homed[0]]
            active = status["word"][(status["flags"] & Flag.CORRECTION_ACTIVE) != 0]
            self._take_positions(pieces, shown, int(active[0]) if len(active) else None)
        ready = np.searchsorted(self._snapshot_words, log.end_word)
        self._take_snapshots(positions, self._snapshot_words[:ready])
        self._snapshot_words = self._snapshot_words[ready:]
        self._position, self._status = positions[-1:].copy(), status[-1:].copy()
        if piece is not None:
            self._before = piece

    @property
    def snapshot_positions(self) -> np.ndarray:
        """Corrected positions at the snapshot words."""
        return np.concatenate([np.empty(0, np.int64), *self._snapshots])

    def errors(self) -> tuple[ErrorFigures, ErrorFigures]:
        """Errors before and after the correction, over all readings held against the truth."""
        number = max(self._readings, 1)
        largest = [
            np.abs(limits[np.isfinite(limits)]).max(initial=0.0) for limits in (self._limits[:2], self._limits[2:])
        ]
        return (
            ErrorFigures(float(np.sqrt(self._before_sum / number)), float(largest[0]), self._readings),
            ErrorFigures(float(np.sqrt(self._after_sum / number)), float(largest[1]), self._readings),
        )

    def error_over_turn(self) -> ErrorOverTurn:
        """The limits of both errors in each cell of the turn; cells never visited hold NaN."""
        angle_deg = (np.arange(CELLS_PER_TURN) + 0.5) * (360 / CELLS_PER_TURN)
        return ErrorOverTurn(angle_deg, *np.where(np.isfinite(self._limits), self._limits, np.nan))

    def _ideal_counts(self, pieces, sample: np.ndarray) -> np.ndarray:
        counts = pieces[-1].count_at(sample)
        if len(pieces) == 2:
            earlier = sample < pieces[1].changes.start
            counts[earlier] = pieces[0].count_at(sample[earlier])
        return counts

    def _take_positions(self, pieces, shown: np.ndarray, corrected_from: int | None) -> None:
        if len(shown) == 0:
            return
        samples = self._samples
        sample = shown["word"] * samples + samples - 1
        lost = np.abs(shown["raw_position"] - self._ideal_counts(pieces, sample))
        self.lost_counts = max(self.lost_counts, int(lost.max()))
        if corrected_from is None:
            return
        chosen = np.flatnonzero(shown["word"] >= corrected_from)[::READINGS_APART]
        some, sample = shown[chosen], sample[chosen]
        if len(some) == 0:
            return
        graduation = self._encoder.graduation
        curve = some["raw_position"] - graduation.true_at_reading(some["raw_position"])
        deviation = np.abs(some["position"] - some["raw_position"] + curve).max()
        self.correction_deviation_counts = max(self.correction_deviation_counts, float(deviation))
        # A count stands for its middle. The truth is taken at the last sample of the word, which the position follows.
        true = self._encoder.true_angle_at(sample)
        before = (some["raw_position"] + 0.5 - true) * ARCSEC_PER_COUNT
        after = (some["position"] + 0.5 - true) * ARCSEC_PER_COUNT
        self._readings += len(some)
        self._before_sum += float(before @ before)
        self._after_sum += float(after @ after)
        self._widen_limits(true, before, after)

    def _widen_limits(self, true, before, after) -> None:
        cell = np.floor(true * (CELLS_PER_TURN / COUNTS_PER_TURN)).astype(np.int64) % CELLS_PER_TURN
        runs = np.flatnonzero(np.diff(cell, prepend=-1))
        at = cell[runs]
        for limit, extreme, values in zip(
            self._limits, (np.minimum, np.maximum) * 2, (before, before, after, after), strict=True
        ):
            extreme.at(limit, at, extreme.reduceat(values, runs))

    def _take_indices(self, pieces, positions: np.ndarray, status: np.ndarray) -> None:
        self.flags |= Flag(int(np.bitwise_or.reduce(status["flags"])))
        for place in np.flatnonzero(np.diff(status["index_count"])):
            earlier, now = status[place], status[place + 1]
            word = int(now["word"])
            raw = int(positions["raw_position"][np.searchsorted(positions["word"], word, side="right") - 1])
            turn = (raw + COUNTS_PER_TURN // 2) // COUNTS_PER_TURN
            direction = -1 if now["flags"] & Flag.LAST_DIRECTION_REVERSE else 1
            homes = bool(now["homed"]) and not earlier["homed"]
            time_s = word * self._samples / self._encoder.sample_rate_hz
            self.index_passes.append(IndexPass(time_s, direction, turn, int(now["closure_error"]), homes))
            if homes or (direction < 0 and turn == 0):
                self._keep_waveform(pieces, word, direction)

    def _keep_waveform(self, pieces, word: int, direction: int) -> None:
        sample = word * self._samples
        piece = next(one for one in reversed(pieces) if one.changes.start <= sample)
        time, state = piece.changes.time, piece.changes.state
        in_gate = np.flatnonzero(
            ((state & GATE_LINES) == GATE_LINES) & (time >= sample) & (time < sample + self._samples)
        )
        if len(in_gate) == 0:
            return
        first, last = max(in_gate[0] - WAVEFORM_COUNTS, 0), min(in_gate[0] + WAVEFORM_COUNTS + 2, len(time) - 1)
        index = time[in_gate[0]]
        part = slice(first, last)
        self.waveforms.append(Waveform(direction, time[part] - index, state[part].copy(), int(time[last] - index)))

    def _take_snapshots(self, positions: np.ndarray, words: np.ndarray) -> None:
        place = np.searchsorted(positions["word"], words, side="right") - 1
        self._snapshots.append(positions["position"][place])
