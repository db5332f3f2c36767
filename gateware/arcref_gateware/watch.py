"""The watch over a core: closure, edge spacing, illegal steps, and the flags that tell of them."""

from amaranth.hdl import Cat, Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import ANGLE_BITS, POSITION_BITS
from arcref.flags import Flag
from arcref_gateware.closure_check import CLOSURE_BITS, CLOSURE_CLOCKS, ClosureCheck
from arcref_gateware.edge_spacing import EDGE_SPACING_CLOCKS, SPACING_BITS, EdgeSpacing
from arcref_gateware.flag_register import FlagRegister
from arcref_gateware.illegal_steps import ILLEGAL_COUNT_BITS, IllegalSteps
from arcref_gateware.latency import (
    ADVANCE_READY,
    ANGLE_READY,
    CORRECTION_READY,
    LATENCY_CLOCKS,
    STEPS_READY,
    WAY_BACK_READY,
)
from arcref_gateware.register_stages import delayed
from arcref_gateware.strobe_delay import STROBE_REFUSED_CLOCKS


class Watch(wiring.Component):
    """Everything that is told of a word beside its position, `LATENCY_CLOCKS` clocks after it.

    Each input comes when its own stage of the core is ready, see `arcref_gateware.latency`.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "forward": In(samples_per_word),
                "reverse": In(samples_per_word),
                "illegal": In(samples_per_word),
                "homed": In(1),
                "index": In(1),
                "home": In(1),
                "index_way_back": In(signed(3)),
                "angle": In(ANGLE_BITS),
                "correction_active": In(1),
                "strobe_refused": In(1),
                "rom_fault": In(1),
                "raw_position": In(signed(POSITION_BITS)),
                "words": In(POSITION_BITS),
                "clear": In(8),
                "homed_out": Out(1),
                "illegal_steps": Out(ILLEGAL_COUNT_BITS),
                "closure_error": Out(signed(CLOSURE_BITS)),
                "largest_closure_error": Out(signed(CLOSURE_BITS)),
                "index_count": Out(16),
                "shortest_edge_spacing": Out(SPACING_BITS),
                "first_illegal_position": Out(signed(POSITION_BITS)),
                "first_illegal_time": Out(POSITION_BITS),
                "flags": Out(8),
                "causes": Out(8),
            }
        )

    forward: In
    """Bit i: sample i counted +1."""
    reverse: In
    """Bit i: sample i counted -1."""
    illegal: In
    """Bit i: A and B both changed at sample i."""
    homed: In
    """1 when the word is homed, with `index` and `home`."""
    index: In
    """1 when the word holds an index."""
    home: In
    """1 when that index homes."""
    index_way_back: In
    """Minus the sum of the word's steps after the index."""
    angle: In
    """Angle after the word."""
    correction_active: In
    """1 when the word is corrected."""
    strobe_refused: In
    """1 when the word brought a strobe that is not captured."""
    rom_fault: In
    """1 with the word that the verdict of the power-up check comes with, when that is bad."""
    raw_position: In
    """Raw position after the word, `LATENCY_CLOCKS` clocks after it."""
    words: In
    """Number of the word, with `raw_position`."""
    clear: In
    """Bit n: clear flag n, and what was kept with it, for one clock."""
    homed_out: Out
    """`homed`, with the other outputs."""
    illegal_steps: Out
    """Samples in which A and B both changed; stays at 65535."""
    closure_error: Out
    """Closure error at the last checked index, in counts."""
    largest_closure_error: Out
    """The closure error that was largest in size, with its sign, in counts. One clock after `closure_error`."""
    index_count: Out
    """Indices since reset, modulo 65536."""
    shortest_edge_spacing: Out
    """Shortest spacing of two edges of A and B, in sample periods."""
    first_illegal_position: Out
    """Raw position after the word of the first illegal step. One clock after `illegal_steps`."""
    first_illegal_time: Out
    """First sample of that word, in sample periods since reset."""
    flags: Out
    """The flag byte, see `arcref.flags.Flag`."""
    causes: Out
    """Bit n: the cause of flag n was there in the word; with `flags`."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        m.submodules.closure_check = closure = ClosureCheck()
        m.submodules.edge_spacing = spacing = EdgeSpacing(samples)
        m.submodules.illegal_steps = illegal = IllegalSteps(samples)
        m.submodules.flag_register = flag_register = FlagRegister()
        # Every cause of a flag meets its word's position a clock before the outputs.
        cause_ready = LATENCY_CLOCKS - 1

        # A clear comes to the searches for the shortest and the largest a clock before it comes to the flags: so it
        # keeps there just those words whose flags it keeps.

        # Edges of A and B.
        counted, edge = Signal(samples), Signal(samples)
        m.d.sync += [
            counted.eq(self.forward | self.reverse),
            edge.eq(self.forward | self.reverse | self.illegal),
        ]
        spacing_start = cause_ready - EDGE_SPACING_CLOCKS
        illegal_start = LATENCY_CLOCKS - IllegalSteps.CLOCKS
        early, late = sorted((spacing_start, illegal_start))
        edges = {early: delayed(m, Cat(counted, edge), early - STEPS_READY - 1, name="edges")}
        edges |= {late: delayed(m, edges[early], late - early, name="later_edges")}
        m.d.comb += [
            Cat(spacing.counted, spacing.edge).eq(edges[spacing_start]),
            spacing.clear.eq(self.clear[Flag.EDGE_SPACING_LIMIT.bit_length() - 1]),
            illegal.illegal.eq(edges[illegal_start][samples:] & ~edges[illegal_start][:samples]),
            illegal.position.eq(self.raw_position),
            illegal.time.eq(self.words << exact_log2(samples)),
        ]

        # The index.
        closure_start = LATENCY_CLOCKS - CLOSURE_CLOCKS
        wait = closure_start - WAY_BACK_READY
        m.d.comb += [
            closure.angle.eq(delayed(m, self.angle, closure_start - ANGLE_READY, name="angle")),
            closure.homed.eq(delayed(m, self.homed, wait, name="homed")),
            closure.index.eq(delayed(m, self.index, wait, name="index")),
            closure.home.eq(delayed(m, self.home, wait, name="home")),
            closure.index_way_back.eq(
                delayed(m, self.index_way_back, closure_start - ADVANCE_READY, name="index_way_back")
            ),
            closure.clear.eq(self.clear[Flag.CLOSURE_ERROR.bit_length() - 1]),
        ]

        # The last direction.
        reversing = Signal()
        for i in range(samples):
            with m.If(self.forward[i] | self.reverse[i]):
                m.d.comb += reversing.eq(self.reverse[i])
        direction = Signal()
        with m.If((self.forward | self.reverse).any()):
            m.d.sync += direction.eq(reversing)

        def cause(flag, value, ready):
            raised = delayed(m, value, cause_ready - ready, name=f"cause_{flag.name.lower()}")
            return flag_register.raised[flag.bit_length() - 1].eq(raised)

        m.d.comb += [
            cause(Flag.LAST_DIRECTION_REVERSE, direction, STEPS_READY + 1),
            cause(Flag.CORRECTION_ACTIVE, self.correction_active, CORRECTION_READY),
            cause(Flag.EDGE_SPACING_LIMIT, spacing.at_limit, cause_ready),
            cause(Flag.ROM_FAULT, self.rom_fault, ANGLE_READY),
            cause(Flag.CAPTURE_OVERRUN, self.strobe_refused, STROBE_REFUSED_CLOCKS),
            cause(Flag.INDEX_FAULT, closure.index_fault, cause_ready),
            cause(Flag.CLOSURE_ERROR, closure.closure_fault, cause_ready),
            cause(Flag.ILLEGAL_STEP, self.illegal.any(), STEPS_READY),
            flag_register.clear.eq(delayed(m, self.clear, 1, name="clear")),
            self.flags.eq(flag_register.flags),
            self.causes.eq(delayed(m, flag_register.raised, 1, name="causes")),
            self.homed_out.eq(delayed(m, self.homed, LATENCY_CLOCKS - WAY_BACK_READY, name="homed_out")),
            self.illegal_steps.eq(illegal.count),
            self.closure_error.eq(closure.closure_error),
            self.largest_closure_error.eq(closure.largest_closure_error),
            self.index_count.eq(closure.index_count),
            self.shortest_edge_spacing.eq(spacing.shortest),
            self.first_illegal_position.eq(illegal.first_position),
            self.first_illegal_time.eq(illegal.first_time),
        ]
        return m
