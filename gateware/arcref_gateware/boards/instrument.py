"""The instrument behind the samplers: alignment check, self-test generator, core and LEDs.

All of a board but its pads and clocks, so that it can be simulated whole.
"""

from amaranth.hdl import Cat, DomainRenamer, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.correction_rom import CorrectionRom
from arcref.flags import FAULT_FLAGS
from arcref.link.packet import DEFAULT_BAUD
from arcref_gateware.boards.alignment_check import AlignmentCheck, AlignmentPattern
from arcref_gateware.boards.board import SAMPLED_SIGNALS
from arcref_gateware.boards.self_test_course import SelfTestCourse
from arcref_gateware.boards.square_wave_generator import SquareWaveGenerator
from arcref_gateware.connected_encoder import CAPTURE_DEPTH, ConnectedEncoder
from arcref_gateware.reference_encoder import ReferenceEncoder

HEARTBEAT_HZ = 1.0
"""About how often the heartbeat LED blinks: a power of two of word clocks, so between 0.5 and 1 times a second."""

LINKED_STROBE_WORDS = 1 << 15
"""Words from strobe to strobe of the test generator on a board with a link: 6104 a second at 200 MHz, which the UART
streams, and none is refused at any strobe delay."""

UNREAD_OUTPUTS = (
    "raw_position",
    "illegal_steps",
    "closure_error",
    "largest_closure_error",
    "index_count",
    "capture_valid",
    "capture_position",
    "capture_raw",
    "capture_time",
    "shortest_edge_spacing",
    "first_illegal_position",
    "first_illegal_time",
)
"""Outputs of the core that are read through no pin of a board without a link."""


class Instrument(wiring.Component):
    """Core with everything around it, over sample words.

    `pattern` is what the alignment pad sends, None where no check is needed (one sample a word).
    `self_test`, a `SelfTest`, puts a test generator in place of the samples; with the link its registers choose between
    the two. `has_link` puts registers, UART, captures and compare output around the core, with `baud` and
    `capture_depth` of `ConnectedEncoder`. Uses the domains of `word_domains`; `hold` must drive the reset of `sync`.
    """

    def __init__(
        self,
        rom: CorrectionRom | None,
        samples_per_word: int,
        word_clock_hz: float,
        *,
        pattern: AlignmentPattern | None = None,
        self_test=None,
        strobe_delay: int = 0,
        has_link: bool = False,
        baud: float = DEFAULT_BAUD,
        capture_depth: int = CAPTURE_DEPTH,
    ):
        self.samples_per_word = samples_per_word
        self.word_clock_hz = word_clock_hz
        self.pattern = pattern
        self.self_test = self_test
        self.has_link = has_link
        if has_link:
            self.core = ConnectedEncoder(
                rom,
                samples_per_word,
                strobe_delay=strobe_delay,
                word_clock_hz=word_clock_hz,
                baud=baud,
                capture_depth=capture_depth,
                has_test_generator=self_test is not None,
                settings=self_test and self_test.settings(samples_per_word * word_clock_hz),
            )
        else:
            self.core = ReferenceEncoder(rom, samples_per_word, strobe_delay=strobe_delay)
        super().__init__(
            {
                **{name: In(samples_per_word) for name in SAMPLED_SIGNALS},
                "alignment": In(samples_per_word),
                "alignment_drive": Out(1),
                "hold": Out(1),
                "spi_sck": In(1),
                "spi_cs_n": In(1, init=1),
                "spi_copi": In(1),
                "spi_cipo": Out(1),
                "uart_rx": In(1, init=1),
                "uart_tx": Out(1, init=1),
                "compare": Out(1),
                "led_homed": Out(1),
                "led_fault": Out(1),
                "led_heartbeat": Out(1),
            }
        )

    a: In
    """Samples of A, bit 0 the oldest."""
    b: In
    """Samples of B, bit 0 the oldest."""
    z: In
    """Samples of the zero pulse, bit 0 the oldest."""
    strobe: In
    """Samples of the strobe, bit 0 the oldest."""
    alignment: In
    """Samples of the alignment pad, bit 0 the oldest."""
    alignment_drive: Out
    """1 while the alignment pattern must go out."""
    hold: Out
    """Reset of the domain `sync`. Where alignment is checked it comes from the second clock on: at power-up an iCE40's
    registers are 0, and a 1 there would put an inverter in the way of the widest net."""
    spi_sck: In
    """SPI clock."""
    spi_cs_n: In
    """SPI chip select, active low."""
    spi_copi: In
    """SPI data from the controller."""
    spi_cipo: Out
    """SPI data to the controller."""
    uart_rx: In
    """UART from the host."""
    uart_tx: Out
    """UART to the host; 1 without the link."""
    compare: Out
    """The compare output; 0 without the link."""
    led_homed: Out
    """1 once the first zero mark has set the zero."""
    led_fault: Out
    """1 while a fault flag is up, or when the alignment check has failed."""
    led_heartbeat: Out
    """Blinks as long as the word clock runs, also while the core is held."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.core = core = self.core
        failed = Signal()
        if self.pattern is None:
            hold = Signal(init=1)
            m.d.word += hold.eq(0)
        else:
            hold = Signal(reset_less=True)
            check = AlignmentCheck(self.samples_per_word, self.pattern)
            m.submodules.alignment_check = DomainRenamer("word")(check)
            m.d.comb += [
                check.word.eq(self.alignment),
                self.alignment_drive.eq(check.drive),
                failed.eq(check.failed),
            ]
            m.d.word += hold.eq(~check.passed)
        m.d.comb += self.hold.eq(hold)

        self._bring_samples(m)
        m.d.comb += [
            core.spi_sck.eq(self.spi_sck),
            core.spi_cs_n.eq(self.spi_cs_n),
            core.spi_copi.eq(self.spi_copi),
            self.spi_cipo.eq(core.spi_cipo),
        ]
        if self.has_link:
            m.d.comb += [
                core.uart_rx.eq(self.uart_rx),
                self.uart_tx.eq(core.uart_tx),
                self.compare.eq(core.compare),
            ]
        else:
            # What no pin shows stays in the design, so that its figures are those of the whole core.
            unread = Cat(getattr(core, name) for name in UNREAD_OUTPUTS)
            observed = Signal(len(unread), reset_less=True, attrs={"keep": "true"})
            m.d.sync += observed.eq(unread)

        # The counter of the heartbeat in two halves, so that its carry chain does not limit the word clock.
        beat_bits = int(self.word_clock_hz / HEARTBEAT_HZ).bit_length()
        words = Signal(beat_bits // 2, reset_less=True)
        beat = Signal(beat_bits - len(words), reset_less=True)
        carry = Signal(reset_less=True)
        fault = Signal(reset_less=True)  # a register between the core and the LED's pad, which lie far apart
        # What the LEDs show needs no reset, and the reset need not be brought to their pads.
        leds = {name: Signal(reset_less=True, name=name) for name in ("led_heartbeat", "led_homed", "led_fault")}
        m.d.comb += [getattr(self, name).eq(led) for name, led in leds.items()]
        m.d.word += [
            words.eq(words + 1),
            carry.eq(words.all()),
            beat.eq(beat + carry),
            leds["led_heartbeat"].eq(beat[-1]),
            leds["led_homed"].eq(core.homed),
            fault.eq((core.flags & FAULT_FLAGS.value).any() | failed),
            leds["led_fault"].eq(fault),
        ]
        return m

    def _bring_samples(self, m: Module) -> None:
        """The core's samples: those of the pins, or the test generator's."""
        core, self_test = self.core, self.self_test
        if self_test is None:
            m.d.comb += [getattr(core, name).eq(getattr(self, name)) for name in SAMPLED_SIGNALS]
            return
        samples_per_s = self.samples_per_word * self.word_clock_hz
        if not self.has_link:
            m.submodules.generator = generator = SquareWaveGenerator(self.samples_per_word)
            legs = self_test.legs(self.samples_per_word, samples_per_s)
            m.submodules.course = course = SelfTestCourse(legs, self_test.fault)
            m.d.comb += [
                generator.run.eq(1),
                generator.rate.eq(self_test.rate(samples_per_s)),
                generator.reverse.eq(course.reverse),
                generator.fault.eq(course.fault),
            ]
            m.d.comb += [getattr(core, name).eq(getattr(generator, name)) for name in SAMPLED_SIGNALS]
            return
        m.submodules.generator = generator = SquareWaveGenerator(self.samples_per_word, LINKED_STROBE_WORDS)
        generates = Signal()
        m.d.sync += generates.eq(generator.run)
        m.d.comb += [
            Cat(generator.run, generator.reverse, generator.fault).eq(core.generator_control),
            generator.rate.eq(core.generator_rate[-len(generator.rate) :]),
        ]
        for name in SAMPLED_SIGNALS:
            chosen = Signal(self.samples_per_word, name=f"chosen_{name}")
            m.d.sync += chosen.eq(Mux(generates, getattr(generator, name), getattr(self, name)))
            m.d.comb += getattr(core, name).eq(chosen)
