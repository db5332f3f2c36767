"""What the square waves of an interpolator look like: imperfections of A and B, and the zero pulse Z."""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import COUNTS_PER_TURN

AB_OF_COUNT = np.array([0b11, 0b10, 0b00, 0b01], dtype=np.uint8)
"""Lines `A + 2 B` at count 0, 1, 2, 3 (mod 4). Count 0 is the gate state (1,1); forward is (A,B) = 11, 01, 00, 10."""

AB_OF_LOW_BYTE = np.tile(AB_OF_COUNT, 64)
"""The same by the low byte of a count, which is quicker to get than its remainder."""


@dataclass(frozen=True)
class SquareWaves:
    """Imperfections of A and B; all of them are zero for the ideal encoder.

    - `a_duty`, `b_duty`: part of a period (4 counts) in which the line is high, its middle staying in place.
    - `phase_error_deg`: B behind its place, in degrees of a period.
    - `jitter_ns`: standard deviation of each edge's time; edges never change their order.
    - `shortest_edge_spacing_ns`: no two edges of A and B come closer than this; the later one is delayed.
    - `conversion_interval_ns`: 0 for comparators that follow the angle at once; otherwise the angle is converted only
      this often, and the edges between two conversions come in a bunch, at the shortest edge spacing. Duty and phase
      error are then without meaning.
    - `delay_ns`: constant delay of A, B and Z.
    - `hysteresis_counts`: in reverse, A, B and Z follow only when the reading has fallen back by so much.
    """

    a_duty: float = 0.5
    b_duty: float = 0.5
    phase_error_deg: float = 0.0
    jitter_ns: float = 0.0
    shortest_edge_spacing_ns: float = 0.0
    conversion_interval_ns: float = 0.0
    delay_ns: float = 0.0
    hysteresis_counts: float = 0.0

    def __post_init__(self):
        if np.any(np.diff(np.append(np.arange(4) + self.edge_shift_counts, 4 + self.edge_shift_counts[0])) <= 0):
            raise ValueError("this duty and phase error make edges of A and B change places")
        if self.hysteresis_counts < 0:
            raise ValueError("hysteresis is 0 or more")
        if self.conversion_interval_ns and np.any(self.edge_shift_counts):
            raise ValueError("duty and phase error have no meaning with a conversion interval")

    @property
    def edge_shift_counts(self) -> np.ndarray:
        """How far the edge into count k (mod 4) lies from its ideal place k, in counts: four values."""
        a_half, b_half = 2 * (self.a_duty - 0.5), 2 * (self.b_duty - 0.5)
        b_late = self.phase_error_deg / 90
        # B rises into count 0, A falls into 1, B falls into 2, A rises into 3.
        return np.array([b_late - b_half, a_half, b_late + b_half, -a_half])

    def shown_reading(self, before: float, readings) -> np.ndarray:
        """The readings that A and B follow, hysteresis taken into account, when `before` was followed last.

        `readings`: float64[n] in the order of time. Forward nothing lags.
        """
        readings = np.asarray(readings, dtype=np.float64)
        if not self.hysteresis_counts:
            return readings
        shown = np.empty_like(readings)
        for index, reading in enumerate(readings):
            before = min(max(before, reading), reading + self.hysteresis_counts)
            shown[index] = before
        return shown

    def count_at_reading(self, reading):
        """The count that the ideal counter shows at a reading: floor, moved by the edge shifts. Array or number."""
        shift = self.edge_shift_counts
        count = np.floor(reading).astype(np.int64)
        count = count - (reading < count + shift[count & 3])
        return count + (reading >= count + 1 + shift[(count + 1) & 3])


@dataclass(frozen=True)
class ZeroMark:
    """Where Z is high: around reading 0 of every turn, unless told otherwise.

    `width_states`: width in counts (quadrature states), may be fractional. `centre_counts`: its middle; 0.5 is the
    middle of count 0, which lies in the gate state. `missing_turns`: turns whose mark does not come. `extra_counts`:
    readings (turns included) at which another mark of the same width stands, given as the count whose middle is the
    mark's.
    """

    width_states: float = 1.0
    centre_counts: float = 0.5
    missing_turns: frozenset[int] = field(default=frozenset())
    extra_counts: tuple[int, ...] = ()

    def intervals(self, low: float, high: float) -> np.ndarray:
        """The marks that touch the readings `low` to `high`, as rows (begin, end). Raises ValueError if two meet."""
        half = self.width_states / 2
        first = int(np.floor((low - half - self.centre_counts) / COUNTS_PER_TURN))
        last = int(np.ceil((high + half - self.centre_counts) / COUNTS_PER_TURN))
        turns = [turn for turn in range(first, last + 1) if turn not in self.missing_turns]
        extra = np.array(self.extra_counts, dtype=np.float64) + 0.5
        centres = np.sort(np.append(np.array(turns) * float(COUNTS_PER_TURN) + self.centre_counts, extra))
        centres = centres[(centres + half >= low) & (centres - half <= high)]
        marks = np.stack([centres - half, centres + half], axis=1)
        if np.any(marks[1:, 0] <= marks[:-1, 1]):
            raise ValueError("two zero marks overlap")
        return marks

    def level_at(self, reading) -> np.ndarray:
        """1 where Z is high at these readings, else 0 (uint8)."""
        reading = np.asarray(reading, dtype=np.float64)
        if reading.size == 0:
            return np.zeros(reading.shape, dtype=np.uint8)
        edges = self.intervals(float(reading.min()), float(reading.max())).reshape(-1)
        return (np.searchsorted(edges, reading, side="right") & 1).astype(np.uint8)
