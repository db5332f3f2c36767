"""Captures waiting for the link, in block RAM. Nothing is dropped without being told.

A capture that finds the FIFO full is counted as lost, and the next one that is kept says how many were lost so far.
One such number can wait in the FIFO at a time; a capture that would need a second is lost and counted as well.

A capture goes into the memory in the clock in which it comes, with nothing before it, so whether there is room must be
known beforehand. It is known exactly while there is. A FIFO that was full lets captures in again `REOPEN_CLOCKS` after
one was taken.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import POSITION_BITS
from arcref_gateware.link.record_memory import RECORD_BITS, RecordMemory
from arcref_gateware.link.wide_counter import WIDE_COUNTER_BITS, WIDE_COUNTER_CLOCKS, WideCounter
from arcref_gateware.register_stages import delayed

COUNT_BITS = WIDE_COUNTER_BITS

LOSS_BIT = 120
"""Bit of a record that says that captures were lost before it. Below it stands what a CAPTURE packet carries."""

REOPEN_CLOCKS = 3
"""Clocks from `taken` to the first capture that a full FIFO keeps again."""

TAKE_CLOCKS = 6
"""Least clocks from one `taken` to the next."""

_LOW = 3
"""Bits of the level that are counted at once; the others follow."""


class CaptureOutlet(wiring.Signature):
    """The oldest capture of a `CaptureFifo`, as who takes it sees it."""

    def __init__(self):
        super().__init__(
            {
                "ready": In(1),
                "reading": Out(1),
                "taken": Out(1),
                "word_number": Out(3),
                "word": In(16),
                "lost": In(8),
                "next_lost": Out(1),
                "told": Out(1),
            }
        )


class CaptureFifo(wiring.Component):
    """Keeps `depth` captures, a power of two and 16 or more."""

    def __init__(self, depth: int):
        if depth < 2 << _LOW:
            raise ValueError(f"a FIFO of {depth} captures; {2 << _LOW} is the least")
        self.depth = depth
        super().__init__(
            {
                "valid": In(1),
                "time": In(POSITION_BITS),
                "raw": In(signed(POSITION_BITS)),
                "corrected": In(signed(POSITION_BITS)),
                "flags": In(8),
                "clear": In(1),
                "oldest": In(CaptureOutlet()),
                "level": Out(range(depth + 1)),
                "lost": Out(COUNT_BITS),
                "captures": Out(COUNT_BITS),
            }
        )

    valid: In
    """1 for one clock with each capture, in every clock if need be."""
    time: In
    """Its time, in sample periods."""
    raw: In
    """Raw position, in counts."""
    corrected: In
    """Corrected position, in counts; less than 2^15 counts from `raw`."""
    flags: In
    """The flag byte."""
    clear: In
    """1 for one clock: empty the FIFO, as soon as nothing is being read from it."""
    oldest: In
    """The oldest capture.

    `ready`: 1 while there is one. `reading`: 1 to keep it from being cleared. `taken`: 1 for one clock when it is done
    with, while `reading`. `word_number`: which word of it is wanted; `word`: that word, two clocks later: the bytes of
    a CAPTURE packet two by two, and in the highest byte whether captures were lost before it. `lost`: then, the lowest
    byte of their number since the last `clear`; `next_lost`: 1 for one clock for the next byte, two clocks later.
    `told`: 1 for one clock when the number is done with.
    """
    level: Out
    """Captures in the FIFO, a few clocks ago."""
    lost: Out
    """Captures lost since the last `clear`, modulo 2^32."""
    captures: Out
    """Captures since the last `clear`, kept or lost, modulo 2^32."""

    def elaborate(self, platform):
        m = Module()
        bits = exact_log2(self.depth)
        oldest = self.oldest
        m.submodules.memory = memory = RecordMemory(self.depth)

        closed = Signal()  # no capture is kept
        losing = Signal()  # a capture was lost since the last one kept
        told = Signal()  # a number of lost captures waits
        keeps, loses, takes = Signal(), Signal(), Signal()
        clear = Signal()
        waits, quiet = Signal(), Signal()  # a clear waits; and it may act
        m.d.comb += [keeps.eq(self.valid & ~closed), loses.eq(self.valid & closed), takes.eq(oldest.taken)]
        # Nobody begins to read without `ready`, which goes down first.
        m.d.comb += quiet.eq(waits & ~oldest.reading & ~oldest.ready)
        m.d.sync += [waits.eq(self.clear | (waits & ~quiet)), clear.eq(quiet)]

        head, tail = Signal(bits), Signal(bits)
        record = Cat(self.time, self.raw, self.corrected[:16], self.flags, losing)
        assert len(record) == LOSS_BIT + 1
        m.d.comb += [
            # While there is room it is always written; what no capture came for is overwritten by the next one.
            memory.write.eq(~closed),
            memory.write_record.eq(head),
            memory.record.eq(Cat(record, Const(0, RECORD_BITS - len(record)))),
            memory.read_record.eq(tail),
            memory.read_word.eq(oldest.word_number),
            oldest.word.eq(memory.word),
        ]
        m.d.sync += tail.eq(tail + takes)
        # The upper half of the head turns with the lower one: that its turn comes is known a clock early.
        half = bits // 2
        low, high = head[:half], head[half:]
        turns = Signal()
        last = (1 << half) - 1
        with m.If(keeps):
            m.d.sync += [low.eq(low + 1), turns.eq(low == last - 1)]
            with m.If(turns):
                m.d.sync += high.eq(high + 1)

        # The level: its upper part follows the lower one, but is never taken for that of the last free place early.
        level, upper, shown = Signal(_LOW), Signal(bits - _LOW + 1), Signal(_LOW)
        carry, borrow = Signal(), Signal()
        at_end = Signal()  # `upper` is that of a FIFO with one place free
        fills, frees = Signal(), Signal()
        m.d.comb += [fills.eq(keeps & ~takes), frees.eq(takes & ~keeps), self.level.eq(Cat(shown, upper))]
        m.d.sync += [
            level.eq(level + fills - frees),
            carry.eq(fills & level.all()),
            borrow.eq(frees & (level == 0)),
            shown.eq(level),
            upper.eq(upper + Cat(carry | borrow, borrow.replicate(len(upper) - 1))),
            at_end.eq((upper == (self.depth >> _LOW) - 1) & ~borrow & ~(frees & (level == 0))),
        ]
        has_room = Signal()
        m.d.sync += has_room.eq(closed & (has_room | (level != 0)))
        with m.If(closed):
            m.d.sync += closed.eq(~has_room | (told & (losing | self.valid)))
        with m.Else():
            m.d.sync += closed.eq(fills & at_end & level.all())

        # What was lost, and the number that waits: taken down once all before it are counted.
        came, lost = Signal(), Signal()
        m.submodules.lost_counter = lost_counter = WideCounter()
        m.submodules.capture_counter = capture_counter = WideCounter()
        m.d.sync += [came.eq(self.valid & ~clear), lost.eq(loses & ~clear)]
        m.d.comb += [
            lost_counter.count.eq(lost),
            capture_counter.count.eq(came),
            lost_counter.clear.eq(clear),
            capture_counter.clear.eq(clear),
            self.lost.eq(lost_counter.total),
            self.captures.eq(capture_counter.total),
        ]
        with m.If(self.valid):
            m.d.sync += losing.eq(closed)
        with m.If(oldest.told):
            m.d.sync += told.eq(0)
        with m.Elif(keeps & losing):
            m.d.sync += told.eq(1)
        waiting = Signal(COUNT_BITS, reset_less=True)
        loads, moves = Signal(), Signal()
        kept_after_loss = delayed(m, keeps & losing, WIDE_COUNTER_CLOCKS - 1, name="kept_after_loss")
        m.d.sync += [loads.eq(kept_after_loss), moves.eq(kept_after_loss | oldest.next_lost)]
        with m.If(moves):
            m.d.sync += waiting.eq(Mux(loads, lost_counter.total, waiting >> 8))
        m.d.comb += oldest.lost.eq(waiting)

        # The oldest one can be read once its level and its address have come through.
        settles = Signal(TAKE_CLOCKS - 1)
        is_empty = Signal(init=1)
        m.d.sync += [
            settles.eq(Cat(takes | clear, settles)),
            is_empty.eq((shown == 0) & (upper == 0)),
            oldest.ready.eq(~is_empty & ~settles.any() & ~takes & ~waits & ~clear),
        ]
        with m.If(clear):
            m.d.sync += [
                *(signal.eq(0) for signal in (head, tail, turns, level, upper, shown, carry, borrow, closed, has_room)),
                *(signal.eq(0) for signal in (losing, told)),
                *(at_end.eq(0), is_empty.eq(1)),
            ]
        return m
