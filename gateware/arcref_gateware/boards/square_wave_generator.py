"""Square waves of a turning encoder, made in the FPGA sample by sample: A, B, Z and a strobe.

A rate accumulator tells how many counts each sample is further on than the word's start; the angle at the word's
start and those counts give the quadrature state and the zero pulse of every sample, through a pipeline that keeps to
the word clock. `square_wave_golden` is the same in numpy.
"""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.angle import ANGLE_BITS
from arcref.link.registers import GENERATOR_FAULTS, GENERATOR_RATE_STEP, REGISTERS
from arcref_gateware.register_stages import (
    aligned,
    delayed,
    pipeline_clocks,
    segment_bounds,
    skewed,
    skewed_add,
    sum_and_carry,
)

RATE_BITS = REGISTERS["generator_rate"].width - (GENERATOR_RATE_STEP.bit_length() - 1)
"""The generator's rate is a whole number of 2 ** -24 counts a sample."""

START_COUNT = -4096
"""Angle at the start, two grating lines before the zero mark: the core is homed soon, and every way back passes the
zero mark by more than the line that a missing index needs to show."""

FAULT_PERIOD = 16
"""The period of A, counted from the zero mark, in which a fault of A and B is injected."""

RATE_SEGMENT_BITS = 10
"""Carry chain of the rate's accumulator. Its last segment has room for the steps, too: see the assertion below."""

STEPS_CLOCKS = 2 + pipeline_clocks(RATE_BITS, RATE_SEGMENT_BITS)
"""Clocks from the rate of a word to the steps it gives each sample."""

GENERATOR_CLOCKS = STEPS_CLOCKS + pipeline_clocks(ANGLE_BITS) + 4
"""Clocks from what a word is asked to be to its samples. So many words after reset show the start, A and B low."""

PERIODS_BITS = ANGLE_BITS - 2

STEPS_BITS = 3
"""Bits of the steps within a word: at most one a sample, four samples."""

assert pipeline_clocks(RATE_BITS, RATE_SEGMENT_BITS) == pipeline_clocks(RATE_BITS + STEPS_BITS, RATE_SEGMENT_BITS)


class SquareWaveGenerator(wiring.Component):
    """Sample words of an encoder that turns as each word is asked to.

    A strobe comes every `strobe_words` words, a power of two.
    """

    def __init__(self, samples_per_word: int, strobe_words: int = 256):
        self.samples_per_word, self.strobe_words = samples_per_word, strobe_words
        super().__init__(
            {name: Out(samples_per_word) for name in ("a", "b", "z", "strobe")}
            | {
                "run": In(1),
                "reverse": In(1),
                "rate": In(RATE_BITS),
                "fault": In(len(GENERATOR_FAULTS)),
            }
        )

    a: Out
    """Samples of A, bit 0 the oldest."""
    b: Out
    """Samples of B, bit 0 the oldest."""
    z: Out
    """Samples of the zero pulse, bit 0 the oldest: one period of A, four counts wide."""
    strobe: Out
    """Samples of the strobe: one sample high every `strobe_words` words, each time the next one in the word."""
    run: In
    """0: this word stands still."""
    reverse: In
    """1: this word turns in reverse."""
    rate: In
    """Counts a sample in this word, in 2 ** -RATE_BITS."""
    fault: In
    """Faults that this word has where it comes to their place, a bit for each of `GENERATOR_FAULTS`."""

    def elaborate(self, platform):
        m = Module()
        steps = self._steps(m)

        # The way from the word's start to each sample.
        reverse = delayed(m, self.reverse, STEPS_CLOCKS, name="reverse")
        ways = [Signal(signed(STEPS_BITS + 1), name=f"way_{k}") for k in range(self.samples_per_word)]
        signed_steps = Array([*range(1 << STEPS_BITS), *range(0, -(1 << STEPS_BITS), -1)])
        m.d.sync += [way.eq(signed_steps[Cat(step, reverse)]) for way, step in zip(ways, steps, strict=True)]

        # The angle at the word's start, in segments, each a clock behind the one below it.
        segments, onward = [], ways[-1]
        for low, high in segment_bounds(ANGLE_BITS):
            segment = Signal(high - low, init=START_COUNT >> low & (1 << high - low) - 1, name=f"angle_{low}")
            total, carry = Signal(signed(high - low + 2), name=f"total_{low}"), Signal(signed(2), name=f"carry_{low}")
            m.d.comb += total.eq(segment + onward)
            m.d.sync += [segment.eq(total), carry.eq(total[high - low :])]
            segments.append(segment)
            onward = carry
        angle = aligned(m, segments, name="angle")
        ways = [delayed(m, way, len(segments) - 1, name=f"way_{k}") for k, way in enumerate(ways)]

        # State of each sample, and whether its period is the one before, the same or the one after.
        places = []
        for k, way in enumerate(ways):
            place = Signal(signed(STEPS_BITS + 2), name=f"place_{k}")
            m.d.comb += place.eq(angle[:2] + way)
            places.append(delayed(m, place[:4], 2, name=f"place_{k}"))
        nearby = {}
        for wanted in (0, 1, FAULT_PERIOD):
            for period in (wanted - 1, wanted, wanted + 1):
                if period not in nearby:
                    nearby[period] = self._is_period(m, angle[2:], period % (1 << PERIODS_BITS))

        # The lines, with their faults.
        dropped_edge, doubled_step, missing_index, wide_index = self.fault
        forward = ~self.reverse
        # Counts taken forward would be given back in reverse; without any zero pulse nothing would ever be homed.
        faults = Cat(dropped_edge & forward, doubled_step & forward, missing_index & self.reverse, wide_index)
        dropped_edge, doubled_step, missing_index, wide_index = delayed(m, faults, GENERATOR_CLOCKS - 1, name="fault")
        for k, place in enumerate(places):
            state, on = delayed(m, place[:2], 1, name=f"state_{k}"), place[2:]
            at_zero, after_zero, at_fault = (Signal(name=f"at_{name}_{k}") for name in ("zero", "one", "fault"))
            for here, wanted in ((at_zero, 0), (after_zero, 1), (at_fault, FAULT_PERIOD)):
                m.d.sync += here.eq(Mux(on[1], nearby[wanted + 1], Mux(on[0], nearby[wanted - 1], nearby[wanted])))
            a, b = state[0] ^ state[1], state[1]
            m.d.sync += [
                self.a[k].eq(a & ~(at_fault & (dropped_edge | (doubled_step & ~b)))),
                self.b[k].eq(b),
                self.z[k].eq((at_zero | (after_zero & wide_index)) & ~missing_index),
            ]
        self._strobe(m)
        return m

    def _steps(self, m: Module) -> list[Signal]:
        """Counts that each sample is on from the word's start, `STEPS_CLOCKS` after the word was asked for.

        The accumulator is cut into segments, each a clock behind the one below it.
        """
        rate = Signal(RATE_BITS + STEPS_BITS)
        m.d.sync += rate.eq(self.rate & self.run.replicate(RATE_BITS))
        later = delayed(m, rate, 1, name="rate")

        def segments_of(value, name: str):
            return skewed(m, value, name=name, segment_bits=RATE_SEGMENT_BITS)

        multiples = [segments_of(later, "rate1"), segments_of((later << 1)[: len(later)], "rate2")]
        if self.samples_per_word == 4:
            twice = (rate[:-1] << 1).as_signed()
            multiples.append(skewed_add(m, segments_of(rate, "rate3"), twice, name="rate3"))
            multiples.append(segments_of((later << 2)[: len(later)], "rate4"))
        fraction = [
            Signal(high - low, name=f"fraction_{low}") for low, high in segment_bounds(RATE_BITS, RATE_SEGMENT_BITS)
        ]
        steps = []
        for k, segments in enumerate(multiples[: self.samples_per_word]):
            carry = None
            for place, (part, segment) in enumerate(zip(fraction, segments, strict=True)):
                if part is fraction[-1]:
                    # One bit more at the low end makes the carry in part of the same carry chain.
                    total = (Cat(Const(1, 1), part) + Cat(carry, segment))[1 : 1 + len(segment)]
                else:
                    total = sum_and_carry(m, part, segment, carry)
                carry = Signal(len(total) - len(part), name=f"carry_{k}_{place}")
                m.d.sync += carry.eq(total[len(part) :])
                if k == self.samples_per_word - 1:
                    m.d.sync += part.eq(total)
            steps.append(carry)
        return steps

    def _strobe(self, m: Module) -> None:
        words = Signal(range(self.strobe_words))
        # The strobe of the last word of each round, in one sample of it, the next time in the next one.
        is_last = Signal()
        m.d.sync += [words.eq(words + 1), is_last.eq(words == self.strobe_words - 2)]
        marker, marked = Signal(self.samples_per_word, init=1), Signal(self.samples_per_word)
        m.d.sync += marked.eq(marker & is_last.replicate(self.samples_per_word))
        with m.If(is_last):
            m.d.sync += marker.eq(marker.rotate_left(1))
        m.d.comb += self.strobe.eq(delayed(m, marked, GENERATOR_CLOCKS - 1, name="strobe"))

    @staticmethod
    def _is_period(m: Module, period, wanted: int) -> Signal:
        """Two clocks later: whether the period of the word's start is the wanted one."""
        half = PERIODS_BITS // 2
        label = f"period_{wanted}"
        same = Signal(2, name=f"{label}_same")
        here = Signal(name=label)
        m.d.sync += [
            same.eq(Cat(period[:half] == wanted & (1 << half) - 1, period[half:] == wanted >> half)),
            here.eq(same.all()),
        ]
        return here
