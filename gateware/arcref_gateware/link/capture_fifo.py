"""Captures waiting for the link, in block RAM. Nothing is dropped without being told.

A capture that finds the FIFO full is counted as lost, and the next one that is kept says how many were lost so far.
One such number can wait in the FIFO at a time; a capture that would need a second is lost and counted as well.
"""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import POSITION_BITS
from arcref_gateware.correction import CORRECTION_BITS
from arcref_gateware.link.wide_counter import WIDE_COUNTER_BITS, WideCounter
from arcref_gateware.memory_attributes import NO_COLLISION

RECORD_BITS = 2 * POSITION_BITS + CORRECTION_BITS + 8 + 1
"""Time, raw position, corrected less raw position, flags, and whether captures were lost before it: 119, which eight
block RAMs of an iCE40 hold."""

COUNT_BITS = WIDE_COUNTER_BITS


class CaptureFifo(wiring.Component):
    """Keeps `depth` captures, a power of two."""

    def __init__(self, depth: int):
        self.depth = depth
        super().__init__(
            {
                "valid": In(1),
                "time": In(POSITION_BITS),
                "raw": In(signed(POSITION_BITS)),
                "corrected": In(signed(POSITION_BITS)),
                "flags": In(8),
                "clear": In(1),
                "ready": Out(1),
                "taken": In(1),
                "out_time": Out(POSITION_BITS),
                "out_raw": Out(signed(POSITION_BITS)),
                "out_correction": Out(signed(CORRECTION_BITS)),
                "out_flags": Out(8),
                "out_lost": Out(COUNT_BITS),
                "out_after_loss": Out(1),
                "level": Out(range(depth + 1)),
                "lost": Out(COUNT_BITS),
                "captures": Out(COUNT_BITS),
                "overrun": Out(1),
            }
        )

    valid: In
    """1 for one clock with each capture, in every clock if need be."""
    time: In
    """Its time, in sample periods."""
    raw: In
    """Raw position, in counts."""
    corrected: In
    """Corrected position, in counts; less than 2^13 counts from `raw`."""
    flags: In
    """The flag byte."""
    clear: In
    """1 for one clock: empty the FIFO."""
    ready: Out
    """1 while `out_...` hold the oldest capture."""
    taken: In
    """1 for one clock: the oldest capture is done with. Not again within four clocks."""
    out_time: Out
    """Time of the oldest capture."""
    out_raw: Out
    """Its raw position."""
    out_correction: Out
    """Its corrected less its raw position."""
    out_flags: Out
    """Its flag byte."""
    out_after_loss: Out
    """1 when captures were lost just before it: `out_lost` of them."""
    out_lost: Out
    """Captures lost since the last `clear`, up to the capture in the FIFO that says so."""
    level: Out
    """Captures in the FIFO."""
    lost: Out
    """Captures lost since the last `clear`, modulo 2^32."""
    captures: Out
    """Captures since the last `clear`, kept or lost, modulo 2^32."""
    overrun: Out
    """1 with each capture that is lost."""

    def elaborate(self, platform):
        m = Module()
        bits = exact_log2(self.depth)
        m.submodules.memory = memory = Memory(shape=RECORD_BITS, depth=self.depth, init=[], attrs=NO_COLLISION)
        write, read = memory.write_port(), memory.read_port(domain="comb")

        # First clock: the record, and whether there is room. `full` is one record early because this one is on its way.
        level = Signal(range(self.depth + 1))
        full = Signal()
        losing = Signal()  # a capture was lost since the last one kept
        told = Signal()  # a number of lost captures waits in the FIFO
        record = Signal(RECORD_BITS, reset_less=True)
        came = Signal()
        correction = Signal(signed(CORRECTION_BITS))
        m.d.comb += correction.eq(self.corrected[:CORRECTION_BITS] - self.raw[:CORRECTION_BITS])
        m.d.sync += [
            came.eq(self.valid & ~self.clear),
            record.eq(Cat(self.time, self.raw, correction, self.flags)),
        ]
        keeps, loses = Signal(), Signal()
        m.d.comb += [
            keeps.eq(came & ~full & ~(losing & told)),
            loses.eq(came & ~keeps),
        ]
        head, tail = Signal(bits), Signal(bits)
        m.d.comb += [
            write.addr.eq(head),
            write.data.eq(Cat(record[:-1], losing)),
            write.en.eq(keeps),
        ]
        m.submodules.lost_counter = lost_counter = WideCounter()
        m.submodules.capture_counter = capture_counter = WideCounter()
        m.d.comb += [
            lost_counter.count.eq(loses),
            capture_counter.count.eq(came),
            lost_counter.clear.eq(self.clear),
            capture_counter.clear.eq(self.clear),
            self.lost.eq(lost_counter.total),
            self.captures.eq(capture_counter.total),
        ]
        tells = Signal()
        m.d.sync += [self.overrun.eq(loses), tells.eq(keeps & losing)]
        with m.If(loses):
            m.d.sync += losing.eq(1)
        with m.If(keeps):
            m.d.sync += [head.eq(head + 1), losing.eq(0), told.eq(told | losing)]
        with m.If(tells):
            m.d.sync += self.out_lost.eq(lost_counter.total)

        removes = Signal()
        m.d.comb += removes.eq(self.taken & self.ready)
        with m.If(keeps & ~removes):
            m.d.sync += [level.eq(level + 1), full.eq(level == self.depth - 1)]
        with m.Elif(removes & ~keeps):
            m.d.sync += [level.eq(level - 1), full.eq(0)]
        with m.If(removes):
            m.d.sync += tail.eq(tail + 1)
            with m.If(self.out_after_loss):
                m.d.sync += told.eq(0)

        # The oldest record: address, memory, its register.
        shown = Signal(RECORD_BITS, reset_less=True)
        fetch = Signal(3)
        m.d.comb += [read.addr.eq(tail), self.ready.eq(fetch[2])]
        fetched = Signal(RECORD_BITS, reset_less=True)
        m.d.sync += [fetched.eq(read.data), shown.eq(fetched)]
        with m.If(removes | (level == 0)):
            m.d.sync += fetch.eq(0)
        with m.Else():
            m.d.sync += fetch.eq(Cat(1, fetch))
        m.d.comb += [
            Cat(self.out_time, self.out_raw, self.out_correction, self.out_flags, self.out_after_loss).eq(shown),
            self.level.eq(level),
        ]
        with m.If(self.clear):
            m.d.sync += [
                level.eq(0),
                full.eq(0),
                tail.eq(head),
                fetch.eq(0),
                told.eq(0),
                losing.eq(0),
            ]
        return m
