"""Quadrature decoding: what each sample of a word did to the count.

A step is decided from two neighbouring samples alone. When both lines changed there is no direction to be had, so
nothing is counted and the step is called illegal; no direction is remembered and guessed from.
"""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref_gateware.register_stages import delayed

SAMPLES_PER_WORD = (1, 2, 4)
"""Word sizes: 1 plain, 2 with DDR inputs, 4 with ECP5 gearing."""

QUADRATURE_CLOCKS = 2
"""Clocks from a sample word to its steps."""

DEFAULT_GATE_STATE = (1, 1)
"""The state of (A, B) in which a high Z is the index."""


def check_samples_per_word(samples_per_word: int) -> None:
    """Raises ValueError for a word size that no input gives."""
    if samples_per_word not in SAMPLES_PER_WORD:
        raise ValueError(f"samples per word must be one of {SAMPLES_PER_WORD}, not {samples_per_word!r}")


class Quadrature(wiring.Component):
    """Steps of every sample of a word, `QUADRATURE_CLOCKS` clocks after the word.

    The first sample after reset sets the state and counts nothing.

    Parameters: `samples_per_word` (1, 2 or 4) and `gate_state`, the reset value of the pair (A, B) of the zero mark.
    """

    def __init__(self, samples_per_word: int, gate_state: tuple[int, int] = DEFAULT_GATE_STATE):
        check_samples_per_word(samples_per_word)
        self.samples_per_word = samples_per_word
        self._gate_init = gate_state
        super().__init__(
            {
                "a": In(samples_per_word),
                "b": In(samples_per_word),
                "z": In(samples_per_word),
                "gate_state": In(2, init=gate_state[0] | gate_state[1] << 1),
                "forward": Out(samples_per_word),
                "reverse": Out(samples_per_word),
                "illegal": Out(samples_per_word),
                "gate": Out(samples_per_word),
                "valid": Out(1),
            }
        )

    a: In
    """Samples of A, bit 0 the oldest."""
    b: In
    """Samples of B, bit 0 the oldest."""
    z: In
    """Samples of Z, bit 0 the oldest."""
    gate_state: In
    """Levels of A (bit 0) and B (bit 1) at the zero mark."""
    forward: Out
    """Bit i: sample i is one count further than the sample before it."""
    reverse: Out
    """Bit i: sample i is one count back from the sample before it."""
    illegal: Out
    """Bit i: both lines changed between the sample before and sample i."""
    gate: Out
    """Bit i: at sample i, Z is high and (A, B) is the gate state."""
    valid: Out
    """1 from the first word after reset on."""

    def elaborate(self, platform):
        m = Module()
        width = self.samples_per_word
        a, b, z = (delayed(m, getattr(self, line), 1, name=line) for line in "abz")
        word_valid = Signal()
        earlier_valid = Signal()
        last_a, last_b = Signal(), Signal()
        m.d.sync += [word_valid.eq(1), earlier_valid.eq(word_valid), self.valid.eq(word_valid)]
        m.d.sync += [last_a.eq(a[-1]), last_b.eq(b[-1])]

        before_a, before_b = Cat(last_a, a)[:width], Cat(last_b, b)[:width]
        changed_a, changed_b = Signal(width), Signal(width)
        leads = Signal(width)
        has_before = Signal(width)
        not_gate_a, not_gate_b = Signal(init=not self._gate_init[0]), Signal(init=not self._gate_init[1])
        m.d.sync += [not_gate_a.eq(~self.gate_state[0]), not_gate_b.eq(~self.gate_state[1])]
        m.d.comb += [
            changed_a.eq(a ^ before_a),
            changed_b.eq(b ^ before_b),
            # Of two neighbouring states the new A differs from the old B just when A leads.
            leads.eq(a ^ before_b),
            # Only the very first sample after reset has no sample before it.
            has_before.eq(Cat(earlier_valid, word_valid.replicate(width - 1))),
        ]
        counted = (changed_a ^ changed_b) & has_before
        m.d.sync += [
            self.forward.eq(counted & leads),
            self.reverse.eq(counted & ~leads),
            self.illegal.eq(changed_a & changed_b & has_before),
            self.gate.eq(
                z & (a ^ not_gate_a.replicate(width)) & (b ^ not_gate_b.replicate(width)) & word_valid.replicate(width)
            ),
        ]
        return m
