"""How fast the twin's time goes beside the time of those who look at it."""

import time
from collections import deque

WINDOW_S = 2.0
"""The speed that is told is that of so many seconds past."""


class Pace:
    """Follows the instrument's time, `time_s` of every call; with `realtime` it is never ahead of the clock."""

    def __init__(self, realtime: bool):
        self._realtime = realtime
        self._history: deque[tuple[float, float]] = deque()

    def restart(self, time_s: float) -> None:
        """The instrument's time goes on from here, after it stood still."""
        self._history.clear()
        self._begun = (time.monotonic(), time_s)

    def keep(self, time_s: float) -> None:
        """The instrument has come so far; wait when that is too far."""
        now = time.monotonic()
        self._history.append((now, time_s))
        while self._history[0][0] < now - WINDOW_S and len(self._history) > 2:
            self._history.popleft()
        if not self._realtime:
            return
        begun, begun_s = self._begun
        ahead_s = (time_s - begun_s) - (now - begun)
        if ahead_s > 0:
            time.sleep(ahead_s)
        elif ahead_s < -1.0:  # it is behind, and does not catch up
            self._begun = (now, time_s)

    @property
    def slowdown(self) -> float:
        """Seconds that pass for one of the instrument's, over `WINDOW_S`; nan when nothing is known yet."""
        if len(self._history) < 2:
            return float("nan")
        (first, first_s), (last, last_s) = self._history[0], self._history[-1]
        return (last - first) / (last_s - first_s) if last_s > first_s else float("nan")
