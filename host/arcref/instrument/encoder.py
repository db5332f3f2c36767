"""The client: an instrument as a context manager whose quantities are attributes.

from arcref import Encoder
with Encoder() as encoder:
    print(encoder.angle_deg)
"""

import contextlib
import queue
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.instrument.captures import UNKNOWN_LOSS, after, capture_array, lost_together
from arcref.instrument.hardware_zero_return import hardware_zero_return
from arcref.instrument.instrument import Instrument
from arcref.instrument.stream_state import StreamState
from arcref.instrument.trial import check_encoder, load_trial
from arcref.instrument_error import InstrumentError
from arcref.link.capture_record import CaptureRecord, Gap, Overrun
from arcref.link.link import LinkLost
from arcref.link.packet import DEFAULT_BAUD
from arcref.zero_return.result import ZeroReturnResult

RECONNECT_S = 30.0
"""How long a stream waits for a cable that was pulled, unless told otherwise."""

_LOST_PORT = object()


class Encoder(Instrument):
    """One instrument on a serial port, and what is done with it: captures, trial corrections, the zero-return test.

    `port`: its name; None takes the one that `ARCREF_PORT` names, or the only one plugged in. When the port went away,
    each request tries once whether it is back, and a stream waits for it, `reconnect_s` seconds at the most. Raises
    `InputError` when the port cannot be used, `InstrumentError` when the instrument does not answer as it should.
    """

    def __init__(self, port: str | None = None, *, baud: int = DEFAULT_BAUD, reconnect_s: float = RECONNECT_S):
        self.reconnect_s = reconnect_s
        self._records: queue.SimpleQueue = queue.SimpleQueue()
        self._streaming = False
        super().__init__(port, baud=baud, on_record=self._take_record)

    def stream(self, timeout_s: float | None = None) -> Iterator[tuple[int, CaptureRecord]]:
        """Captures as they come: pairs of how many were lost just before, and the record.

        -1 lost: nobody knows how many. The instrument's clock begins anew after 2^48 sample periods (98 h at 800 M
        samples/s); the times given here go on. Ends only by `close`, by leaving the loop, or by an error:
        `InstrumentError` when `timeout_s` pass without a capture, `LinkLost` when the port went away and did not come
        back in time, or came back with an instrument that had been switched off and so lost its zero and settings.
        """
        before = StreamState.of(self) if self.reconnect_s else None
        self.start_captures()
        lost = total = 0  # lost before the next record; since the FIFO was emptied
        time_samples = 0
        try:
            while True:
                record = self._next_record(timeout_s)
                if record is _LOST_PORT:
                    self._kept.reopen(self.reconnect_s)
                    if before:
                        before.check(StreamState.of(self), self.port)
                    self.start_captures()
                    lost, total = UNKNOWN_LOSS, 0
                elif isinstance(record, Overrun):
                    lost, total = lost_together(lost, (record.total - total) % 2**32), record.total
                elif isinstance(record, Gap):
                    lost = UNKNOWN_LOSS
                else:
                    time_samples = after(time_samples, record.time)
                    yield lost, replace(record, time=time_samples) if time_samples != record.time else record
                    lost = 0
        finally:
            self._stop_captures()

    def capture(self, n: int, timeout_s: float = 10.0) -> np.ndarray:
        """The next `n` captures, an array of `CAPTURE_DTYPE`. Raises `InstrumentError` when none comes in time."""
        if n < 1:
            raise InputError(f"{n} captures were asked for, at least 1 was expected")
        records = []
        stream = self.stream(timeout_s)
        try:
            for pair in stream:
                records.append(pair)
                if len(records) == n:
                    break
        except InstrumentError as error:
            kind = LinkLost if isinstance(error, LinkLost) else InstrumentError
            raise kind(f"capture of {n}: {len(records)} came, then: {error}") from error
        finally:
            stream.close()
        return capture_array(records, self.identity.sample_rate_hz)

    def load_trial(self, rom: CorrectionRom, progress=lambda part: None, *, any_encoder: bool = False) -> None:
        """Load `rom` into the running instrument. It is in force from the next index until power-off.

        Raises `InputError` when `rom` is of another encoder than the ROM in the instrument, unless `any_encoder`;
        `InstrumentError` when the instrument finds that its CRC does not hold.
        """
        if not any_encoder:
            check_encoder(rom, self.identity)
        self._identity = None
        try:
            load_trial(self.registers, rom, progress)
        finally:
            self._kept.recognise()

    def zero_return(self, **options) -> ZeroReturnResult:
        """The zero-return test, with the shaft turned by hand or motor, or by the on-board generator.

        Options and errors of `arcref.instrument.hardware_zero_return`; gives a `ZeroReturnResult`, and
        `result.passed` is the verdict.
        """
        return hardware_zero_return(self, **options)

    @property
    def captures_waiting(self) -> bool:
        """True while captures that came have not been taken by `stream`."""
        return not self._records.empty()

    def start_captures(self) -> None:
        """Empty what was left over, and let the instrument stream."""
        self._streaming = False
        self.registers.capture_enable = 0
        self.registers.capture_clear = 1
        while self.captures_waiting:
            self._records.get()
        self._streaming = True
        self.registers.capture_enable = 1

    def _stop_captures(self) -> None:
        self._streaming = False
        if not self._kept.lost:
            with contextlib.suppress(InstrumentError):  # the port is gone: there is nothing to stop
                self.registers.capture_enable = 0

    def _take_record(self, record) -> None:
        # A client that was killed may have left the instrument streaming; that must not fill the memory.
        if self._streaming:
            self._records.put(record)

    def _next_record(self, timeout_s: float | None):
        deadline = None if timeout_s is None else time.monotonic() + timeout_s
        while True:
            left = 0.2 if deadline is None else min(0.2, max(0.0, deadline - time.monotonic()))
            lost = self._kept.lost  # looked at first: what came before the port went away stands in the queue then
            try:
                return self._records.get(timeout=0.0 if lost else left)
            except queue.Empty:
                if lost:
                    return _LOST_PORT
                if deadline is not None and time.monotonic() >= deadline:
                    raise InstrumentError(
                        f"no capture came from {self.port} in {timeout_s:g} s; is there a strobe?"
                    ) from None
