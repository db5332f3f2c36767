"""Golden model of the whole core: what it shows after every word, as lists of changes."""

from dataclasses import dataclass

import numpy as np

from arcref.correction_rom import CorrectionRom
from arcref.flags import FAULT_FLAGS, Flag
from arcref_gateware.golden.closure import ClosureModel, crossings
from arcref_gateware.golden.signal_changes import STROBE_BIT, Z_BIT, SignalChanges
from arcref_gateware.golden.steps import EdgeSpacingModel, steps_of
from arcref_gateware.golden.strobes import StrobeModel
from arcref_gateware.latency import FIRST_CORRECTED_WORD, ROM_VERDICT_WORD
from arcref_gateware.quadrature import DEFAULT_GATE_STATE

POSITION_CHANGE = np.dtype([("word", "i8"), ("raw_position", "i8"), ("position", "i8")])
"""From `word` on the core shows these positions."""

STATUS_CHANGE = np.dtype(
    [
        ("word", "i8"),
        ("homed", "u1"),
        ("illegal_steps", "u2"),
        ("closure_error", "i4"),
        ("index_count", "u2"),
        ("flags", "u1"),
    ]
)
"""From `word` on the core shows this state."""

CAPTURE = np.dtype([("word", "i8"), ("capture_position", "i8"), ("capture_raw", "i8"), ("capture_time", "i8")])
"""A capture, shown with the other outputs of `word`, which holds its due sample."""


@dataclass(frozen=True)
class CoreOutput:
    """What the core shows during one piece of input: structured arrays of the types above, in order of words.

    A list names a word only when something differs from the word before; after reset everything is 0.
    """

    positions: np.ndarray
    status: np.ndarray
    captures: np.ndarray


class CoreModel:
    """The core, run piece by piece. Every piece must be a whole number of words and start where the last one ended.

    `rom_good` is False for a core whose tables do not match their CRC.
    """

    def __init__(
        self,
        rom: CorrectionRom,
        samples_per_word: int,
        *,
        gate_state: tuple[int, int] = DEFAULT_GATE_STATE,
        strobe_delay: int = 0,
        rom_good: bool = True,
    ):
        self.rom, self.rom_good = rom, rom_good
        self.samples_per_word = samples_per_word
        self.gate_lines = gate_state[0] | gate_state[1] << 1 | 1 << Z_BIT
        self.spacing = EdgeSpacingModel(samples_per_word)
        self.strobes = StrobeModel(samples_per_word, strobe_delay)
        self.closure = ClosureModel()
        self.count = 0  # steps since reset, never set back
        self.zero = 0  # `count` at the first index
        self.home_word: int | None = None
        self.last_state: int | None = None
        self.due: list[int] = []
        self.shown = np.zeros(1, POSITION_CHANGE)[0]
        self.status = np.zeros(1, STATUS_CHANGE)[0]
        self.shown_status = self.status.copy()

    @property
    def shortest_edge_spacing(self) -> int:
        """Shortest spacing of two edges so far, in samples; 4095 for none."""
        return self.spacing.shortest

    @property
    def largest_closure_error(self) -> int:
        """Closure error that was largest in size, with its sign."""
        return self.closure.largest_closure_error

    def clear_flags(self, mask: int) -> None:
        """Clear fault flags as a command would, between two pieces. The change shows with the next piece's changes."""
        self.status["flags"] &= ~(mask & FAULT_FLAGS) & 0xFF
        if mask & Flag.EDGE_SPACING_LIMIT:
            self.spacing.shortest = EdgeSpacingModel(self.samples_per_word).shortest
        if mask & Flag.CLOSURE_ERROR:
            self.closure.largest_closure_error = 0

    def run(self, piece: SignalChanges) -> CoreOutput:
        """Take the next piece of input. Raises ValueError when it is not a whole number of words."""
        samples = self.samples_per_word
        if piece.start % samples or piece.end % samples:
            raise ValueError(f"samples {piece.start}..{piece.end} are not whole words of {samples}")
        time, state = self._with_entry(piece, FIRST_CORRECTED_WORD * samples)
        before = int(state[0]) if self.last_state is None else self.last_state
        gate_before = self.last_state is not None and self._in_gate(before)
        strobe_before = True if self.last_state is None else bool(before >> STROBE_BIT & 1)
        self.last_state = int(state[-1])
        word = time // samples

        step, illegal = steps_of(state, before)
        count = np.cumsum(step, dtype=np.int64)
        count += self.count
        in_gate = self._in_gate(state)
        entries = np.flatnonzero(in_gate & ~np.concatenate(([gate_before], in_gate[:-1])))
        entries = entries[np.unique(word[entries], return_index=True)[1]]
        if self.home_word is None and len(entries):
            self.home_word, self.zero = int(word[entries[0]]), int(count[entries[0]])

        ends = np.flatnonzero(np.diff(word, append=-1))
        end_word = word[ends]
        raw = self._raw(end_word, count[ends])
        corrected = self._corrected(end_word, raw)
        positions = self._changes(end_word, raw, corrected)

        index_words = word[entries]
        index_raw = self._raw(index_words, count[entries])
        closure_faults, index_faults, closure_errors = self._judge(end_word, raw, index_words, index_raw)

        strobe = (state >> STROBE_BIT & 1).astype(bool)
        rises = time[strobe & ~np.concatenate(([strobe_before], strobe[:-1]))]
        due, refused_words = self.strobes.run(rises.tolist())
        captures = self._captures(due, piece.end, time, count)

        limit_word = self.spacing.run(time, step, illegal)
        faults = {
            Flag.ILLEGAL_STEP: word[illegal],
            Flag.CLOSURE_ERROR: closure_faults,
            Flag.INDEX_FAULT: index_faults,
            Flag.CAPTURE_OVERRUN: refused_words,
            Flag.ROM_FAULT: [] if self.rom_good else [ROM_VERDICT_WORD],
            Flag.EDGE_SPACING_LIMIT: [] if limit_word is None else [limit_word],
        }
        words = (piece.start // samples, piece.end // samples)
        status = self._status(words, word, step, faults, word[illegal], index_words, closure_errors)
        self.count = int(count[-1])
        return CoreOutput(positions, status, captures)

    def _in_gate(self, state):
        return (state & 7) == self.gate_lines

    @staticmethod
    def _with_entry(piece: SignalChanges, at: int):
        """Times and states of the piece, with an entry at sample `at` when that lies inside it."""
        if not piece.start <= at < piece.end:
            return piece.time, piece.state
        place = np.searchsorted(piece.time, at, side="right")
        if piece.time[place - 1] == at:
            return piece.time, piece.state
        return np.insert(piece.time, place, at), np.insert(piece.state, place, piece.state[place - 1])

    def _raw(self, word, count):
        """Positions of counts seen in given words: from the home word on they count from the zero mark."""
        if self.home_word is None:
            return count
        return np.where(word >= self.home_word, count - self.zero, count) if self.zero else count

    def _is_active(self, word):
        if self.home_word is None or not self.rom_good:
            return np.zeros(np.shape(word), bool)
        return word >= max(self.home_word, FIRST_CORRECTED_WORD)

    def _corrected(self, word, raw):
        active = self._is_active(word)
        if active.all():
            return self.rom.correct(raw)
        return np.where(active, self.rom.correct(raw), raw) if active.any() else raw

    def _changes(self, word, raw, corrected) -> np.ndarray:
        changed = np.diff(raw, prepend=self.shown["raw_position"]) != 0
        changed |= np.diff(corrected, prepend=self.shown["position"]) != 0
        positions = np.empty(np.count_nonzero(changed), POSITION_CHANGE)
        positions["word"], positions["raw_position"] = word[changed], raw[changed]
        positions["position"] = corrected[changed]
        if len(positions):
            self.shown = positions[-1]
        return positions

    def _judge(self, end_word, raw, index_words, index_raw):
        """Faults and closure errors of the homed words of a piece: lists of words, and (word, error) pairs."""
        closure_faults, index_faults, closure_errors = [], [], []
        if self.home_word is None:
            return closure_faults, index_faults, closure_errors
        homed = end_word >= self.home_word
        end_word, raw = end_word[homed], raw[homed]
        if len(end_word) and end_word[0] == self.home_word:
            self.closure.start(int(raw[0]))
        at_index = dict(zip(index_words.tolist(), index_raw.tolist(), strict=True))
        at_index.pop(self.home_word, None)
        places = set(crossings(raw, self.closure.inside).tolist())
        places |= set(np.searchsorted(end_word, list(at_index)).tolist())
        for place in sorted(places):
            word = int(end_word[place])
            closure_fault, index_fault = self.closure.word(int(raw[place]), at_index.get(word))
            closure_faults += [word] * closure_fault
            index_faults += [word] * index_fault
            if word in at_index:
                closure_errors.append((word, self.closure.closure_error))
        return closure_faults, index_faults, closure_errors

    def _captures(self, due, end, time, count) -> np.ndarray:
        self.due += due
        ready = np.array([sample for sample in self.due if sample < end], dtype=np.int64)
        self.due = self.due[len(ready) :]
        captures = np.empty(len(ready), CAPTURE)
        captures["capture_time"] = ready
        captures["word"] = ready // self.samples_per_word
        place = np.searchsorted(time, ready, side="right") - 1
        captures["capture_raw"] = self._raw(captures["word"], count[place])
        captures["capture_position"] = self._corrected(captures["word"], captures["capture_raw"])
        return captures

    def _status(self, words, word, step, faults, illegal_words, index_words, closure_errors) -> np.ndarray:
        """Changes of the state between the words `words[0]` and `words[1]`, of which the last is not in them."""
        moving = np.flatnonzero(step)
        move_word, reverse = word[moving], step[moving] < 0
        last_reverse = bool(self.status["flags"] & Flag.LAST_DIRECTION_REVERSE)
        turned = move_word[np.diff(reverse, prepend=last_reverse)]
        levels = [words[0], FIRST_CORRECTED_WORD, *([] if self.home_word is None else [self.home_word])]
        places = [turned, illegal_words, index_words, levels, *faults.values()]
        at = np.unique(np.concatenate([np.asarray(place, dtype=np.int64) for place in places]))
        at = at[(at >= words[0]) & (at < words[1])]

        def seen(events):
            return np.searchsorted(np.sort(np.asarray(events, dtype=np.int64)), at, side="right")

        status = np.empty(len(at), STATUS_CHANGE)
        status["word"] = at
        status["homed"] = False if self.home_word is None else at >= self.home_word
        status["illegal_steps"] = np.minimum(int(self.status["illegal_steps"]) + seen(illegal_words), 0xFFFF)
        status["index_count"] = (int(self.status["index_count"]) + seen(index_words)) & 0xFFFF
        errors = [int(self.status["closure_error"]), *(error for _, error in closure_errors)]
        status["closure_error"] = np.array(errors)[seen([at_word for at_word, _ in closure_errors])]
        moves = np.searchsorted(move_word, at, side="right")
        direction = np.concatenate(([last_reverse], reverse))[moves]
        flags = np.full(len(at), int(self.status["flags"]) & int(FAULT_FLAGS))
        flags |= direction * int(Flag.LAST_DIRECTION_REVERSE)
        flags |= self._is_active(at) * int(Flag.CORRECTION_ACTIVE)
        for flag, events in faults.items():
            flags |= (seen([event for event in events if words[0] <= event < words[1]]) > 0) * int(flag)
        status["flags"] = flags

        before = np.concatenate((np.atleast_1d(self.shown_status), status))
        changed = np.zeros(len(at), bool)
        for name in STATUS_CHANGE.names[1:]:
            changed |= before[name][1:] != before[name][:-1]
        if len(at):
            self.status = status[-1].copy()
            self.shown_status = self.status.copy()
        return status[changed]
