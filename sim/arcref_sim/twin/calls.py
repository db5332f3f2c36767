"""Calls into the twin's thread, carried out between two pieces of its run."""

import os
from collections import deque
from collections.abc import Callable
from concurrent.futures import Future


class TwinStopped(RuntimeError):
    """The twin has ended, and why."""


class Calls:
    """A queue of calls. `woken` is a file descriptor that can be read while one waits, for those who sleep on it."""

    def __init__(self):
        self._waiting: deque[tuple[Callable, Future]] = deque()
        self.woken, self._wake = os.pipe()

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def put(self, function: Callable) -> Future:
        """Ask for a call; the future brings what it returns or raises."""
        future: Future = Future()
        self._waiting.append((function, future))
        self.rouse()
        return future

    def rouse(self) -> None:
        """Wake whoever sleeps."""
        os.write(self._wake, b"\0")

    def carry_out(self) -> bool:
        """Carry out what waits; True when there was something."""
        carried = False
        while self._waiting:
            function, future = self._waiting.popleft()
            os.read(self.woken, 1)
            carried = True
            try:
                future.set_result(function())
            except Exception as error:
                future.set_exception(error)
        return carried

    def refuse(self) -> None:
        """Tell all who wait that the twin has ended."""
        while self._waiting:
            self._waiting.popleft()[1].set_exception(TwinStopped("the twin has ended"))

    def close(self) -> None:
        """Close the descriptors."""
        os.close(self.woken)
        os.close(self._wake)
