"""What the capture FIFO must keep and lose: a queue that tells how many were lost."""

from collections import deque
from dataclasses import dataclass, field


@dataclass
class CaptureFifoModel:
    """The FIFO of `depth` captures at the level of one event after the other.

    `offer` is a capture, `take` the link taking the oldest. What `take` gives is (captures lost since `clear` when the
    capture says so, or None; the capture).
    """

    depth: int
    lost: int = 0
    captures: int = 0
    _queue: deque = field(default_factory=deque)
    _losing: bool = False
    _told: bool = False

    def offer(self, capture) -> bool:
        """True when it was kept."""
        self.captures += 1
        if len(self._queue) == self.depth or (self._losing and self._told):
            self.lost += 1
            self._losing = True
            return False
        self._queue.append((self.lost if self._losing else None, capture))
        self._told |= self._losing
        self._losing = False
        return True

    def take(self):
        """The oldest capture. Raises IndexError when there is none."""
        lost, capture = self._queue.popleft()
        if lost is not None:
            self._told = False
        return lost, capture

    def __len__(self):
        return len(self._queue)
