"""The twin: the whole instrument in simulation behind a pseudo-terminal."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.correction_rom import CorrectionRom
from arcref.link.packet import DEFAULT_BAUD
from arcref_gateware.connected_encoder import DEFAULT_WORD_CLOCK_HZ, ConnectedEncoder
from arcref_sim.core_log import SPI_FRAME
from arcref_sim.graduation import GraduationError
from arcref_sim.spi_plan import SpiPlan
from arcref_sim.square_waves import SquareWaves
from arcref_sim.twin.calls import Calls, TwinStopped
from arcref_sim.twin.live_encoder import LiveEncoder
from arcref_sim.twin.live_motion import LiveMotion
from arcref_sim.twin.pace import Pace
from arcref_sim.twin.pseudo_terminal import PseudoTerminal
from arcref_sim.twin.twin_core import SENT_AHEAD_BYTES, CompiledTwin, TwinCore
from arcref_sim.twin.twin_instrument import TwinInstrument
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER

APPROACH_COUNTS = 5002
"""How far before the zero mark the shaft starts: where A and B are low, as the lines are before the first sample."""

WORDS_PER_RUN = 1 << 13
"""Words between two looks at the port: 41 us of the instrument's time at 200 MHz."""

STROBES_KEPT = 1 << 18


@dataclass(frozen=True)
class TwinStatus:
    """`time_s`: the instrument's own time since power-up. `slowdown`: seconds that pass for one of these, over the
    last two. `bytes_from_host`, `bytes_to_host`; `dropped_bytes`: for a host that did not read.
    """

    time_s: float
    slowdown: float
    sleeping: bool
    speed_rps: float
    true_counts: float
    raw_position: int
    position: int
    homed: bool
    flags: int
    strobe_rate_hz: float
    strobes: int
    bytes_from_host: int
    bytes_to_host: int
    dropped_bytes: int


class Twin:
    """An instrument that runs from `with` to its end, in a thread of its own. `port` is its serial port.

    `rom`: the correction in it. `graduation`: the encoder's own error, none unless given. `speed_rps`: at which the
    shaft turns from the start, towards its zero mark from `APPROACH_COUNTS` away. `realtime`: never faster than real
    time. `has_test_generator`: build it with the on-board test generator.
    `sleep_after_s`: the instrument's time stands still when its port was silent so long, until a byte or a call comes.
    `change_bytes`: changes what the host sends, and what it is sent, as a bad cable would. `link`: see
    `PseudoTerminal`. `compiled`: the instrument with this ROM, when it was compiled before; it brings its own word
    size, clock and baud rate. Raises as `PseudoTerminal`, `ConnectedEncoder` and `CompiledTwin.of` do.
    """

    def __init__(
        self,
        rom: CorrectionRom,
        *,
        samples_per_word: int = 4,
        word_clock_hz: float = DEFAULT_WORD_CLOCK_HZ,
        baud: float = DEFAULT_BAUD,
        has_test_generator: bool = False,
        speed_rps: float = 0.0,
        graduation: GraduationError | None = None,
        waves: SquareWaves | None = None,
        seed: int = 0,
        realtime: bool = False,
        sleep_after_s: float | None = None,
        change_bytes: Callable[[bytes], bytes] = lambda data: data,
        link: Path | None = None,
        folder: Path = DEFAULT_BUILD_FOLDER,
        compiled: CompiledTwin | None = None,
    ):
        if compiled is None:
            kind = TwinInstrument if has_test_generator else ConnectedEncoder
            design = kind(rom, samples_per_word, word_clock_hz=word_clock_hz, baud=baud)
            compiled = CompiledTwin.of(design, folder)
        self.rom = rom
        self.core = TwinCore(compiled)
        samples_per_word, word_clock_hz = self.core.samples_per_word, compiled.word_clock_hz
        start = (APPROACH_COUNTS if speed_rps < 0 else -APPROACH_COUNTS) + 0.5
        motion = LiveMotion(float((graduation or GraduationError.none()).true_at_reading(start)), speed_rps)
        rate_hz = word_clock_hz * samples_per_word
        self.encoder = LiveEncoder(motion, rate_hz, samples_per_word, graduation=graduation, waves=waves, seed=seed)
        self.strobe_samples: deque[int] = deque(maxlen=STROBES_KEPT)
        """Samples at which the strobe pin rose."""
        self._compare: list[np.ndarray] = []
        self._frames: list[np.ndarray] = []
        self._sleep_after_s, self.change_bytes = sleep_after_s, change_bytes
        self._pace = Pace(realtime)
        self._calls = Calls()
        self._link = link
        self._thread = threading.Thread(target=self._live, name="twin", daemon=True)
        self._ending = False
        self._failure: BaseException | None = None
        self._sent = self._received = 0
        self._sleeping = False

    def __enter__(self) -> "Twin":
        self._terminal = PseudoTerminal(self._link)
        self.port = self._terminal.port
        self._thread.start()
        return self

    def __exit__(self, *exception) -> None:
        self._ending = True
        self._calls.rouse()
        self._thread.join()
        self._terminal.close()
        self._calls.close()
        if self._failure and exception[0] is None:
            raise TwinStopped(f"the twin has failed: {self._failure}") from self._failure

    @property
    def running(self) -> bool:
        """False once it has ended, or failed."""
        return self._thread.is_alive()

    def call(self, function: Callable, *arguments, **options):
        """Carry out `function` between two pieces, where the instrument stands still, and give what it returns or
        raises. Raises `TwinStopped` when the twin has ended.
        """
        future = self._calls.put(lambda: function(*arguments, **options))
        while True:
            try:
                return future.result(0.2)
            except TimeoutError:
                if not self.running and not future.done():
                    raise TwinStopped(f"the twin has ended{f': {self._failure}' if self._failure else ''}") from None

    def set_speed(self, speed_rps: float, acceleration_rps2: float | None = None) -> None:
        """Turn at another speed, at once or with an acceleration."""
        self.call(self.encoder.set_speed, speed_rps, acceleration_rps2)

    def set_strobe(self, rate_hz: float, *, is_random: bool = False) -> None:
        """Strobe the pin at a rate from now on; 0 stops it. Raises ValueError for one that is too high."""
        self.call(lambda: self.encoder.strobes.set_rate(self.encoder.sample, rate_hz, is_random=is_random))

    def burst(self, number: int, spacing_samples: int | None = None) -> None:
        """Strobes right after one another, one a word unless told otherwise."""
        spacing = spacing_samples or self.encoder.samples_per_word
        self.call(lambda: self.encoder.strobes.burst(self.encoder.sample, number, spacing))

    def read_spi(self, plan: SpiPlan, timeout_s: float = 60.0) -> np.ndarray:
        """Read frames at the SPI pins and give them, an array of SPI_FRAME. Raises TwinStopped, TimeoutError."""
        before = self.call(lambda: (self.core.plan_spi(plan), sum(map(len, self._frames)))[1])
        deadline = time.monotonic() + timeout_s
        while True:
            frames = np.concatenate([np.empty(0, SPI_FRAME), *self.call(lambda: list(self._frames))])
            if len(frames) - before >= len(plan.start):
                return frames[before:]
            if time.monotonic() > deadline:
                raise TimeoutError(f"{len(frames) - before} of {len(plan.start)} SPI frames in {timeout_s:g} s")
            time.sleep(0.01)

    def compare_edges(self) -> np.ndarray:
        """Words after which the compare output rose (even places) and fell (odd places), so far."""
        return np.concatenate([np.empty(0, np.int64), *self.call(lambda: list(self._compare))])

    def status(self) -> TwinStatus:
        """How it stands."""
        return self.call(self._status)

    def _status(self) -> TwinStatus:
        core, encoder = self.core, self.encoder
        return TwinStatus(
            time_s=encoder.time_s,
            slowdown=self._pace.slowdown,
            sleeping=self._sleeping,
            speed_rps=encoder.speed_rps,
            true_counts=float(encoder.true_counts_at(encoder.sample)),
            raw_position=_signed_48(core.output("raw_position")),
            position=_signed_48(core.output("position")),
            homed=bool(core.output("homed")),
            flags=core.output("flags"),
            strobe_rate_hz=encoder.strobes.rate_hz,
            strobes=encoder.strobes.number,
            bytes_from_host=self._sent,
            bytes_to_host=self._received,
            dropped_bytes=self._terminal.dropped_bytes,
        )

    def _live(self) -> None:
        try:
            self._run()
        except Exception as error:
            self._failure = error
        finally:
            self._calls.refuse()

    def _run(self) -> None:
        pending = b""
        self._pace.restart(self.encoder.time_s)
        active_s = time.monotonic()
        while not self._ending:
            called = self._calls.carry_out()
            self._sleeping = False
            came = self._terminal.read() if len(pending) < SENT_AHEAD_BYTES else b""
            self._sent += len(came)
            pending += self.change_bytes(came) if came else b""
            piece, rises = self.encoder.next_piece(WORDS_PER_RUN)
            self.strobe_samples.extend(rises)
            log = self.core.run(piece.changes, pending)
            pending = pending[log.taken :]
            if len(log.compare):
                self._compare.append(log.compare)
            if len(log.frames):
                self._frames.append(log.frames)
            if log.received:
                self._received += len(log.received)
                self._terminal.write(self.change_bytes(log.received))

            if came or called or pending or log.received or self.core.busy:
                active_s = time.monotonic()
            self._pace.keep(self.encoder.time_s)
            if self._sleep_after_s is not None and time.monotonic() - active_s > self._sleep_after_s:
                self._sleep()
                self._pace.restart(self.encoder.time_s)
                active_s = time.monotonic()

    def _sleep(self) -> None:
        """Until a byte comes, or a call."""
        self._sleeping = True
        while not self._ending and not self._calls:
            before = time.monotonic()
            self._terminal.wait(1.0, self._calls.woken)
            if time.monotonic() - before < 1.0:
                break


def _signed_48(value: int) -> int:
    return value - (1 << 48) if value >> 47 else value
