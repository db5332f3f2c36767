"""Records of one instant against a plain model: bunched faults, faults while records are written, snapshots, resets."""

import random

import numpy as np
import pytest
from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth_bench import Bench

from arcref.flags import FAULT_FLAGS
from arcref.link.registers import REGISTERS, fault_key
from arcref_gateware.link.register_layout import fault_flags
from arcref_gateware.link.register_memory import PHASES, RECORD_WRITES
from arcref_gateware.link.status_recorder import RECORD_CLOCKS, StatusRecorder

CLOCKS = 3000
FLAGS = fault_flags()
SETTLED = 2 * (len(FLAGS) + 1) * RECORD_CLOCKS + 20
"""Clocks that records of everything take, begun while those of everything are being written."""


class Recording(wiring.Component):
    """The recorder, with inputs that tell the clock they belong to, and the phases in which it is listened to."""

    flags: In(8)
    snapshot: In(1)
    writes: Out(1)
    place: Out(8)
    record: Out(16)
    done: Out(1)
    number: Out(1)

    def __init__(self, first_phase: int):
        self.first_phase = first_phase
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        m.submodules.recorder = recorder = StatusRecorder()
        phase, clock = Signal(PHASES, init=1 << self.first_phase), Signal(48)
        m.d.sync += [phase.eq(phase.rotate_left(1)), clock.eq(clock + 1)]
        # Every value of an instant says which clock it is of, in all its words.
        tile = (clock[:16] << 32) | (clock[:16] << 16) | clock[:16]
        m.d.comb += [
            recorder.raw_position.eq(tile),
            recorder.time.eq(tile ^ 0x0100_0200_0300),
            recorder.position.eq(tile ^ 0x0400_0500_0600),
            recorder.flags.eq(self.flags),
            recorder.homed.eq(clock[0]),
            recorder.snapshot.eq(self.snapshot),
            self.writes.eq(recorder.record_valid & Cat(phase[k] for k in RECORD_WRITES).any()),
            self.place.eq(recorder.record_place),
            self.record.eq(recorder.record),
            self.done.eq(recorder.snapshot_done),
            self.number.eq(recorder.snapshot_number),
        ]
        return m


@pytest.fixture(scope="module", params=range(PHASES))
def bench(request):
    return Bench(
        Recording(request.param), ["flags", "snapshot", "rst"], ["writes", "place", "record", "done", "number"]
    )


def logs(rows) -> list[tuple[int, int, list[int]]]:
    """(clock of its last word, first place, words) of each whole record."""
    found, words = [], {}
    for clock in np.flatnonzero(rows["writes"]):
        place = int(rows["place"][clock])
        base = place & ~7 if place >= 0x40 else 0x11
        words.setdefault(base, {})[place] = int(rows["record"][clock])
        length = 6 if base >= 0x40 else 10
        assert len(words) == 1, "words of two records are mixed"
        assert place in range(base, base + length)
        if len(words[base]) == length:
            found.append((int(clock), base, [words[base][base + i] for i in range(length)]))
            del words[base]
    assert not words, "a record was left unfinished"
    return found


def instant_of(words) -> int:
    """The clock that a record is of, after a look that all its words are of that clock."""
    clock = words[0]
    masks = [0, 0, 0, 0x300, 0x200, 0x100, 0x600, 0x500, 0x400]
    assert [word ^ mask for word, mask in zip(words, masks, strict=False)] == [clock] * min(len(words), 9)
    return clock


def place_of(flag) -> int:
    return REGISTERS[f"{fault_key(flag)}_first_position"].address


def flag_stimulus(rng, density):
    """Flags that go up at random, several at once now and then, and are cleared after a while."""
    flags = np.zeros(CLOCKS, dtype=int)
    up = 0
    for clock in range(CLOCKS - SETTLED):
        if rng.random() < density:
            for _ in range(rng.choice([1, 1, 2, 6])):
                up |= int(rng.choice(FLAGS))
        if rng.random() < density / 2:
            up &= rng.getrandbits(8)
        flags[clock] = up | (rng.getrandbits(8) & 0xFF & ~int(FAULT_FLAGS))
    flags[CLOCKS - SETTLED :] = up
    return flags


@pytest.mark.parametrize("density", [0.003, 0.05, 0.6])
def test_every_fault_that_goes_up_is_entered_and_with_the_instant_when_nothing_is_being_written(bench, density):
    rng = random.Random(int(density * 1000))
    flags = flag_stimulus(rng, density)
    snapshots = np.array([rng.random() < 0.004 for _ in range(CLOCKS)])
    snapshots[CLOCKS - SETTLED :] = False
    rows = bench.run(CLOCKS, flags=flags, snapshot=snapshots.astype(int), rst=[1, 0])
    records = logs(rows)
    first = 1  # the clock counter stands at 0 in the clocks of the reset and behind it
    quiet = 0
    entered = {}
    for end, base, words in records:
        entered.setdefault(base, []).append((end, instant_of(words)))
    for flag in FLAGS:
        bit = int(flag)
        up = (flags & bit) != 0
        rises = [k for k in range(2, CLOCKS) if up[k] and not up[k - 1]]
        mine = entered.get(place_of(flag), [])
        for rise in rises:
            at = [instant + first for _, instant in mine]
            # Of its own instant, or of the first that could be taken after records that were under way.
            later = [instant for instant in at if rise <= instant <= rise + SETTLED]
            assert later, f"{flag!r} of clock {rise} was never entered"
            if min(later) != rise:
                assert any(changes(flags, snapshots, k) for k in range(rise - SETTLED, rise)), f"{flag!r} at {rise}"
            else:
                quiet += 1
    assert quiet > 3
    wanted = int(snapshots.sum())
    assert rows["done"].sum() <= wanted
    assert (wanted == 0) == (rows["done"].sum() == 0)


def changes(flags, snapshots, clock) -> bool:
    """Whether a record began to be wanted in a clock."""
    if clock < 1:
        return False
    return bool(snapshots[clock] or (flags[clock] & ~flags[clock - 1] & int(FAULT_FLAGS)))


def test_faults_of_one_instant_share_it(bench):
    flags = np.zeros(CLOCKS, dtype=int)
    for k, start in enumerate(range(10, CLOCKS - SETTLED, SETTLED)):
        flags[start : start + SETTLED - 20] = int(FAULT_FLAGS) if k % 2 else int(FLAGS[k % 6] | FLAGS[(k + 1) % 6])
    records = logs(bench.run(CLOCKS, flags=flags, rst=[1, 0]))
    instants = [instant_of(words) + 1 for _, _, words in records]
    starts = list(range(10, CLOCKS - SETTLED, SETTLED))
    assert instants == [start for k, start in enumerate(starts) for _ in range(6 if k % 2 else 2)]
    together = [base for (_, base, _), instant in zip(records, instants, strict=True) if instant == starts[1]]
    assert together == [place_of(flag) for flag in FLAGS]


def test_a_snapshot_is_whole_and_done_once_its_words_were_given(bench):
    wanted = list(range(20, CLOCKS - SETTLED, 97))
    snapshot = np.isin(np.arange(CLOCKS), wanted).astype(int)
    flags = np.array([k * 37 & 0x03 for k in range(CLOCKS)])
    rows = bench.run(CLOCKS, flags=flags, snapshot=snapshot, rst=[1, 0])
    done = np.flatnonzero(rows["done"])
    records = logs(rows)
    assert len(records) == len(done) == len(wanted)
    for (end, base, words), ready, asked in zip(records, done, wanted, strict=True):
        instant = instant_of(words)
        assert base == REGISTERS["snapshot_raw"].address
        assert asked <= instant + 1 <= asked + 3
        assert end < ready <= asked + RECORD_CLOCKS + 8
        assert words[9] == flags[instant + 1] | (instant & 1) << 8
    assert np.count_nonzero(np.diff(rows["number"])) == len(wanted)


def test_a_reset_in_the_middle_of_a_record_leaves_nothing_behind(bench):
    rng = random.Random(3)
    for _ in range(6):
        at = rng.randrange(60, 260)
        flags = np.where(np.arange(CLOCKS) < 50, 0, int(FAULT_FLAGS))
        flags[at:] = 0
        reset = np.zeros(CLOCKS, dtype=int)
        reset[[0, at, at + 1]] = 1
        flags[at + 100 :] = int(FLAGS[2])
        rows = bench.run(CLOCKS, flags=flags, rst=reset)
        rows["writes"][:at] = 0
        records = logs({name: column[at + 2 :] for name, column in rows.items()})
        assert [base for _, base, _ in records] == [place_of(FLAGS[2])]
        assert instant_of(records[0][2]) == 100 - 2
