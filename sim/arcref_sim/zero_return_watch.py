"""The watch over a zero-return test: golden model, true angle, zero marks and SPI frames, piece by piece."""

import numpy as np

from arcref.angle import ANGLE_BITS, COUNTS_PER_TURN, arcsec_to_counts, counts_to_arcsec, counts_to_deg
from arcref.flags import FAULT_FLAGS, Flag
from arcref.position_frame import FrameError, PositionFrame
from arcref_gateware.golden.core import STATUS_CHANGE, CoreModel
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.reference_encoder import FIRST_CORRECTED_WORD
from arcref_sim.core_log import Comparison, CoreLog
from arcref_sim.encoder import EncoderPiece, SyntheticEncoder
from arcref_sim.verilated_core import VerilatedCore
from arcref_sim.zero_return import WORD_CLOCK_HZ, ZeroReturnResult

ERROR_EVERY_CHANGES = 61
"""Every so many position changes the position is compared with the true angle."""

LARGEST_FIT_DIFFERENCE_COUNTS = 0.6
"""How far the corrected position may lie from the fitted curve: half a count of rounding and the table's own steps."""


class ZeroReturnWatch:
    """Holds what the core showed against what it must show, and fills in the result.

    `frame_words`: the sample words whose state the SPI frames must hold, in order.
    """

    def __init__(self, result: ZeroReturnResult, encoder: SyntheticEncoder, frame_words: np.ndarray):
        plan = result.plan
        self.result, self.encoder, self.frame_words = result, encoder, frame_words
        self.model = CoreModel(plan.rom, plan.samples_per_word)
        self.comparison = Comparison()
        self.frame_counts: list[np.ndarray] = []
        self.status = np.zeros(1, STATUS_CHANGE)[0]
        self.raw = self.true_count = 0
        # The second rest, third part of the motion, comes before the way back.
        self.turning_word = int(encoder.motion.start_times_s[2] * WORD_CLOCK_HZ)
        self.errors: list[tuple] = []
        self.changes = 0

    def piece(self, piece: EncoderPiece, log: CoreLog) -> None:
        """Take one piece of input and what the core showed meanwhile."""
        samples = self.result.plan.samples_per_word
        self.comparison.add(log, self.model.run(piece.changes))
        words = self.frame_words
        words = words[(words >= piece.changes.start // samples) & (words < piece.changes.end // samples)]
        self.frame_counts.append(piece.count_at((words + 1) * samples - 1))
        self.result.counts += int(np.abs(np.diff(piece.count)).sum())
        self.true_count = int(piece.count[-1])
        self._log(log)

    def finish(self, core: VerilatedCore) -> None:
        """Let the core show its last words, and judge the run."""
        samples, end = self.result.plan.samples_per_word, self.encoder.number_of_samples
        rest = SignalChanges(np.array([end]), np.array([self.model.last_state], np.uint8), end + samples)
        log = core.finish()
        self.comparison.add(log, self.model.run(rest))
        self._log(log)
        self._judge_frames(core.frames())
        self._judge(core)

    def _log(self, log: CoreLog) -> None:
        for status in log.status:
            if status["index_count"] != self.status["index_count"]:
                self._index(status)
            self.status = status
        if len(log.positions):
            self.raw = int(log.positions["raw_position"][-1])
        first = -self.changes % ERROR_EVERY_CHANGES
        self.changes += len(log.positions)
        self._errors(log.positions[first::ERROR_EVERY_CHANGES])

    def _index(self, status) -> None:
        direction = 1 if status["word"] < self.turning_word else -1
        turn = round(float(self.encoder.true_angle_at(self._last_sample(int(status["word"])))) / COUNTS_PER_TURN)
        self.result.closure.append((turn, direction, int(status["closure_error"])))

    def _last_sample(self, word):
        return (word + 1) * self.result.plan.samples_per_word - 1

    def _errors(self, positions: np.ndarray) -> None:
        home = self.model.home_word
        if home is None:
            return
        positions = positions[positions["word"] >= max(home, FIRST_CORRECTED_WORD)]
        if len(positions) == 0:
            return
        true = self.encoder.true_angle_at(self._last_sample(positions["word"]))
        raw, corrected = positions["raw_position"], positions["position"]
        angle_deg = counts_to_deg(np.mod(raw, COUNTS_PER_TURN))
        fitted = raw - arcsec_to_counts(self.result.plan.error_arcsec(angle_deg))
        largest = float(np.abs(corrected - fitted).max())
        self.result.fit_difference_counts = max(self.result.fit_difference_counts, largest)
        # A count stands for the whole count of angle that follows its edge, so its middle is what it says best.
        before, after = counts_to_arcsec(raw + 0.5 - true), counts_to_arcsec(corrected + 0.5 - true)
        self.errors.append((angle_deg, before, after))

    def _judge(self, core: VerilatedCore) -> None:
        result = self.result
        result.illegal_steps = int(self.status["illegal_steps"])
        result.flags = int(self.status["flags"])
        result.shortest_edge_spacing = core.output("shortest_edge_spacing")
        # The mark lies at count 0 of the encoder, so a homed core shows the encoder's own count.
        result.lost_counts = self.true_count - self.raw
        result.zero_drift_counts = result.closure[-1][2] if result.closure else None
        if self.errors:
            columns = [np.concatenate(column) for column in zip(*self.errors, strict=True)]
            result.angle_deg, result.before_arcsec, result.after_arcsec = columns
        difference = self.comparison.difference
        result.first_difference = str(difference) if difference else None
        marks = range(result.plan.revolutions + 1)
        expected = [(turn, 1) for turn in marks] + [(turn, -1) for turn in reversed(marks)]
        faults = Flag(result.flags) & FAULT_FLAGS & ~Flag.EDGE_SPACING_LIMIT
        fitted = bool(self.errors) and result.fit_difference_counts <= LARGEST_FIT_DIFFERENCE_COUNTS
        result.checks = {
            "every zero mark was seen": [mark[:2] for mark in result.closure] == expected,
            "every closure error is 0": all(error == 0 for _, _, error in result.closure),
            "zero drift is 0": result.zero_drift_counts == 0,
            "no count was lost": result.lost_counts == 0,
            "no illegal step": result.illegal_steps == 0,
            "no fault flag but edge spacing": not faults,
            "every SPI frame is right": result.frames_wrong == 0 and result.frames_read == len(self.frame_words),
            "core and golden model agree at every word": difference is None,
            f"corrected within {LARGEST_FIT_DIFFERENCE_COUNTS} counts of the fit": fitted,
        }

    def _judge_frames(self, frames: np.ndarray) -> None:
        counts = np.concatenate(self.frame_counts)
        self.result.frames_read = len(frames)
        self.result.frames_wrong = abs(len(frames) - len(counts))
        for record, word, count in zip(frames, self.frame_words, counts, strict=False):
            position, homed = self._expected(int(word), int(count))
            try:
                frame = PositionFrame.decode(record["data"].tobytes())
            except FrameError:
                self.result.frames_wrong += 1
                continue
            turns = ((position >> ANGLE_BITS) + 0x8000 & 0xFFFF) - 0x8000
            angle = position & (COUNTS_PER_TURN - 1)
            self.result.frames_wrong += (frame.turns, frame.angle, frame.homed) != (turns, angle, homed)

    def _expected(self, word: int, count: int) -> tuple[int, bool]:
        """Position and homed bit that a frame of `word` must hold, from the encoder's own count."""
        homed = self.model.home_word is not None and word >= self.model.home_word
        # Before homing the core counts from where it woke up.
        raw = count if homed else count - self.encoder.start_count
        active = homed and word >= FIRST_CORRECTED_WORD
        return (int(self.result.plan.rom.correct(raw)) if active else raw), homed
