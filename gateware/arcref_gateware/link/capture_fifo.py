"""Captures waiting for the link, in block RAM. Nothing is dropped without being told.

A capture that finds the FIFO full is counted as lost, and the next one that is kept says how many were lost so far.
One such number can wait in the FIFO at a time; a capture that would need a second is lost and counted as well.

A capture goes into the memory in the clock in which it comes, with nothing before it, so whether there is room must be
known beforehand. It is known exactly while there is. A FIFO that was full lets captures in again `REOPEN_CLOCKS` after
one was taken. Just after reset it is cleared.
"""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import POSITION_BITS
from arcref_gateware.link.record_memory import RECORD_BITS, RecordMemory
from arcref_gateware.link.register_layout import TALLY_BITS
from arcref_gateware.register_stages import delayed

COUNT_BITS = 32
"""Bits of the number of lost captures."""

LOSS_BIT = 120
"""Bit of a record that says that captures were lost before it. Below it stands what a CAPTURE packet carries."""

REOPEN_CLOCKS = 4
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
                "lost": Out(TALLY_BITS),
                "captures": Out(TALLY_BITS),
                "cleared": Out(1),
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
    """Captures lost since the FIFO was cleared: the lowest bits of their number."""
    captures: Out
    """Captures since then, kept or lost: the lowest bits of their number."""
    cleared: Out
    """1 for one clock as the FIFO is cleared; the two numbers are 0 in the next."""

    def elaborate(self, platform):
        m = Module()
        bits = exact_log2(self.depth)
        oldest = self.oldest
        m.submodules.memory = memory = RecordMemory(self.depth)

        def state(*names: str, bits: int = 1, init: int = 0):
            """Registers that `clear` sets to their first value; as it holds at reset, they need no other."""
            signals = [Signal(bits, name=name, init=init, reset_less=True) for name in names]
            cleared.extend(signals)
            return signals if len(signals) > 1 else signals[0]

        cleared = []
        closed = state("closed")  # no capture is kept
        losing = state("losing")  # a capture was lost since the last one kept
        told = state("told")  # a number of lost captures waits
        keeps, loses, takes = Signal(), Signal(), Signal()
        clear = Signal()
        waits, quiet = Signal(init=1), Signal()  # a clear waits; and it may act
        m.d.comb += [keeps.eq(self.valid & ~closed), loses.eq(self.valid & closed), takes.eq(oldest.taken)]
        # Nobody begins to read without `ready`, which goes down first.
        m.d.comb += quiet.eq(waits & ~oldest.reading & ~oldest.ready)
        m.d.sync += [waits.eq(self.clear | (waits & ~quiet)), clear.eq(quiet)]

        head, tail = state("head", "tail", bits=bits)
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
        turns = state("turns")
        last = (1 << half) - 1
        with m.If(keeps):
            m.d.sync += [low.eq(low + 1), turns.eq(low == last - 1)]
            with m.If(turns):
                m.d.sync += high.eq(high + 1)

        # The level: its upper part follows the lower one, but is never taken for that of the last free place early.
        (level, shown), upper = state("level", "shown", bits=_LOW), state("upper", bits=bits - _LOW + 1)
        carry, borrow, borrowed = state("carry", "borrow", "borrowed")
        # `upper` is that of a FIFO with one place free: seen late, but not when the level goes down.
        is_last, at_end = state("is_last", "at_end")
        fills, frees = Signal(), Signal()
        # As tables: a carry chain behind a choice is slower.
        following, preceding = (
            Array(Const((value + step) % (1 << _LOW), _LOW) for value in range(1 << _LOW)) for step in (1, -1)
        )
        m.d.comb += [fills.eq(keeps & ~takes), frees.eq(takes & ~keeps), self.level.eq(Cat(shown, upper))]
        m.d.sync += [
            level.eq(Mux(fills, following[level], Mux(frees, preceding[level], level))),
            carry.eq(fills & level.all()),
            borrow.eq(frees & (level == 0)),
            shown.eq(level),
            upper.eq(upper + Cat(carry | borrow, borrow.replicate(len(upper) - 1))),
            borrowed.eq(borrow),
            is_last.eq(upper == (self.depth >> _LOW) - 1),
            at_end.eq(is_last & ~borrow & ~borrowed & ~(takes & (level == 0))),
        ]
        has_left, has_room = state("has_left", "has_room")
        m.d.sync += [has_left.eq(closed & (level != 0)), has_room.eq(closed & (has_room | has_left))]
        stays_closed = ~has_room | (told & (losing | self.valid))
        m.d.sync += closed.eq(Mux(closed, stays_closed, fills & at_end & level.all()))

        # What was lost, and the number that waits: byte by byte, each a clock after the one below it.
        came, carry_up = state("came", "lost_one")
        captures = state("captures", bits=TALLY_BITS)
        m.d.comb += [self.cleared.eq(clear), self.captures.eq(captures)]
        m.d.sync += [
            came.eq(self.valid),
            carry_up.eq(loses),
            captures.eq(captures + came),
            losing.eq(Mux(self.valid, closed, losing)),
            told.eq((told | (keeps & losing)) & ~oldest.told),
        ]
        places = COUNT_BITS // 8
        total = [state(f"total{k}", bits=8) for k in range(places)]
        carries = [carry_up, *(state(f"carry{k}") for k in range(1, places))]
        waiting = [Signal(8, name=f"waiting{k}", reset_less=True) for k in range(places)]
        after_loss = [delayed(m, keeps & losing, 1, name="after_loss1")]
        for k in range(places):
            after_loss.append(delayed(m, after_loss[-1], 1, name=f"after_loss{k + 2}"))
            moves = Signal(name=f"moves{k}")
            above = waiting[k + 1] if k + 1 < places else 0
            m.d.sync += [
                Cat(total[k], carries[k + 1] if k + 1 < places else Signal(name="beyond")).eq(total[k] + carries[k]),
                moves.eq(after_loss[k] | oldest.next_lost),
            ]
            with m.If(moves):
                m.d.sync += waiting[k].eq(Mux(after_loss[k + 1], total[k], above))
        m.d.comb += [self.lost.eq(total[0]), oldest.lost.eq(waiting[0])]

        # The oldest one can be read once its level and its address have come through.
        settles = Signal(TAKE_CLOCKS - 1)
        is_empty = state("is_empty", init=1)
        m.d.sync += [
            settles.eq(Cat(takes | clear, settles)),
            is_empty.eq((shown == 0) & (upper == 0)),
            oldest.ready.eq(~is_empty & ~settles.any() & ~takes & ~waits & ~clear),
        ]
        with m.If(clear):
            m.d.sync += [signal.eq(signal.init) for signal in cleared]
        return m
