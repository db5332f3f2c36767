"""Holds what the core showed against the synthetic encoder's truth, piece by piece."""

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.zero_return.index_pass import IndexPass
from arcref.zero_return.truth_parts import ErrorFigures, ErrorOverTurn, Waveform
from arcref_gateware.golden.core import POSITION_CHANGE, STATUS_CHANGE
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, Z_BIT
from arcref_sim.core_log import CoreLog
from arcref_sim.encoder import EncoderPiece, SyntheticEncoder
from arcref_sim.lost_counts import LostCounts

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
        self._position, self._status = np.zeros(1, POSITION_CHANGE)[0], np.zeros(1, STATUS_CHANGE)
        self._lost = LostCounts(samples_per_word)
        self._snapshots: list[np.ndarray] = []
        self._before_sum = self._after_sum = 0.0
        self._readings = 0
        self._limits = np.array([[np.inf], [-np.inf], [np.inf], [-np.inf]]).repeat(CELLS_PER_TURN, axis=1)
        self.correction_deviation_counts = 0.0
        self.index_passes: list[IndexPass] = []
        self.waveforms: list[Waveform] = []
        self.flags = Flag(0)

    def add(self, piece: EncoderPiece | None, log: CoreLog) -> None:
        """Take the next piece (None at the end) and the log of the core's run over it."""
        status = np.concatenate((self._status, log.status))
        self._take_indices([one for one in (self._before, piece) if one is not None], log.positions, status)
        homed = status["word"][status["homed"] == 1]
        self._lost.add(piece, log, int(homed[0]) if len(homed) else None)
        corrected = status["word"][(status["flags"] & Flag.CORRECTION_ACTIVE) != 0]
        if len(corrected):
            first = np.searchsorted(log.positions["word"], corrected[0])
            self._take_positions(log.positions[first::READINGS_APART])
        ready = np.searchsorted(self._snapshot_words, log.end_word)
        self._snapshots.append(self._shown_at(log.positions, self._snapshot_words[:ready])["position"])
        self._snapshot_words = self._snapshot_words[ready:]
        self._position = log.positions[-1].copy() if len(log.positions) else self._position
        self._status = status[-1:].copy()
        if piece is not None:
            self._before = piece

    @property
    def lost_counts(self) -> int:
        """Largest distance of the raw position from the ideal count since homing."""
        return self._lost.largest

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

    def _take_positions(self, positions: np.ndarray) -> None:
        """Holds some corrected positions against the curve and the true angle."""
        if len(positions) == 0:
            return
        raw, corrected = positions["raw_position"], positions["position"]
        curve = raw - self._encoder.graduation.true_at_reading(raw)
        deviation = float(np.abs(corrected - raw + curve).max())
        self.correction_deviation_counts = max(self.correction_deviation_counts, deviation)
        # A count stands for its middle. The truth is taken at the last sample of the word, which the position follows.
        true = self._encoder.true_angle_at((positions["word"] + 1) * self._samples - 1)
        before, after = ((value + 0.5 - true) * ARCSEC_PER_COUNT for value in (raw, corrected))
        self._readings += len(positions)
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
            raw = int(self._shown_at(positions, np.array([word]))["raw_position"][0])
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

    def _shown_at(self, positions: np.ndarray, words: np.ndarray) -> np.ndarray:
        """The records of POSITION_CHANGE that hold at `words`."""
        place = np.searchsorted(positions["word"], words, side="right") - 1
        shown = positions[np.maximum(place, 0)] if len(positions) else np.empty(len(words), POSITION_CHANGE)
        shown[place < 0] = self._position
        return shown
