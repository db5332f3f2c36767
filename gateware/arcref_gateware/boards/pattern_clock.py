"""The clock of the ECP5's alignment pattern: its edges must fall on every place in a sample word.

A half period of the pattern is one period of VCO / d. With an output divider o of the edge (or word) clock that is
2 d / o samples; when d has no factor in common with 2 o, the edges visit every place in the word in turn.
"""

from math import gcd

RUN_SAMPLES = 7
"""The pattern stays at a level for about this many samples: longer than a word, so that one edge at most is in one."""


def pattern_divider(output_divider: int) -> int:
    """The divider d for the output divider o of the PLL."""
    divider = -(-RUN_SAMPLES * output_divider // 2)
    while gcd(divider, 2 * output_divider) != 1:
        divider += 1
    return divider
