"""A shaft that moves with the time of the reads, behind a pseudo-instrument that counts it as the gateware would."""

import random

from arcref.angle import COUNTS_PER_LINE, COUNTS_PER_TURN
from arcref.flags import FAULT_FLAGS, Flag

SAMPLE_RATE_HZ = 800_000_000


class MovingShaft(dict):
    """Registers of an instrument on a moving shaft; give it to a `PseudoInstrument` by `attach`.

    Every reading of the watching registers and every snapshot takes between half and the whole of `step_s`; meanwhile
    the shaft turns at `speed_rps` towards `turn_at` (turns), then back to `end_at`. `start` is where it begins. The
    zero mark is at whole turns. `lost`: {turns: counts} lost where the shaft passes that place forward. `dark`: turns
    whose mark does not come. `correct`: raw position to corrected; with `corrects` False the correction is off.
    """

    def __init__(
        self, *, start=-0.3, turn_at=0.0, end_at=-0.3, speed_rps=10.0, step_s=0.01, homed=False, seed=1, **more
    ):
        super().__init__()
        self.place = start * COUNTS_PER_TURN
        self.goals = [turn_at * COUNTS_PER_TURN, end_at * COUNTS_PER_TURN]
        self.speed_rps, self.step_s, self.random = speed_rps, step_s, random.Random(seed)
        self.lost = {turns * COUNTS_PER_TURN: counts for turns, counts in more.pop("lost", {}).items()}
        self.dark, self.correct = more.pop("dark", set()), more.pop("correct", lambda raw: raw)
        self.homed, self.zero = homed, more.pop("zero", 0)  # `zero`: raw position where the place is 0
        self.armed = not homed
        self.corrects = more.pop("corrects", True)
        self.time = 5 * SAMPLE_RATE_HZ
        self.on_step = lambda: None
        self.stands = False
        self |= {"closure_error": 0, "largest_closure_error": 0, "index_count": 65530, "illegal_steps": 3}
        self |= {"shortest_edge_spacing": 9, "flags": 0, "rom_state": 1} | more

    def attach(self, instrument):
        """Put this behind the instrument."""
        for name, value in instrument.values.items():
            self.setdefault(name, value)
        instrument.values = self
        instrument.on_write = self.write
        return instrument

    @property
    def raw(self) -> int:
        """Raw position."""
        return int(self.place // 1) + self.zero

    def get(self, name, default=0):
        """A register as it reads now."""
        if name in ("closure_error", "snapshot_number"):
            self.step(self.step_s * self.random.uniform(0.5, 1))
        if name == "snapshot_number":
            flags = self["flags"] | (Flag.CORRECTION_ACTIVE if self.homed and self.corrects else 0)
            self |= {"snapshot_raw": self.raw, "snapshot_position": self.correct(self.raw), "snapshot_time": self.time}
            self["snapshot_flags"] = int(flags) | self.homed << 8
        return super().get(name, default)

    def write(self, name, value):
        """What was written to the instrument."""
        if name == "clear_flags":
            self["flags"] &= ~(value & int(FAULT_FLAGS))
            self["largest_closure_error"] = 0 if value & Flag.CLOSURE_ERROR else self["largest_closure_error"]
        if name == "home":
            self.armed = True

    def step(self, elapsed_s):
        """Let time pass."""
        self.on_step()
        self.time += round(elapsed_s * SAMPLE_RATE_HZ)
        if self.stands or not self.goals:
            return
        way = self.speed_rps * elapsed_s * COUNTS_PER_TURN
        goal = self.goals[0]
        self.move_to(min(self.place + way, goal) if goal > self.place else max(self.place - way, goal))
        if self.place == goal:
            self.goals.pop(0)

    def move_to(self, place):
        """Move, with everything that is met on the way."""
        before = self.place
        direction = 1 if place > before else -1
        low, high = sorted((before, place))
        self["flags"] = self["flags"] & ~1 | (direction < 0)
        first, last = int(low // COUNTS_PER_TURN) - 1, int(high // COUNTS_PER_TURN) + 1
        events = [(turn * COUNTS_PER_TURN, self._mark) for turn in range(first, last + 1)]
        line = direction * (COUNTS_PER_LINE + 0.5)
        events += [(turn * COUNTS_PER_TURN + line, self._past_mark) for turn in self.dark]
        events += [(at + 0.25, self._lose) for at in self.lost]
        met = [event for event in events if (low < event[0] <= high if direction > 0 else low <= event[0] < high)]
        for at, act in sorted(met, key=lambda event: direction * event[0]):
            self.place = at
            act(at, direction)
        self.place = place

    def _lose(self, at, direction):
        if direction > 0:
            self.zero -= self.lost.pop(at - 0.25)

    def _mark(self, at, direction):
        if at / COUNTS_PER_TURN in self.dark:
            return
        self["index_count"] = (self["index_count"] + 1) % 65536
        if self.armed:
            self.armed, self.homed, self.zero = False, True, -int(at)
            return
        error = (int(at) + self.zero + COUNTS_PER_TURN // 2) % COUNTS_PER_TURN - COUNTS_PER_TURN // 2
        self["closure_error"] = error
        if abs(error) > abs(self["largest_closure_error"]):
            self["largest_closure_error"] = error
        if error:
            self.fault(Flag.CLOSURE_ERROR, "closure_error")

    def _past_mark(self, at, direction):
        if self.homed and not self.armed:
            self.fault(Flag.INDEX_FAULT, "index_fault")

    def fault(self, flag, key):
        """A cause of `flag` is met."""
        if not self["flags"] & flag:
            self |= {f"{key}_first_position": self.raw, f"{key}_first_time": self.time}
        self["flags"] |= int(flag)
        self[f"{key}_count"] = super().get(f"{key}_count", 0) + 1
