"""Square waves of a turning encoder, made in the FPGA sample by sample: A, B, Z and a strobe.

A rate accumulator tells how many counts each sample is further on than the word's start; the angle at the word's
start and those counts give the quadrature state and the zero pulse of every sample, through a pipeline that keeps to
the word clock. `square_wave_golden` is the same in numpy.
"""

from amaranth.hdl import Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from arcref.angle import ANGLE_BITS
from arcref_gateware.register_stages import delayed

FAULTS = ("dropped_edge", "doubled_step", "missing_index")
"""Faults that the generator can inject, each once.

`dropped_edge`: A stays low for one period of it; no step is illegal, but four counts are lost. `doubled_step`: two
counts at once, an illegal step. `missing_index`: no zero pulse throughout the second leg.
"""

RATE_BITS = 16
"""The generator's rate is a whole number of 2 ** -16 counts a sample."""

LEG_WORDS = 256
"""A leg is a multiple of so many words."""

START_COUNT = -4096
"""Angle at the start, two grating lines before the zero mark: the core is homed soon, and every way back passes the
zero mark by more than the line that a missing index needs to show."""

FAULT_PERIOD = 16
"""The period of A, counted from the zero mark, in which a fault of A and B is injected, in the first leg."""

GENERATOR_CLOCKS = 5
"""Words after reset that show the start, A and B low, before the first one of the motion."""

PERIODS_BITS = ANGLE_BITS - 2


class SquareWaveGenerator(wiring.Component):
    """Sample words of an encoder that turns forward for a leg, back for a leg, and so on.

    `rate` is in 2 ** -16 counts a sample (1 .. 65536), `legs` the length of a leg in `LEG_WORDS` words, `fault` one
    of `FAULTS` or None.
    """

    def __init__(self, samples_per_word: int, rate: int, legs: int, fault: str | None = None):
        if not 1 <= rate <= 1 << RATE_BITS:
            raise ValueError(f"the rate lies in 1 .. {1 << RATE_BITS}, not {rate!r}")
        if legs < 1:
            raise ValueError(f"a leg is 1 and more, not {legs!r}")
        self.samples_per_word = samples_per_word
        self.rate = rate
        self.legs = legs
        self.fault = fault
        super().__init__({name: Out(samples_per_word) for name in ("a", "b", "z", "strobe")})

    a: Out
    """Samples of A, bit 0 the oldest."""
    b: Out
    """Samples of B, bit 0 the oldest."""
    z: Out
    """Samples of the zero pulse: one period of A, four counts wide."""
    strobe: Out
    """Samples of the strobe: one sample high every `LEG_WORDS` words, each time the next one in the word."""

    def elaborate(self, platform):
        m = Module()
        samples = self.samples_per_word

        # Direction: legs of LEG_WORDS words are counted down.
        words = Signal(range(LEG_WORDS))
        next_leg = Signal()
        legs_left = Signal(range(self.legs + 1), init=self.legs - 1)
        reverse = Signal()
        leg = Signal(2)  # the third and later are all 2
        last_part = Signal()
        m.d.sync += [words.eq(words + 1), next_leg.eq(words == LEG_WORDS - 2), last_part.eq(legs_left == 0)]
        with m.If(next_leg):
            m.d.sync += legs_left.eq(legs_left - 1)
            with m.If(last_part):
                m.d.sync += [legs_left.eq(self.legs - 1), reverse.eq(~reverse)]
                with m.If(leg != 2):
                    m.d.sync += leg.eq(leg + 1)

        # Stage 1: counts that each sample is on from the word's start.
        fraction = Signal(RATE_BITS)
        steps = [Signal(3, name=f"steps_{k}") for k in range(samples)]
        reverse_1 = delayed(m, reverse, 1, name="reverse")
        marker = Signal(samples, init=1)
        marked = Signal(samples)
        m.d.sync += marked.eq(0)
        with m.If(next_leg):
            m.d.sync += [marked.eq(marker), marker.eq(marker.rotate_left(1))]
        for k in range(samples):
            total = Signal(RATE_BITS + 3, name=f"total_{k}")
            m.d.comb += total.eq(fraction + self.rate * (k + 1))
            m.d.sync += steps[k].eq(total[RATE_BITS:])
            if k == samples - 1:
                m.d.sync += fraction.eq(total[:RATE_BITS])

        # Stage 2: the way from the word's start to each sample.
        ways = [Signal(signed(4), name=f"way_{k}") for k in range(samples)]
        for k in range(samples):
            m.d.sync += ways[k].eq(Mux(reverse_1, -steps[k], steps[k]))

        # Stage 3: the angle at the word's start.
        angle = Signal(ANGLE_BITS, init=START_COUNT % (1 << ANGLE_BITS))
        low = Signal(2)
        period = Signal(PERIODS_BITS, init=(START_COUNT >> 2) % (1 << PERIODS_BITS))
        m.d.sync += [angle.eq(angle + ways[-1]), low.eq(angle[:2]), period.eq(angle[2:])]
        ways = [delayed(m, way, 1, name=f"way_{k}") for k, way in enumerate(ways)]

        # Stage 4: state of each sample, and whether its period is the one before, the same or the one after.
        at_zero = self._near(m, period, 0, "zero")
        at_fault = self._near(m, period, FAULT_PERIOD, "fault")
        states = [Signal(2, name=f"state_{k}") for k in range(samples)]
        periods_on = [Signal(signed(2), name=f"period_on_{k}") for k in range(samples)]
        leg_of_word = delayed(m, leg, GENERATOR_CLOCKS - 1, name="leg")
        for k in range(samples):
            place = Signal(signed(5), name=f"place_{k}")
            m.d.comb += place.eq(low + ways[k])
            m.d.sync += [states[k].eq(place[:2]), periods_on[k].eq(place[2:4])]

        # Stage 5: the lines, with their fault.
        m.d.comb += self.strobe.eq(delayed(m, marked, GENERATOR_CLOCKS - 1, name="strobe"))
        for k, (state, on) in enumerate(zip(states, periods_on, strict=True)):
            a, b = state[0] ^ state[1], state[1]
            z = self._chosen(at_zero, on)
            due = self._chosen(at_fault, on) & (leg_of_word == 0)
            if self.fault == "dropped_edge":
                a = a & ~due
            elif self.fault == "doubled_step":
                a = a & ~(due & (state == 1))
            elif self.fault == "missing_index":
                z = z & (leg_of_word != 1)
            m.d.sync += [self.a[k].eq(a), self.b[k].eq(b), self.z[k].eq(z)]
        return m

    @staticmethod
    def _near(m, period, wanted: int, name: str) -> list[Signal]:
        """Registers that tell whether period + on is the wanted one, for on = 0, 1 and -1."""
        near = [Signal(name=f"{name}_{k}") for k in range(3)]
        for flag, on in zip(near, (0, 1, -1), strict=True):
            m.d.sync += flag.eq(period == Const((wanted - on) % (1 << PERIODS_BITS), PERIODS_BITS))
        return near

    @staticmethod
    def _chosen(near: list[Signal], on) -> Signal:
        return Mux(on[1], near[2], Mux(on[0], near[1], near[0]))
