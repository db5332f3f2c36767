"""The core: from sample words to a corrected angle, with everything that watches over it.

    clock  1, 2        quadrature: the word, its steps
           3, 4        partial sums; index and strobe placed in the word
           5..8        position, a segment a clock
           7..12       correction: look-up, sum, rounding
           12..15      position less correction; closure check; spacing, counters and flags wait for it

Every output shows, `LATENCY_CLOCKS` clocks later, the state after the last sample of a word.
"""

from amaranth.hdl import Module, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import ANGLE_BITS, POSITION_BITS
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref_gateware.capture import CORRECTED_CLOCKS, RAW_CLOCKS, Capture, corrected_position
from arcref_gateware.closure_check import CLOSURE_BITS, CLOSURE_CLOCKS, ClosureCheck
from arcref_gateware.correction import CORRECTION_CLOCKS, Correction
from arcref_gateware.edge_spacing import EDGE_SPACING_CLOCKS, SPACING_BITS, EdgeSpacing
from arcref_gateware.flag_register import FlagRegister
from arcref_gateware.illegal_steps import IllegalSteps
from arcref_gateware.index_detector import IndexDetector
from arcref_gateware.partial_sums import PARTIAL_SUM_CLOCKS, PartialSums, value_at
from arcref_gateware.position import ANGLE_CLOCKS, POSITION_CLOCKS, PositionAccumulator
from arcref_gateware.position_spi import PositionSpi
from arcref_gateware.quadrature import DEFAULT_GATE_STATE, QUADRATURE_CLOCKS, Quadrature, check_samples_per_word
from arcref_gateware.register_stages import delayed
from arcref_gateware.rom_check import RomCheck
from arcref_gateware.strobe_delay import (
    STROBE_CLOCKS,
    STROBE_DELAY_BITS,
    STROBE_REFUSED_CLOCKS,
    StrobeDelay,
)
from arcref_gateware.table_contents import placeholder_contents, rom_contents
from arcref_gateware.time_counter import TimeCounter

SUMS_READY = QUADRATURE_CLOCKS + PARTIAL_SUM_CLOCKS
ANGLE_READY = SUMS_READY + ANGLE_CLOCKS
POSITION_READY = SUMS_READY + POSITION_CLOCKS
CORRECTION_READY = ANGLE_READY + CORRECTION_CLOCKS

LATENCY_CLOCKS = CORRECTION_READY + CORRECTED_CLOCKS
"""Clocks from a sample word to the outputs that show the state after it, captures among them."""

ROM_VERDICT_WORD = RomCheck.CLOCKS - ANGLE_READY
"""The word, counted from reset, with which the verdict of the power-up check takes effect."""

FIRST_CORRECTED_WORD = ROM_VERDICT_WORD + 1
"""The first word that can be corrected: the one before it fetches what the look-ups hold on to."""


class ReferenceEncoder(wiring.Component):
    """The core of the instrument, pure logic over sample words.

    Parameters: `rom`, the correction, or None for the placeholder contents of a bitstream that gets its ROM later;
    `samples_per_word` (1, 2 or 4); `gate_state`, the (A, B) of the zero mark; `strobe_delay`, the reset value of the
    delay in sample periods (0..65535). Raises ValueError for others.
    """

    def __init__(
        self,
        rom: CorrectionRom | None,
        samples_per_word: int = 4,
        *,
        gate_state: tuple[int, int] = DEFAULT_GATE_STATE,
        strobe_delay: int = 0,
    ):
        check_samples_per_word(samples_per_word)
        if not 0 <= strobe_delay < 1 << STROBE_DELAY_BITS:
            raise ValueError(f"the strobe delay must lie in 0 .. {(1 << STROBE_DELAY_BITS) - 1}, not {strobe_delay!r}")
        if len(gate_state) != 2 or not set(gate_state) <= {0, 1}:
            raise ValueError(f"the gate state is a pair of levels of A and B, not {gate_state!r}")
        self.rom = rom
        self.contents = placeholder_contents() if rom is None else rom_contents(rom)
        self.samples_per_word = samples_per_word
        self.gate_state = gate_state
        super().__init__(
            {
                "a": In(samples_per_word),
                "b": In(samples_per_word),
                "z": In(samples_per_word),
                "strobe": In(samples_per_word),
                "strobe_delay": In(STROBE_DELAY_BITS, init=strobe_delay),
                "raw_position": Out(signed(POSITION_BITS)),
                "position": Out(signed(POSITION_BITS)),
                "homed": Out(1),
                "illegal_steps": Out(16),
                "closure_error": Out(signed(CLOSURE_BITS)),
                "largest_closure_error": Out(signed(CLOSURE_BITS)),
                "index_count": Out(16),
                "flags": Out(8),
                "capture_valid": Out(1),
                "capture_position": Out(signed(POSITION_BITS)),
                "capture_raw": Out(signed(POSITION_BITS)),
                "capture_time": Out(POSITION_BITS),
                "shortest_edge_spacing": Out(SPACING_BITS),
                "first_illegal_position": Out(signed(POSITION_BITS)),
                "first_illegal_time": Out(POSITION_BITS),
                "spi_sck": In(1),
                "spi_cs_n": In(1, init=1),
                "spi_copi": In(1),
                "spi_cipo": Out(1),
            }
        )

    a: In
    """Samples of A, bit 0 the oldest."""
    b: In
    """Samples of B, bit 0 the oldest."""
    z: In
    """Samples of the zero pulse, bit 0 the oldest."""
    strobe: In
    """Samples of the strobe, bit 0 the oldest; its rising edge captures."""
    strobe_delay: In
    """Sample periods from a strobe to its due sample. Change it only while none waits."""
    raw_position: Out
    """Position as counted, in counts."""
    position: Out
    """Position less the correction, in counts; equal to `raw_position` while the correction is off."""
    homed: Out
    """1 once the first index has set the zero."""
    illegal_steps: Out
    """Samples in which A and B both changed; stays at 65535."""
    closure_error: Out
    """Closure error at the last checked index, in counts."""
    largest_closure_error: Out
    """The closure error that was largest in size, with its sign, in counts. One clock after `closure_error`."""
    index_count: Out
    """Indices since reset, modulo 65536."""
    flags: Out
    """The flag byte, see `arcref.flags.Flag`."""
    capture_valid: Out
    """1 for one clock with each captured strobe."""
    capture_position: Out
    """Corrected position at the due sample, in counts."""
    capture_raw: Out
    """Raw position at the due sample, in counts."""
    capture_time: Out
    """The due sample, in sample periods since reset."""
    shortest_edge_spacing: Out
    """Shortest spacing of two edges of A and B, in sample periods; within `LATENCY_CLOCKS` clocks."""
    first_illegal_position: Out
    """Raw position after the word of the first illegal step. One clock after `illegal_steps`."""
    first_illegal_time: Out
    """First sample of that word, in sample periods since reset."""
    spi_sck: In
    """SPI clock, asynchronous, at most one eighth of the word clock."""
    spi_cs_n: In
    """SPI chip select, active low, asynchronous."""
    spi_copi: In
    """SPI data from the controller, asynchronous."""
    spi_cipo: Out
    """SPI data to the controller."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word
        sample_bits = exact_log2(samples)

        m.submodules.quadrature = quadrature = Quadrature(samples, self.gate_state)
        m.submodules.index_detector = index_detector = IndexDetector(samples)
        m.submodules.partial_sums = sums = PartialSums(samples)
        m.submodules.position = position = PositionAccumulator()
        m.submodules.strobe_delay = strobe = StrobeDelay(samples)
        m.submodules.correction = correction = Correction(self.contents.line, self.contents.subdivision)
        m.submodules.capture = capture = Capture(samples)
        m.submodules.rom_check = rom_check = RomCheck(self.contents.identity)
        m.submodules.closure_check = closure = ClosureCheck()
        m.submodules.edge_spacing = spacing = EdgeSpacing(samples)
        m.submodules.illegal_steps = illegal = IllegalSteps(samples)
        m.submodules.flag_register = flag_register = FlagRegister()
        m.submodules.time_counter = time = TimeCounter()
        m.submodules.spi = spi = PositionSpi()

        m.d.comb += [
            quadrature.a.eq(self.a),
            quadrature.b.eq(self.b),
            quadrature.z.eq(self.z),
            strobe.strobe.eq(self.strobe),
            strobe.delay.eq(self.strobe_delay),
            index_detector.gate.eq(quadrature.gate),
            sums.forward.eq(quadrature.forward),
            sums.reverse.eq(quadrature.reverse),
            sums.index_sample.eq(index_detector.index_sample),
            position.total.eq(sums.total),
            position.home.eq(index_detector.home),
            position.home_remainder.eq(sums.index_remainder),
        ]
        event_way_back = Signal(signed(3))
        m.d.sync += event_way_back.eq(value_at(sums.way_back, strobe.due_sample))
        m.d.comb += position.event_way_back.eq(event_way_back)

        # Correction of the word's end and of the event.
        event = delayed(m, strobe.due, ANGLE_READY - STROBE_CLOCKS, name="event")
        homed = delayed(m, index_detector.homed, ANGLE_READY - SUMS_READY, name="homed")
        m.d.comb += [
            correction.angle.eq(position.angle),
            correction.event_angle.eq(position.event_angle),
            correction.event.eq(event),
            correction.homed.eq(homed),
            correction.usable.eq(rom_check.good),
            correction.check_enable.eq(rom_check.busy),
            correction.check_address.eq(rom_check.address),
            rom_check.line_word.eq(correction.line_word),
            rom_check.subdivision_word.eq(correction.subdivision_word),
        ]

        raw = delayed(m, position.position, CORRECTION_READY - POSITION_READY, name="raw")
        m.d.comb += [
            self.position.eq(
                corrected_position(m, raw, correction.word_complement, correction.active, name="position")
            ),
            self.raw_position.eq(delayed(m, raw, LATENCY_CLOCKS - CORRECTION_READY, name="raw_position")),
        ]

        # Time of a word, and the record of a strobe's due sample.
        time_start = LATENCY_CLOCKS - TimeCounter.CLOCKS
        due_place = Signal(sample_bits)
        for i in range(samples):
            with m.If(strobe.due_sample[i]):
                m.d.comb += due_place.eq(i)
        event_ready = CORRECTION_READY - RAW_CLOCKS
        m.d.comb += [
            time.valid.eq(delayed(m, quadrature.valid, time_start - QUADRATURE_CLOCKS, name="time_valid")),
            capture.event.eq(delayed(m, strobe.due, event_ready - STROBE_CLOCKS, name="capture_event")),
            capture.sample.eq(delayed(m, due_place, event_ready - STROBE_CLOCKS, name="due_place")),
            capture.position.eq(delayed(m, position.position, event_ready - POSITION_READY, name="capture_position")),
            capture.way_back.eq(delayed(m, event_way_back, event_ready - SUMS_READY - 1, name="event_way_back")),
            capture.complement.eq(correction.event_complement),
            capture.active.eq(correction.active),
            capture.words.eq(time.words),
            self.capture_valid.eq(capture.valid),
            self.capture_position.eq(capture.corrected),
            self.capture_raw.eq(capture.raw),
            self.capture_time.eq(capture.time),
        ]

        # Watches: each waits until its word is through the correction.
        closure_start = LATENCY_CLOCKS - CLOSURE_CLOCKS
        index_way_back = Signal(signed(3))
        m.d.sync += index_way_back.eq(-sums.index_remainder)
        word_angle = position.position[:ANGLE_BITS]
        m.d.comb += [
            closure.angle.eq(delayed(m, word_angle, closure_start - POSITION_READY, name="closure")),
            closure.homed.eq(delayed(m, index_detector.homed, closure_start - SUMS_READY, name="closure_homed")),
            closure.index.eq(delayed(m, index_detector.index, closure_start - SUMS_READY, name="closure_index")),
            closure.home.eq(delayed(m, index_detector.home, closure_start - SUMS_READY, name="closure_home")),
            closure.index_way_back.eq(
                delayed(m, index_way_back, closure_start - SUMS_READY - 1, name="index_way_back")
            ),
            spacing.forward.eq(quadrature.forward),
            spacing.reverse.eq(quadrature.reverse),
            spacing.illegal.eq(quadrature.illegal),
            spacing.clear.eq(spi.clear_flags[Flag.EDGE_SPACING_LIMIT.bit_length() - 1]),
            closure.clear.eq(spi.clear_flags[Flag.CLOSURE_ERROR.bit_length() - 1]),
            self.closure_error.eq(closure.closure_error),
            self.largest_closure_error.eq(closure.largest_closure_error),
            self.index_count.eq(closure.index_count),
            self.shortest_edge_spacing.eq(spacing.shortest),
            self.homed.eq(delayed(m, homed, LATENCY_CLOCKS - ANGLE_READY, name="homed_out")),
        ]
        illegal_start = LATENCY_CLOCKS - IllegalSteps.CLOCKS
        m.d.comb += [
            illegal.illegal.eq(delayed(m, quadrature.illegal, illegal_start - QUADRATURE_CLOCKS, name="illegal")),
            illegal.position.eq(self.raw_position),
            illegal.time.eq(time.words << sample_bits),
            self.illegal_steps.eq(illegal.count),
            self.first_illegal_position.eq(illegal.first_position),
            self.first_illegal_time.eq(illegal.first_time),
        ]

        # Flags: every cause meets its word's position a clock before the outputs.
        cause_ready = LATENCY_CLOCKS - 1
        any_step = (quadrature.forward | quadrature.reverse).any()
        reversing = Signal()
        for i in range(samples):
            with m.If(quadrature.forward[i] | quadrature.reverse[i]):
                m.d.comb += reversing.eq(quadrature.reverse[i])
        direction = Signal()
        with m.If(any_step):
            m.d.sync += direction.eq(reversing)

        def cause(flag, value, ready):
            raised = delayed(m, value, cause_ready - ready, name=f"cause_{flag.name.lower()}")
            return flag_register.raised[flag.bit_length() - 1].eq(raised)

        m.d.comb += [
            cause(Flag.LAST_DIRECTION_REVERSE, direction, QUADRATURE_CLOCKS + 1),
            cause(Flag.CORRECTION_ACTIVE, correction.active, CORRECTION_READY),
            cause(Flag.EDGE_SPACING_LIMIT, spacing.at_limit, QUADRATURE_CLOCKS + EDGE_SPACING_CLOCKS),
            cause(Flag.ROM_FAULT, rom_check.fault, ANGLE_READY),
            cause(Flag.CAPTURE_OVERRUN, strobe.refused, STROBE_REFUSED_CLOCKS),
            cause(Flag.INDEX_FAULT, closure.index_fault, cause_ready),
            cause(Flag.CLOSURE_ERROR, closure.closure_fault, cause_ready),
            cause(Flag.ILLEGAL_STEP, quadrature.illegal.any(), QUADRATURE_CLOCKS),
            flag_register.clear.eq(spi.clear_flags),
            self.flags.eq(flag_register.flags),
        ]

        m.d.comb += [
            spi.sck.eq(self.spi_sck),
            spi.cs_n.eq(self.spi_cs_n),
            spi.copi.eq(self.spi_copi),
            self.spi_cipo.eq(spi.cipo),
            spi.angle.eq(self.position[:ANGLE_BITS]),
            spi.turns.eq(self.position[ANGLE_BITS:]),
            spi.homed.eq(self.homed),
            spi.flags.eq(self.flags),
        ]
        return m
