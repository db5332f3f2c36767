"""The course of a zero-return test on an instrument: what is waited for, and every reading taken meanwhile."""

import time

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN
from arcref.flags import FAULT_FLAGS, Flag, describe_faults
from arcref.instrument.counting_state import CountingState, read_counting_state
from arcref.instrument.fault_log import FaultLog
from arcref.instrument.instrument import Instrument
from arcref.instrument.shaft_drive import GeneratorDrive, UserDrive
from arcref.instrument.zero_mark_passes import ZeroMarkPasses
from arcref.instrument.zero_return_leg import Leg, ZeroReturnProgress
from arcref.instrument_error import InstrumentError
from arcref.link.link import LinkLost

PAST_COUNTS = 2 * COUNTS_PER_LINE
"""How far past the last mark the shaft must go; the instrument knows a mark to be missing one grating line past it."""

MOST_TURNS_TO_ZERO = 1.5
"""Turns in one direction within which a zero mark must have come."""


class ZeroReturnCourse:
    """The course of one test.

    `start`: the first reading, `states`: readings since the zero was known, `passes`: zero marks, `flags`: all that
    were up, `first_turn`: turn of the first mark, `fault_log`: what the instrument kept of each fault.
    """

    def __init__(self, instrument: Instrument, revolutions, timeout_s, readings_per_s, progress, ask):
        self._instrument, self.revolutions = instrument, revolutions
        self._timeout_s, self._period_s = timeout_s, 1 / readings_per_s
        self._progress, self._ask = progress, ask
        self._due_s = time.monotonic()
        self.flags = Flag(0)
        self.states: list[CountingState] = []

    def run(self, drive: UserDrive | GeneratorDrive, rehome: bool) -> None:
        """Prepare, turn forward and back."""
        drive.prepare()
        self._instrument.clear_flags(FAULT_FLAGS)
        self.fault_log = FaultLog(self._instrument.registers)
        self.start = self._rehome() if rehome else read_counting_state(self._instrument)
        homes = rehome or not self.start.homed
        self.passes = ZeroMarkPasses(self.start, homes=homes)
        self._last = self.start
        drive.forward(self.revolutions, homes)
        self.first_turn = 0
        if homes:
            self._wait_for_home()
        else:
            self.first_turn = self.start.raw_position // COUNTS_PER_TURN + 1
            self.states.append(self.start)
        last_mark = (self.first_turn + self.revolutions) * COUNTS_PER_TURN
        self._turn(1, last_mark + PAST_COUNTS)
        drive.reverse(self.revolutions)
        self._turn(-1, self.first_turn * COUNTS_PER_TURN - PAST_COUNTS)
        self._read("the end was read")  # counts the marks that the last reading saw passed

    def _rehome(self) -> CountingState:
        """Let the next index home, and be sure that none came while this was asked for."""
        while True:
            before = self._instrument.registers.index_count
            self._instrument.home()
            state = read_counting_state(self._instrument)
            if state.index_count == before:
                return state

    def _wait_for_home(self) -> None:
        leg = self._leg(1, None)
        leg.awaited = "the zero mark was awaited"
        while True:
            before = self._last
            state = self._read(leg.awaited)
            if not self.passes.waits_for_home:
                return
            # The reading before, because this one's position may have begun anew after its index count was read.
            if abs(leg.travelled(before.raw_position)) > MOST_TURNS_TO_ZERO:
                raise InstrumentError(
                    f"zero-return test: no zero mark came in {MOST_TURNS_TO_ZERO:g} turns; look at the Z line, its "
                    "width, and the register gate_state"
                )
            self._watch(leg, state)
            self._progress(ZeroReturnProgress("to the zero mark", 0.0, self.revolutions, self._speed_rps(before), 0.0))

    def _turn(self, direction: int, goal: int) -> None:
        leg = self._leg(direction, goal)
        name = "forward" if direction > 0 else "back"
        origin = self.first_turn * COUNTS_PER_TURN if direction > 0 else goal + PAST_COUNTS
        origin += self.revolutions * COUNTS_PER_TURN if direction < 0 else 0
        while not leg.reached(self._last.raw_position):
            done = direction * (self._last.raw_position - origin) / COUNTS_PER_TURN
            turn = min(int(max(done, 0)) + 1, self.revolutions)
            leg.awaited = f"turn {turn} of {self.revolutions} {name} was awaited"
            if done < 0 or not self.revolutions:
                leg.awaited = f"the zero mark was awaited on the way {'out' if direction > 0 else 'back'}"
            before = self._last
            state = self._read(leg.awaited)
            self._watch(leg, state)
            done = min(max(done, 0.0), float(self.revolutions))
            part = (done / self.revolutions if self.revolutions else 0.0) / 2 + (0.0 if direction > 0 else 0.5)
            self._progress(ZeroReturnProgress(name, done, self.revolutions, self._speed_rps(before), part))

    def _speed_rps(self, before: CountingState) -> float:
        elapsed_s = self._last.time_s - before.time_s
        counts = self._last.raw_position - before.raw_position
        return counts / COUNTS_PER_TURN / elapsed_s if elapsed_s > 0 else 0.0

    def _leg(self, direction: int, goal: int | None) -> Leg:
        return Leg(direction, self._last.raw_position, goal, self._timeout_s, time.monotonic())

    def _watch(self, leg: Leg, state: CountingState) -> None:
        """Tell the user when the shaft turns the wrong way. Raises `InstrumentError` at the time-out."""
        now_s = time.monotonic()
        line = leg.take(state.raw_position, now_s)
        if line:
            self._ask(line)
        overdue = leg.overdue(state.raw_position, now_s)
        if overdue:
            raise InstrumentError(f"zero-return test: {overdue}")

    def _read(self, awaited: str) -> CountingState:
        self._due_s = max(self._due_s + self._period_s, time.monotonic() - self._period_s)
        time.sleep(max(0.0, self._due_s - time.monotonic()))
        try:
            state = read_counting_state(self._instrument)
        except InstrumentError as error:
            kind = LinkLost if isinstance(error, LinkLost) else InstrumentError
            raise kind(f"zero-return test, while {awaited}: {error}; then it must be started again") from error
        if state.time_s < self._last.time_s or self._last.homed > state.homed:
            raise InstrumentError("zero-return test: the instrument was reset meanwhile; look at its supply")
        self.passes.take(state)
        for fault in describe_faults(state.flags & ~self.flags):
            self._ask(f"Fault: {fault}, at turn {state.raw_position / COUNTS_PER_TURN:.3f}.")
        self.flags |= state.flags
        self._last = state
        if not self.passes.waits_for_home:
            self.states.append(state)
        return state
