"""When each stage of the core is ready, in clocks after a sample word.

    clock  1, 2        quadrature: the word, its steps
           3..5        partial sums; index and strobe placed in the word; what the position advances by
           6..9        position, a segment a clock, its angle with the second one
           8..16       correction: address, look-up, sum, rounding
           17..20      position less the correction, a segment a clock

Closure check, edge spacing, counters and flags wait for their word and show it at the same clock.
"""

from arcref_gateware.correction import CORRECTION_CLOCKS
from arcref_gateware.partial_sums import PARTIAL_SUM_CLOCKS, WAY_BACK_CLOCKS
from arcref_gateware.position import ANGLE_CLOCKS, POSITION_CLOCKS, POSITION_SEGMENTS
from arcref_gateware.quadrature import QUADRATURE_CLOCKS
from arcref_gateware.rom_check import RomCheck

STEPS_READY = QUADRATURE_CLOCKS
WAY_BACK_READY = STEPS_READY + WAY_BACK_CLOCKS
ADVANCE_READY = STEPS_READY + PARTIAL_SUM_CLOCKS
POSITION_READY = ADVANCE_READY + POSITION_CLOCKS
"""Segment 0 of the position after the word."""
ANGLE_READY = ADVANCE_READY + ANGLE_CLOCKS
CORRECTION_READY = ANGLE_READY + CORRECTION_CLOCKS

LATENCY_CLOCKS = CORRECTION_READY + len(POSITION_SEGMENTS)
"""Clocks from a sample word to the outputs that show the state after it, captures among them."""

ROM_VERDICT_WORD = RomCheck.CLOCKS - ANGLE_READY
"""The word, counted from reset, with which the verdict of the power-up check takes effect."""

FIRST_CORRECTED_WORD = ROM_VERDICT_WORD + 1
"""The first word that can be corrected: the one before it fetches what the look-ups hold on to."""
