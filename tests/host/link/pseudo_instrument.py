"""An instrument on a pseudo-terminal that answers as the golden model of the link does, for tests of the host."""

import os
import select
import threading
import tty

from arcref.link.capture_record import CaptureRecord
from arcref.link.packet import Kind, Packet
from arcref.link.registers import MAGIC, PROTOCOL_VERSION
from arcref_gateware.golden.link import LinkModel


class PseudoInstrument:
    """`values` are what its live registers read; `corrupt` may change the bytes either way. Use it with `with`."""

    def __init__(self, values: dict[str, int] | None = None, *, identity: list[int] | None = None, corrupt=None):
        self.values = {
            "magic": MAGIC,
            "protocol": PROTOCOL_VERSION,
            "gateware": 0x0100,
            "samples_per_word": 4,
            "word_clock_hz": 200_000_000,
            "capture_depth": 256,
        } | (values or {})
        self.written: list[tuple[str, int]] = []
        self.windows: dict[str, dict[int, int]] = {"identity": dict(enumerate(identity or [0] * 512))}
        self.model = LinkModel(self._read, self._on_write, self._on_window, self._read_window)
        self.on_write = lambda name, value: None
        self._corrupt = corrupt or (lambda data: data)
        self._number = 0
        self._sending = threading.Lock()

    def __enter__(self):
        self._near, far = os.openpty()
        tty.setraw(self._near)
        tty.setraw(far)
        self.port = os.ttyname(far)
        self._ends = [self._near, far]
        self._pulled = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *exception):
        self.pull_cable()

    def pull_cable(self) -> None:
        """The port goes away under whoever has it open."""
        # A test's thread may pull while the test ends: whoever takes the ends closes them.
        ends, self._ends = self._ends, []
        self._pulled.set()
        if threading.current_thread() is not self._thread:
            self._thread.join()  # a terminal stays as long as someone reads it
        for end in ends:
            os.close(end)

    def send_capture(self, record: CaptureRecord) -> None:
        """Stream one record."""
        self.send(Packet(Kind.CAPTURE, self._next_number(), record.encode()).encode())

    def send_overrun(self, lost: int) -> None:
        """Stream the record that captures were lost."""
        self.send(Packet(Kind.OVERRUN, self._next_number(), lost.to_bytes(4, "little")).encode())

    def skip_number(self) -> None:
        """As if a packet of the stream had been lost on the wire."""
        self._next_number()

    def send(self, data: bytes) -> None:
        """Bytes to the host."""
        data = self._corrupt(data)
        with self._sending:
            while data:
                data = data[os.write(self._near, data) :]

    def _next_number(self) -> int:
        number, self._number = self._number, (self._number + 1) % 256
        return number

    def _serve(self) -> None:
        while not self._pulled.is_set():
            if not select.select([self._near], [], [], 0.02)[0]:
                continue
            try:
                answer = self.model.feed(self._corrupt(os.read(self._near, 4096)))
                if answer:
                    self.send(answer)
            except (OSError, TypeError):  # the cable was pulled
                return

    def _read(self, register) -> int:
        return self.values.get(register.name, register.reset)

    def _on_write(self, name: str, value: int) -> None:
        self.written.append((name, value))
        self.on_write(name, value)

    def _on_window(self, name: str, place: int, word: int) -> None:
        self.windows.setdefault(name, {})[place] = word

    def _read_window(self, name: str, place: int) -> int:
        return self.windows[name][place]
