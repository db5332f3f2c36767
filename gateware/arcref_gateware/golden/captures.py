"""What the capture FIFO must keep and lose: a queue that tells how many were lost."""

from collections import deque
from dataclasses import dataclass, field


@dataclass
class CaptureFifoModel:
    """The FIFO of `depth` captures, clock by clock.

    One that was full keeps captures again `reopen_clocks` clocks after the first one was taken; one that has a number
    of lost captures waiting keeps none behind another loss until that is told, and then from the second clock on.
    """

    depth: int
    reopen_clocks: int
    lost: int = 0
    captures: int = 0
    queue: deque = field(default_factory=deque)
    """(Captures lost up to then when it is the first one kept after a loss, else None; the capture)."""
    _closed: bool = False
    _room: int = 0  # clocks since the first one was taken from a full FIFO
    _losing: bool = False
    _told: bool = False

    def clock(self, capture=None, *, takes: bool = False, tells: bool = False) -> None:
        """One clock: `capture` comes unless it is None, the oldest is taken, the number of its losses was told."""
        came = capture is not None
        keeps = came and not self._closed
        self.captures += came
        if keeps:
            self.queue.append((self.lost if self._losing else None, capture))
        elif came:
            self.lost += 1
        waits = self._told and (self._losing or came)
        if tells:
            self._told = False
        elif keeps and self._losing:
            self._told = True
        if came:
            self._losing = not keeps
        if takes:
            self.queue.popleft()
        if not self._closed:
            self._closed, self._room = keeps and len(self.queue) == self.depth, 0
        elif self._room >= self.reopen_clocks - 1 and not waits:
            self._closed = False
        elif self._room or takes:
            self._room += 1
