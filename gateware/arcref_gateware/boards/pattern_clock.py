"""The clock of the ECP5's alignment pattern: its edges must fall on every place in a sample word.

One clock of the pattern is VCO / d; with an output divider o of the edge (or word) clock it lasts 2 d / o samples. The
pattern is high for some of its clocks and low for others, q in all, so that its period of 2 q d / o samples brings the
rising edges to every place, and the falling ones too: a pad that rises and falls unequally fast moves the one against
the other. Multiples of the period fall on the denominator of q d / (2 o) places of a word of four, evenly spread.
"""

from math import gcd

CLOCK_SAMPLES = 7
"""A clock of the pattern lasts at least this many samples: longer than a word, so that one edge at most is in one."""


def pattern_clocks(output_divider: int) -> tuple[int, int]:
    """Clocks of the pattern in which it is high, and in which it is low."""
    return (1, 2) if output_divider % 3 else (2, 3)


def pattern_divider(output_divider: int) -> int:
    """The divider d for the output divider o of the PLL, 2 or more (the PLL's VCO runs as fast as it can)."""
    if output_divider < 2:
        raise ValueError(f"a VCO at {output_divider} times the output has no edges between the samples")
    clocks = sum(pattern_clocks(output_divider))
    divider = -(-CLOCK_SAMPLES * output_divider // 2)
    while 2 * output_divider // gcd(clocks * divider, 2 * output_divider) < 4:
        divider += 1
    return divider
