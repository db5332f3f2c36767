"""One leg of the zero-return test: whether the shaft comes nearer to its goal, and what to say when it does not."""

from dataclasses import dataclass

from arcref.angle import COUNTS_PER_TURN

PROGRESS_COUNTS = COUNTS_PER_TURN // 64
"""Way that counts as turning; a shaft that only trembles stays below it."""

AGAINST_COUNTS = COUNTS_PER_TURN // 8
"""Way in the wrong direction after which it is told."""

AGAINST_S = 2.0
"""A drive needs this long to turn round; before that, the wrong direction is not told."""

DIRECTIONS = {1: "forward", -1: "reverse"}


@dataclass(frozen=True)
class ZeroReturnProgress:
    """Where the test is: `leg` in words, `turns_done` of `turns` in it, `part` of the whole test, 0 to 1."""

    leg: str
    turns_done: float
    turns: int
    speed_rps: float
    part: float


class Leg:
    """From `raw_position` to `goal` (None: wherever the zero mark comes) in `direction`. Times are of one clock, in s.

    `awaited` says what the user and the test wait for; set it as the leg goes on.
    """

    def __init__(self, direction: int, raw_position: int, goal: int | None, timeout_s: float, now_s: float):
        self.direction, self.goal = direction, goal
        self.awaited = "the shaft was to turn"
        self._timeout_s = timeout_s
        self._start = self._furthest = direction * raw_position
        self._lowest_since = self._highest_since = direction * raw_position
        self._progress_s = now_s
        self._told = False

    def reached(self, raw_position: int) -> bool:
        """True at the goal or past it."""
        return self.goal is not None and self.direction * (raw_position - self.goal) >= 0

    def travelled(self, raw_position: int) -> float:
        """Turns from the start, positive in the leg's direction."""
        return (self.direction * raw_position - self._start) / COUNTS_PER_TURN

    def take(self, raw_position: int, now_s: float) -> str | None:
        """Take a reading. A line to tell the user, where there is one."""
        along = self.direction * raw_position
        self._furthest = max(self._furthest, along)
        self._lowest_since, self._highest_since = min(self._lowest_since, along), max(self._highest_since, along)
        if along - self._lowest_since >= PROGRESS_COUNTS:
            self._progress_s, self._lowest_since, self._highest_since = now_s, along, along
            self._told = False
        if self._is_against(along) and not self._told and now_s - self._progress_s >= AGAINST_S:
            self._told = True
            return f"The shaft turns {self._other}: turn it {DIRECTIONS[self.direction]}."
        return None

    def overdue(self, raw_position: int, now_s: float) -> str | None:
        """After the time-out without any way in the right direction: the sentence that says what was awaited."""
        if now_s - self._progress_s < self._timeout_s:
            return None
        along = self.direction * raw_position
        if self._is_against(along):
            turns = (self._furthest - along) / COUNTS_PER_TURN
            return (
                f"the shaft turned {turns:.2f} turns in the wrong direction, {self._other}, while {self.awaited}; "
                "where it did turn the right way, swap A and B (forward is A before B)"
            )
        moved = "stood still" if self._highest_since - self._lowest_since < PROGRESS_COUNTS else "came no further"
        return (
            f"the shaft {moved} for {self._timeout_s:g} s while {self.awaited}; "
            "turn it, look at A and B, or allow more with --timeout"
        )

    @property
    def _other(self) -> str:
        return DIRECTIONS[-self.direction]

    def _is_against(self, along: int) -> bool:
        return self._furthest - along >= AGAINST_COUNTS
