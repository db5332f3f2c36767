"""Which zero marks went by, told from readings that come slower than the marks may."""

from dataclasses import replace

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.instrument.counting_state import CountingState
from arcref.zero_return.index_pass import IndexPass

INDEX_COUNT_VALUES = 1 << 16
"""The instrument counts its indices modulo this."""


class ZeroMarkPasses:
    """Joins the marks that the raw position passed with the indices that the instrument counted.

    `start` is the reading before the first; with `homes` the next index is the one that homes. Times are since
    `start`. `passes`: what came; a mark that was passed and not counted is not in it.
    `further`: indices beyond them, as the shaft went to and fro over a mark between two readings.
    """

    def __init__(self, start: CountingState, *, homes: bool):
        self.passes: list[IndexPass] = []
        self.further = 0
        self._start_s = start.time_s
        self._before = start
        self._homes = homes
        self._expected: list[IndexPass] = []

    @property
    def waits_for_home(self) -> bool:
        """True until the index came that homes."""
        return self._homes

    def take(self, now: CountingState) -> None:
        """Take the next reading."""
        before, self._before = self._before, now
        counted = (now.index_count - before.index_count) % INDEX_COUNT_VALUES
        if self._homes:
            if counted == 0:
                return
            # Before it the position counted from another zero: the way since then begins at 0.
            before = replace(before, raw_position=0, time_s=(before.time_s + now.time_s) / 2)
            backwards = now.raw_position < 0 or (now.raw_position == 0 and now.flags & Flag.LAST_DIRECTION_REVERSE)
            self.passes.append(IndexPass(before.time_s - self._start_s, -1 if backwards else 1, 0, 0, True))
            self._homes = False
            counted -= 1
        # A mark passed by an earlier reading is counted by this one, because its count was read after that.
        overdue = len(self._expected)
        self._expected += self._marks_between(before, now)
        came, self._expected = self._expected[:counted], self._expected[counted:]
        if came and counted == len(came):
            came[-1] = replace(came[-1], closure_error_counts=now.closure_error)
        self.passes += came
        self.further += counted - len(came)
        self._expected = self._expected[max(overdue - len(came), 0) :]  # the overdue ones did not come

    def finished(self, largest_closure_error: int) -> tuple[IndexPass, ...]:
        """The passes. Where the largest closure error of all is 0, so is that of every mark not read alone."""
        if largest_closure_error:
            return tuple(self.passes)
        return tuple(
            replace(mark, closure_error_counts=0) if mark.closure_error_counts is None else mark for mark in self.passes
        )

    def _marks_between(self, before: CountingState, now: CountingState) -> list[IndexPass]:
        """The marks on the way, in order. The one that is stood on was passed on arriving."""
        start, end = before.raw_position, now.raw_position
        if end >= start:
            turns, direction = range(start // COUNTS_PER_TURN + 1, end // COUNTS_PER_TURN + 1), 1
        else:
            turns, direction = range(-(-start // COUNTS_PER_TURN) - 1, -(-end // COUNTS_PER_TURN) - 1, -1), -1
        per_count_s = (now.time_s - before.time_s) / (end - start) if end != start else 0.0
        since_start_s = before.time_s - self._start_s
        return [
            IndexPass(since_start_s + (turn * COUNTS_PER_TURN - start) * per_count_s, direction, turn, None, False)
            for turn in turns
        ]
