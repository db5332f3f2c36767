"""Where strobes come from: the pin, a timer, chip select or a command; and which edge of a line counts."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.registers import REGISTERS, STROBE_EDGES, STROBE_SOURCES

PIN, TIMER, CHIP_SELECT, COMMAND = range(len(STROBE_SOURCES))
RISING, FALLING, BOTH = range(len(STROBE_EDGES))

SOURCE_FIELD, EDGE_FIELD = REGISTERS["strobe_control"].fields

_HALF = 16


class StrobeSource(wiring.Component):
    """Samples whose rising edges are the strobes. The pin's samples go through without a clock's delay.

    Chip select is seen once a word, so a strobe of it is placed to the word; timer and command mark the first sample
    of a word. With both edges of the pin, two edges that follow one another within two samples count as one.
    """

    def __init__(self, samples_per_word: int):
        self.samples_per_word = samples_per_word
        super().__init__(
            {
                "pin": In(samples_per_word),
                "chip_select": In(1),
                "control": In(REGISTERS["strobe_control"].width),
                "period": In(REGISTERS["strobe_period"].width),
                "command": In(1),
                "strobe": Out(samples_per_word),
            }
        )

    pin: In
    """Samples of the pin, bit 0 the oldest."""
    chip_select: In
    """1 while chip select is active, synchronised."""
    control: In
    """The register `strobe_control`."""
    period: In
    """Period of the timer, in word clocks; 0 and 1 stop it."""
    command: In
    """1 for one clock: a strobe."""
    strobe: Out
    """Samples whose rising edges are strobes, bit 0 the oldest."""

    def elaborate(self, platform):
        m = Module()
        source, edge = (self.control[f.low : f.low + f.width] for f in (SOURCE_FIELD, EDGE_FIELD))
        uses = Signal(len(STROBE_SOURCES), reset_less=True)
        invert, both = Signal(), Signal()
        m.d.sync += [
            uses.eq(1 << source),
            invert.eq(edge == FALLING),
            both.eq(edge == BOTH),
        ]

        # The timer runs down in two halves: only the lower one changes at every clock. What happens with a clock is
        # known in the one before. The register's two words may come apart, but a timer that runs reads both at its
        # next turn alone.
        low, high = Signal(_HALF), Signal(_HALF)
        runs, reloads, wraps, no_more = Signal(), Signal(init=1), Signal(), Signal()
        tick = Signal()
        period_low, period_high = self.period[:_HALF], self.period[_HALF:]
        m.d.sync += [
            runs.eq(self.period[1:].any() & uses[TIMER]),
            reloads.eq(~runs | ((low == 2) & no_more & ~reloads)),
            wraps.eq(Mux(reloads, period_low == 0, low == 1)),
            no_more.eq(Mux(reloads, period_high == 0, high == 0)),
            low.eq(Mux(reloads, period_low, low - 1)),
            high.eq(Mux(reloads, period_high, high + wraps.replicate(_HALF))),
            tick.eq(reloads & runs),
        ]

        # An edge of chip select is a pulse of one word, as those of the timer and of the command are.
        last_select, selected, other = Signal(), Signal(), Signal()
        m.d.sync += [
            last_select.eq(self.chip_select),
            selected.eq((self.chip_select ^ last_select) & (both | (self.chip_select ^ invert))),
            other.eq((tick & uses[TIMER]) | (selected & uses[CHIP_SELECT]) | (self.command & uses[COMMAND])),
        ]
        last_pin = Signal()
        m.d.sync += last_pin.eq(self.pin[-1])
        for i in range(self.samples_per_word):
            before = self.pin[i - 1] if i else last_pin
            reference = Mux(both, before, invert)
            line = (self.pin[i] ^ reference) & uses[PIN]
            m.d.comb += self.strobe[i].eq(line if i else line | other)
        return m
