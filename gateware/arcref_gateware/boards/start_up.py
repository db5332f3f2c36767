"""Start-up: reset is held until the PLL is locked, block RAM can be read, and the gearing has started together.

Runs from the oscillator, which needs no PLL. For the gearing of the ECP5 it keeps to the order of Lattice's own
`gddr_sync` (FPGA-TN-02035, ECP5 high-speed I/O): the edge clock is stopped, the gearing and the clock divider are
reset, the reset is released while the edge clock stands still, the edge clock starts, and eight clocks later
everything is ready. So every input begins with the same edge of the clock, however unequally fast the reset reaches
them, and their sample words stay aligned to one another.
"""

from math import ceil

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

MEMORY_READABLE_S = 15e-6
"""iCE40 block RAM reads 0 for about 3 us after configuration; five times that, as Amaranth's own platform waits."""

STEP_CLOCKS = 8
"""Oscillator clocks for each step of the sequence; several edge clocks fit into one of them."""


class StartUp(wiring.Component):
    """The start-up sequence, in the domain `start`.

    `oscillator_hz` is the frequency of that domain; `memory_readable_s` is shortened by tests alone.
    """

    def __init__(self, oscillator_hz: float, *, memory_readable_s: float = MEMORY_READABLE_S):
        self.wait_clocks = max(STEP_CLOCKS, ceil(memory_readable_s * oscillator_hz))
        super().__init__({"locked": In(1), "stop": Out(1, init=1), "gearing_reset": Out(1, init=1), "ready": Out(1)})

    locked: In
    """Lock of the PLL, asynchronous. Its loss starts the sequence anew."""
    stop: Out
    """Stops the edge clock."""
    gearing_reset: Out
    """Resets the gearing and the divider of the word clock."""
    ready: Out
    """1 when the word clock runs and everything may leave reset."""

    def elaborate(self, platform):
        m = Module()
        locked = Signal()
        m.submodules.locked = FFSynchronizer(self.locked, locked, o_domain="start")
        release_reset = self.wait_clocks
        start_edge_clock = release_reset + STEP_CLOCKS
        leave_reset = start_edge_clock + STEP_CLOCKS
        clocks = Signal(range(leave_reset + 1))
        with m.If(~locked):
            m.d.start += clocks.eq(0)
        with m.Elif(clocks != leave_reset):
            m.d.start += clocks.eq(clocks + 1)
        m.d.start += [
            self.gearing_reset.eq(~locked | (clocks < release_reset)),
            self.stop.eq(~locked | (clocks < start_edge_clock)),
            self.ready.eq(locked & (clocks == leave_reset)),
        ]
        return m
