"""The course of the self-test of a board without a link: forward for a leg, back for a leg, and so on.

With a link the host turns the generator, by the registers `generator_control` and `generator_rate`.
"""

import numpy as np
from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from arcref.link.registers import GENERATOR_FAULTS

LEG_WORDS = 256
"""A leg is a multiple of so many words."""

FAULT_LEGS = {"dropped_edge": 0, "doubled_step": 0, "missing_index": 1, "wide_index": 1}
"""The leg in which each fault is made, and in no other."""

assert list(FAULT_LEGS) == list(GENERATOR_FAULTS)


class SelfTestCourse(wiring.Component):
    """What `SquareWaveGenerator` is to do word by word.

    `legs` is the length of a leg in `LEG_WORDS` words, `fault` one of `GENERATOR_FAULTS` or None.
    """

    def __init__(self, legs: int, fault: str | None = None):
        if legs < 1:
            raise ValueError(f"a leg is 1 and more, not {legs!r}")
        self.legs, self.fault_name = legs, fault
        super().__init__({"reverse": Out(1), "fault": Out(len(GENERATOR_FAULTS))})

    reverse: Out
    """1 on the way back."""
    fault: Out
    """The faults of this word, a bit for each of `GENERATOR_FAULTS`."""

    def elaborate(self, platform):
        m = Module()
        words = Signal(range(LEG_WORDS))
        next_leg, last_part = Signal(), Signal()
        legs_left = Signal(range(self.legs + 1), init=self.legs - 1)
        legs_then = Signal.like(legs_left)
        leg = Signal(2)  # the third and later are all 2
        # One less, in two halves a clock apart: there are `LEG_WORDS` clocks for it.
        half = (len(legs_left) + 1) // 2
        low, high = legs_left[:half], legs_left[half:]
        fewer_low, fewer_high = Signal.like(low), Signal.like(high)
        low_is_zero, high_is_zero = Signal(), Signal()
        m.d.sync += [
            words.eq(words + 1),
            next_leg.eq(words == LEG_WORDS - 2),
            low_is_zero.eq(low == 0),
            high_is_zero.eq(high == 0),
            last_part.eq(low_is_zero & high_is_zero),
            fewer_low.eq(low - 1),
            fewer_high.eq(high - low_is_zero),
            legs_then.eq(Mux(last_part, self.legs - 1, Cat(fewer_low, fewer_high))),
        ]
        with m.If(next_leg):
            m.d.sync += legs_left.eq(legs_then)
            with m.If(last_part):
                m.d.sync += self.reverse.eq(~self.reverse)
                with m.If(leg != 2):
                    m.d.sync += leg.eq(leg + 1)
        if self.fault_name is not None:
            bit = list(GENERATOR_FAULTS).index(self.fault_name)
            m.d.comb += self.fault[bit].eq(leg == FAULT_LEGS[self.fault_name])
        return m


def course_of_words(words: int, legs: int, fault: str | None = None) -> dict[str, np.ndarray]:
    """`reverse` and `fault` of the first `words` words, what `SelfTestCourse` asks for."""
    leg = np.arange(words) // (LEG_WORDS * legs)
    faults = np.zeros(words, np.int64)
    if fault is not None:
        faults[leg == FAULT_LEGS[fault]] = 1 << list(GENERATOR_FAULTS).index(fault)
    return {"reverse": leg % 2, "fault": faults}
