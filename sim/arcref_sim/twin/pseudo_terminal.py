"""A serial port for other programs: a pseudo-terminal that never blocks this side."""

import os
import select
import time
import tty
from pathlib import Path

from arcref.input_error import InputError

READER_PATIENCE_S = 5.0
"""How long bytes wait for a program that has stopped reading before they are dropped, as an adapter's buffer does."""


class PseudoTerminal:
    """`port` is the name to open. `link`, a path, is made a symbolic link to it for as long as this is open.

    Raises `InputError` when the link cannot be made, or when something else stands there.
    """

    def __init__(self, link: Path | None = None):
        self._near, self._far = os.openpty()
        tty.setraw(self._near)
        tty.setraw(self._far)
        os.set_blocking(self._near, False)
        self.port = os.ttyname(self._far)
        self.dropped_bytes = 0
        self._nobody_reads = False
        self._link = None
        if link:
            try:
                self._make_link(Path(link))
            except InputError:
                self.close()
                raise

    def read(self) -> bytes:
        """What has come, b"" for nothing."""
        try:
            return os.read(self._near, 4096)
        except BlockingIOError:
            return b""

    def wait(self, timeout_s: float, *others: int) -> None:
        """Until bytes come here or at the other file descriptors, or the time is over."""
        select.select([self._near, *others], [], [], timeout_s)

    def write(self, data: bytes) -> None:
        """Sends bytes. When the other side does not read for `READER_PATIENCE_S`, they are dropped and counted, and so
        is everything until it reads again.
        """
        deadline = None
        while data:
            try:
                data = data[os.write(self._near, data) :]
                self._nobody_reads, deadline = False, None
                continue
            except BlockingIOError:
                pass
            now = time.monotonic()
            deadline = deadline or now + READER_PATIENCE_S
            if self._nobody_reads or now >= deadline:
                self._nobody_reads = True
                self.dropped_bytes += len(data)
                return
            select.select([], [self._near], [], 0.05)

    def close(self) -> None:
        """Take the port away."""
        if self._link and self._link.is_symlink() and os.readlink(self._link) == self.port:
            self._link.unlink()
        for descriptor in (self._near, self._far):
            os.close(descriptor)

    def _make_link(self, link: Path) -> None:
        try:
            link.parent.mkdir(parents=True, exist_ok=True)
            if link.is_symlink():
                link.unlink()  # of a twin that was killed
            link.symlink_to(self.port)
        except FileExistsError:
            raise InputError(f"{link}: cannot be made a link to the port, another file stands there") from None
        except OSError as error:
            raise InputError(f"{link}: cannot be made a link to the port ({error.strerror})") from error
        self._link = link
