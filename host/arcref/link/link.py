"""The link to an instrument: requests with their answers, and the records that it streams meanwhile."""

import itertools
import queue
import threading
import time
from collections.abc import Callable
from typing import Protocol

from arcref.instrument_error import InstrumentError
from arcref.link.capture_record import CaptureRecord, Gap, Overrun
from arcref.link.packet import MOST_WORDS, Kind, Packet, Status
from arcref.link.packet_stream import PacketStream

ANSWER_TIMEOUT_S = 0.25
"""How long one attempt waits for its answer. A request and its answer take less than 1 ms at 3 Mbaud."""

ATTEMPTS = 8
"""Times a request is sent before the link counts as dead. A packet of 64 bytes is lost in 6 % of the cases when one
byte in a thousand is, and then eight attempts fail once in 10^7 requests."""

STATUS_SENTENCES = {
    Status.UNKNOWN_ADDRESS: "no register stands there",
    Status.READ_ONLY: "it can only be read",
    Status.OUT_OF_RANGE: "the value is out of range",
    Status.NOT_NOW: "it cannot be written now",
}


class LinkLost(InstrumentError):
    """The port is gone: a cable was pulled, or the instrument was switched off."""


class RequestRefused(InstrumentError):
    """The instrument answered that a request did not take."""

    def __init__(self, what: str, status: Status):
        super().__init__(f"{what}: the instrument refused, {STATUS_SENTENCES[status]}")
        self.status = status


class Port(Protocol):
    """What a link needs of a serial port; `serial.Serial` has it. Reads return what came within the port's time-out."""

    @property
    def in_waiting(self) -> int:
        """Bytes that have come and were not read."""

    def read(self, size: int) -> bytes:
        """`size` bytes, or those that came within the time-out."""

    def write(self, data: bytes) -> int:
        """Send bytes."""

    def close(self) -> None:
        """Close the port."""


class Link:
    """Requests over one open port. A thread reads the port all the time, so that no record waits in a small buffer.

    `on_record` is called from that thread with each `CaptureRecord`, `Overrun` and `Gap` of the stream. `name` stands
    in messages. Close it when done.
    """

    def __init__(self, port: Port, name: str, on_record: Callable[[CaptureRecord | Overrun | Gap], None] | None = None):
        self.name = name
        self._port = port
        self._on_record = on_record or (lambda record: None)
        self._stream = PacketStream()
        self._numbers = itertools.cycle(range(256))
        self._answers: queue.SimpleQueue[Packet | None] = queue.SimpleQueue()
        self._next_record: int | None = None
        self._lost: Exception | None = None
        self._closing = False
        self._one_request = threading.Lock()
        self._reader = threading.Thread(target=self._read, name=f"arcref {name}", daemon=True)
        self._reader.start()

    @property
    def lost(self) -> bool:
        """True once the port is gone."""
        return self._lost is not None and not self._closing

    def read_words(self, address: int, count: int, what: str) -> list[int]:
        """Words from `address` on, all of one instant. `what` says in messages what was asked.

        Raises `InstrumentError` when no answer came, `LinkLost` when the port is gone.
        """
        payload = address.to_bytes(2, "little") + bytes([count])
        answer = self._ask(Packet(Kind.READ, next(self._numbers), payload), Kind.READ_ANSWER, what)
        words = answer.payload[3:]
        if len(words) != 2 * count:
            raise InstrumentError(f"{what}: {len(words) // 2} words came from {self.name}, {count} were asked for")
        return [int.from_bytes(words[i : i + 2], "little") for i in range(0, len(words), 2)]

    def write_words(self, address: int, words: list[int], what: str) -> None:
        """Write words from `address` on. Raises `RequestRefused` when it did not take, and as `read_words` does."""
        if not 1 <= len(words) <= MOST_WORDS:
            raise ValueError(f"{len(words)} words do not fit into one packet")
        payload = address.to_bytes(2, "little") + b"".join(word.to_bytes(2, "little") for word in words)
        self._ask(Packet(Kind.WRITE, next(self._numbers), payload), Kind.WRITE_ANSWER, what)

    def release(self) -> None:
        """Give the name of a port that is gone back to the system. The link stays `lost`."""
        self._port.close()

    def close(self) -> None:
        """Close the port and end the reading thread."""
        self._closing = True
        self._port.close()
        if self._reader is not threading.current_thread():
            self._reader.join(2)

    def _ask(self, request: Packet, kind: Kind, what: str) -> Packet:
        with self._one_request:
            wire = request.encode()
            for _ in range(ATTEMPTS):
                self._send(wire, what)
                answer = self._answer(request, kind, what)
                if answer is not None:
                    break
            else:
                broken = self._stream.broken
                came = f", but {broken} broken packets (is its baud rate right?)" if broken else ""
                raise InstrumentError(
                    f"{what}: no answer from {self.name} in {ATTEMPTS * ANSWER_TIMEOUT_S:g} s{came}; is it the right "
                    "port, and is the instrument configured and powered?"
                )
        status = Status(answer.payload[0])
        if status is not Status.DONE:
            raise RequestRefused(what, status)
        return answer

    def _send(self, wire: bytes, what: str) -> None:
        if self._lost is not None:
            raise LinkLost(f"{what}: {self.name} is gone ({self._lost})")
        try:
            # The zero in front ends whatever noise the instrument took for a packet's beginning.
            self._port.write(b"\0" + wire)
        except OSError as error:
            self._lost = error
            raise LinkLost(f"{what}: {self.name} is gone ({error})") from error

    def _answer(self, request: Packet, kind: Kind, what: str) -> Packet | None:
        """The answer to `request`, None when it did not come in time. Answers to earlier requests are passed over."""
        deadline = time.monotonic() + ANSWER_TIMEOUT_S
        while True:
            try:
                answer = self._answers.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                return None
            if answer is None:
                raise LinkLost(f"{what}: {self.name} is gone ({self._lost})")
            is_status = answer.payload[0] in list(Status)
            same = (
                answer.kind is kind and answer.number == request.number and answer.payload[1:3] == request.payload[:2]
            )
            if same and is_status:
                return answer

    def _read(self) -> None:
        while not self._closing:
            try:
                data = self._port.read(self._port.in_waiting or 1)  # not more: a read waits until all have come
            except (OSError, TypeError) as error:  # pyserial gives TypeError when another thread closes the port
                self._lost = error
                break
            for packet in self._stream.feed(data):
                self._dispatch(packet)
        self._answers.put(None)

    def _dispatch(self, packet: Packet) -> None:
        if packet.kind in (Kind.READ_ANSWER, Kind.WRITE_ANSWER):
            self._answers.put(packet)
            return
        if packet.kind not in (Kind.CAPTURE, Kind.OVERRUN):
            return  # a request: an echo of our own bytes
        if self._next_record is not None and packet.number != self._next_record:
            self._on_record(Gap())
        self._next_record = (packet.number + 1) % 256
        if packet.kind is Kind.CAPTURE:
            self._on_record(CaptureRecord.decode(packet.payload))
        else:
            self._on_record(Overrun(int.from_bytes(packet.payload, "little")))
