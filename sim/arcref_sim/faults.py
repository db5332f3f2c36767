"""What can go wrong between the encoder and the core, as changes of the sampled lines.

A fault is placed at samples; `SyntheticEncoder.samples_at_count` tells when a count is passed. Faults change what the
lines show, never the truth. A zero mark that is missing or comes twice is a matter of `ZeroMark`.
"""

from dataclasses import dataclass

import numpy as np

from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, STROBE_BIT

A_LINE = 1 << A_BIT
B_LINE = 1 << B_BIT
BOTH_LINES = A_LINE | B_LINE
STROBE_LINE = 1 << STROBE_BIT


@dataclass(frozen=True)
class PhaseShift:
    """A and B show the state `counts` further on from sample `start` up to, not including, `end`; None is for ever."""

    start: int
    counts: int
    end: int | None = None


@dataclass(frozen=True)
class LineFlip:
    """From `start` up to, not including, `end` (samples) the lines in `lines` (bits of a state) are inverted."""

    start: int
    end: int
    lines: int


@dataclass(frozen=True)
class LineHold:
    """From `start` up to, not including, `end` (samples) the lines in `lines` (bits of a state) stay at `level`."""

    start: int
    end: int
    lines: int
    level: int


Fault = PhaseShift | LineFlip | LineHold


def slip(sample: int, counts: int) -> list[Fault]:
    """The interpolator slips: from `sample` on, A and B run `counts` ahead of the angle while Z stays with the angle.

    A slip of whole periods (4 counts) leaves no trace on the lines; an odd slip of one shows as one step more or
    less; two as a double transition.
    """
    return [PhaseShift(sample, counts)]


def extra_pulses(sample: int, samples_per_edge: int, periods: int = 1) -> list[Fault]:
    """A and B make `periods` whole periods too many, forward, one edge each `samples_per_edge`: 4 counts a period."""
    return [PhaseShift(sample + number * samples_per_edge, 1) for number in range(4 * periods)]


def dropped_pulses(start: int, end: int, line: int = A_LINE) -> list[Fault]:
    """`line` stays low from `start` to `end`: with the other line moving on, each dropped pulse costs 4 counts."""
    return [LineHold(start, end, line, 0)]


def double_transition(sample: int, duration: int | None = None) -> list[Fault]:
    """A and B change in one sample: for good (the state is two counts off from there on) or there and back."""
    if duration is None:
        return [PhaseShift(sample, 2)]
    return [LineFlip(sample, sample + duration, BOTH_LINES)]


def glitch(sample: int, duration: int = 1, line: int = A_LINE) -> list[Fault]:
    """`line` is wrong for `duration` samples: a step there and back."""
    return [LineFlip(sample, sample + duration, line)]


def noise_glitches(start: int, end: int, number: int, *, line: int = A_LINE, seed: int = 0) -> list[Fault]:
    """`number` one-sample glitches of `line` at random samples from `start` up to `end`, never two at one place."""
    random = np.random.default_rng(seed)
    places = np.sort(random.choice(end - start, size=number, replace=False)) + start
    return [LineFlip(int(place), int(place) + 1, line) for place in places]


def strobe_pulses(samples, duration: int = 1) -> list[Fault]:
    """Strobe pulses of `duration` samples that rise at each of `samples`. No fault, but made like one."""
    return [LineHold(int(sample), int(sample) + duration, STROBE_LINE, STROBE_LINE) for sample in samples]


class LineOverlay:
    """Faults and strobes put over the clean lines of a stream, piece after piece."""

    def __init__(self, faults):
        self._shifts = [fault for fault in faults if isinstance(fault, PhaseShift)]
        spans = [fault for fault in faults if not isinstance(fault, PhaseShift)]
        spans.sort(key=lambda fault: fault.start)
        self._spans = spans
        self._begins = np.array([fault.start for fault in spans], dtype=np.int64)
        # Latest end among this span and all before it: lets a piece find the spans that reach into it.
        self._reach = np.maximum.accumulate(np.array([fault.end for fault in spans], dtype=np.int64))
        borders = [fault.start for fault in faults] + [fault.end for fault in faults if fault.end is not None]
        self._borders = np.unique(np.array(borders, dtype=np.int64))

    def borders(self, start: int, end: int) -> np.ndarray:
        """Samples inside `start` < sample < `end` at which some fault begins or ends."""
        first, last = np.searchsorted(self._borders, [start + 1, end])
        return self._borders[first:last]

    def shift(self, start: int, end: int, sample: np.ndarray) -> np.ndarray | int:
        """How many counts A and B run ahead at each of `sample`, which lie from `start` up to `end`."""
        total = 0
        for fault in self._shifts:
            if fault.start < end and (fault.end is None or fault.end > start):
                active = sample >= fault.start
                if fault.end is not None:
                    active &= sample < fault.end
                total = total + fault.counts * active
        return total

    def apply(self, start: int, end: int, sample: np.ndarray, state: np.ndarray) -> None:
        """Changes `state` (uint8) in place where a line is flipped or held."""
        first = int(np.searchsorted(self._reach, start, side="right"))
        last = int(np.searchsorted(self._begins, end))
        for fault in self._spans[first:last]:
            low, high = np.searchsorted(sample, [fault.start, fault.end])
            if isinstance(fault, LineFlip):
                state[low:high] ^= fault.lines
            else:
                state[low:high] = (state[low:high] & ~np.uint8(fault.lines)) | (fault.level & fault.lines)
