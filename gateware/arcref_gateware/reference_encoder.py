"""The core: from sample words to a corrected angle, with everything that watches over it.

Every output shows, `LATENCY_CLOCKS` clocks later, the state after the last sample of a word. When each stage is ready
stands in `arcref_gateware.latency`.
"""

from amaranth.hdl import Cat, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, connect, flipped
from amaranth.utils import exact_log2

from arcref.angle import ANGLE_BITS, POSITION_BITS
from arcref.correction_rom import CorrectionRom
from arcref_gateware.capture import Capture, corrected_position
from arcref_gateware.closure_check import CLOSURE_BITS
from arcref_gateware.correction import Correction
from arcref_gateware.delay_line import DelayLine
from arcref_gateware.edge_spacing import SPACING_BITS
from arcref_gateware.index_detector import IndexDetector
from arcref_gateware.latency import (
    ADVANCE_READY,
    ANGLE_READY,
    CORRECTION_READY,
    LATENCY_CLOCKS,
    POSITION_READY,
    STEPS_READY,
    WAY_BACK_READY,
)
from arcref_gateware.partial_sums import PartialSums, value_at
from arcref_gateware.position import PositionAccumulator
from arcref_gateware.position_spi import PositionSpi
from arcref_gateware.quadrature import DEFAULT_GATE_STATE, Quadrature, check_samples_per_word
from arcref_gateware.register_stages import delayed
from arcref_gateware.rom_check import RomCheck
from arcref_gateware.spi_registers import SpiRegisters
from arcref_gateware.strobe_delay import STROBE_CLOCKS, STROBE_DELAY_BITS, StrobeDelay
from arcref_gateware.table_access import TableAccess
from arcref_gateware.table_contents import placeholder_contents, rom_contents
from arcref_gateware.time_counter import TimeCounter
from arcref_gateware.watch import Watch


class ReferenceEncoder(wiring.Component):
    """The core of the instrument, pure logic over sample words.

    Parameters: `rom`, the correction, or None for the placeholder contents of a bitstream that gets its ROM later;
    `samples_per_word` (1, 2 or 4); `gate_state`, the reset value of the (A, B) of the zero mark; `strobe_delay`, that
    of the delay in sample periods (0..65535). Raises ValueError for others.
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
        self.gate_state_init, self.strobe_delay_init = gate_state, strobe_delay
        super().__init__(
            {
                "a": In(samples_per_word),
                "b": In(samples_per_word),
                "z": In(samples_per_word),
                "strobe": In(samples_per_word),
                "strobe_delay": In(STROBE_DELAY_BITS, init=strobe_delay),
                "gate_state": In(2, init=gate_state[0] | gate_state[1] << 1),
                "rehome": In(1),
                "correction_enable": In(1, init=1),
                "clear_flags": In(8),
                "tables": In(TableAccess()),
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
                "causes": Out(8),
                "index": Out(1),
                "words": Out(POSITION_BITS),
                "spi_registers": Out(SpiRegisters()),
                "chip_select": Out(1),
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
    gate_state: In
    """Levels of A (bit 0) and B (bit 1) at the zero mark."""
    rehome: In
    """1 for one clock: the next index sets the zero again."""
    correction_enable: In
    """1 to correct, 0 for positions as counted."""
    clear_flags: In
    """Bit n: clear flag n, for one clock."""
    tables: In
    """How trial tables are loaded, and the identity is read."""
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
    """Shortest spacing of two edges of A and B, in sample periods; 4095 for none."""
    first_illegal_position: Out
    """Raw position after the word of the first illegal step. One clock after `illegal_steps`."""
    first_illegal_time: Out
    """First sample of that word, in sample periods since reset."""
    causes: Out
    """Bit n: the cause of flag n was there in the word; with `flags`."""
    index: Out
    """1 with each word in which an index was met, as soon as it is known."""
    words: Out
    """Number of the word that the outputs show, since reset."""
    spi_registers: Out
    """What SPI command frames ask of the registers."""
    chip_select: Out
    """1 while chip select is active, synchronised."""
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

        m.submodules.quadrature = quadrature = Quadrature(samples, self.gate_state_init)
        m.submodules.index_detector = index_detector = IndexDetector(samples)
        m.submodules.partial_sums = sums = PartialSums(samples)
        m.submodules.position = position = PositionAccumulator()
        m.submodules.strobe_delay = strobe = StrobeDelay(samples)
        m.submodules.correction = correction = Correction(self.contents.line, self.contents.subdivision)
        m.submodules.capture = capture = Capture(samples)
        m.submodules.rom_check = rom_check = RomCheck(self.contents.identity)
        m.submodules.watch = watch = Watch(samples)
        m.submodules.time_counter = time = TimeCounter()
        m.submodules.spi = spi = PositionSpi()

        # Steps, index and strobe of a word, and the position after it and at the strobe's due sample.
        event_way_back = Signal(signed(3))
        m.d.sync += event_way_back.eq(
            value_at(sums.way_back, delayed(m, strobe.due_sample, WAY_BACK_READY - STROBE_CLOCKS, name="due_sample"))
        )
        m.d.comb += [
            quadrature.a.eq(self.a),
            quadrature.b.eq(self.b),
            quadrature.z.eq(self.z),
            strobe.strobe.eq(self.strobe),
            strobe.delay.eq(self.strobe_delay),
            quadrature.gate_state.eq(self.gate_state),
            index_detector.gate.eq(quadrature.gate),
            index_detector.rehome.eq(self.rehome),
            sums.forward.eq(quadrature.forward),
            sums.reverse.eq(quadrature.reverse),
            sums.index_sample.eq(index_detector.index_sample),
            sums.home.eq(index_detector.home),
            position.advance.eq(sums.advance),
            position.home.eq(delayed(m, index_detector.home, ADVANCE_READY - WAY_BACK_READY, name="home")),
            position.event_way_back.eq(
                delayed(m, event_way_back, POSITION_READY - WAY_BACK_READY - 1, name="event_way_back")
            ),
        ]

        # What the tables say of both, and the power-up check of the tables. The check's verdict takes effect in its
        # own clock; what is set by registers, a clock later.
        may_correct, usable = Signal(init=1), Signal()
        m.d.sync += may_correct.eq(self.correction_enable & ~self.tables.hold)
        m.d.comb += usable.eq(rom_check.good & may_correct)
        m.d.comb += [
            correction.angle.eq(position.angle),
            correction.event_angle.eq(position.event_angle),
            correction.event.eq(delayed(m, strobe.due, ANGLE_READY - STROBE_CLOCKS, name="event")),
            correction.homed.eq(delayed(m, index_detector.homed, ANGLE_READY - WAY_BACK_READY, name="homed")),
            correction.usable.eq(usable),
            correction.check_enable.eq(rom_check.busy | self.tables.loading),
            correction.check_address.eq(
                Mux(rom_check.busy, rom_check.address, Cat(self.tables.address[:9], self.tables.address))
            ),
            correction.write_line.eq(self.tables.write_line),
            correction.write_subdivision.eq(self.tables.write_subdivision),
            correction.write_word.eq(self.tables.write_word),
            rom_check.restart.eq(self.tables.check),
            rom_check.identity_address.eq(self.tables.address),
            rom_check.write_identity.eq(self.tables.write_identity),
            rom_check.write_word.eq(self.tables.write_word),
            self.tables.identity_word.eq(rom_check.identity_word),
            self.tables.crc32.eq(rom_check.table_crc32),
            self.tables.checking.eq(rom_check.busy),
            self.tables.good.eq(rom_check.good),
            rom_check.line_word.eq(correction.line_word),
            rom_check.subdivision_word.eq(correction.subdivision_word),
        ]

        # The positions wait for their corrections.
        m.submodules.waiting = waiting = DelayLine(POSITION_BITS, CORRECTION_READY - POSITION_READY - 1)
        raw = delayed(m, waiting.delayed, 1, name="raw")
        raw_out, corrected = corrected_position(m, raw, correction.word_complement, correction.active, name="position")
        due_place = Signal(exact_log2(samples))
        for i in range(samples):
            with m.If(strobe.due_sample[i]):
                m.d.comb += due_place.eq(i)
        m.d.comb += [
            self.raw_position.eq(raw_out),
            self.position.eq(corrected),
            time.valid.eq(delayed(m, quadrature.valid, LATENCY_CLOCKS - STEPS_READY, name="time_valid")),
            capture.event.eq(delayed(m, strobe.due, CORRECTION_READY - 1 - STROBE_CLOCKS, name="capture_event")),
            capture.sample.eq(delayed(m, due_place, CORRECTION_READY - 1 - STROBE_CLOCKS, name="due_place")),
            waiting.value.eq(position.position),
            capture.position.eq(waiting.delayed),
            capture.way_back.eq(
                delayed(m, event_way_back, CORRECTION_READY - WAY_BACK_READY - 2, name="capture_way_back")
            ),
            capture.complement.eq(correction.event_complement),
            capture.active.eq(correction.active),
            capture.words.eq(time.words),
            self.capture_valid.eq(capture.valid),
            self.capture_position.eq(capture.corrected),
            self.capture_raw.eq(capture.raw),
            self.capture_time.eq(capture.time),
        ]

        m.d.comb += [
            watch.forward.eq(quadrature.forward),
            watch.reverse.eq(quadrature.reverse),
            watch.illegal.eq(quadrature.illegal),
            watch.homed.eq(index_detector.homed),
            watch.index.eq(index_detector.index),
            watch.home.eq(index_detector.home),
            watch.index_way_back.eq(sums.index_way_back),
            watch.angle.eq(position.angle),
            watch.correction_active.eq(correction.active),
            watch.strobe_refused.eq(strobe.refused),
            watch.rom_fault.eq(rom_check.fault),
            watch.raw_position.eq(self.raw_position),
            watch.words.eq(time.words),
            watch.clear.eq(spi.clear_flags | self.clear_flags),
            self.causes.eq(watch.causes),
            self.words.eq(time.words),
            self.index.eq(index_detector.index),
            self.homed.eq(watch.homed_out),
            self.illegal_steps.eq(watch.illegal_steps),
            self.closure_error.eq(watch.closure_error),
            self.largest_closure_error.eq(watch.largest_closure_error),
            self.index_count.eq(watch.index_count),
            self.shortest_edge_spacing.eq(watch.shortest_edge_spacing),
            self.first_illegal_position.eq(watch.first_illegal_position),
            self.first_illegal_time.eq(watch.first_illegal_time),
            self.flags.eq(watch.flags),
        ]

        connect(m, spi.registers, flipped(self.spi_registers))
        m.d.comb += [
            spi.sck.eq(self.spi_sck),
            spi.cs_n.eq(self.spi_cs_n),
            spi.copi.eq(self.spi_copi),
            self.spi_cipo.eq(spi.cipo),
            self.chip_select.eq(spi.chip_select),
            spi.angle.eq(self.position[:ANGLE_BITS]),
            spi.turns.eq(self.position[ANGLE_BITS:]),
            spi.homed.eq(self.homed),
            spi.flags.eq(self.flags),
        ]
        return m
