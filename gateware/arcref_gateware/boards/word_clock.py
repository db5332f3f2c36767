"""From the oscillator to the word clock: which frequency the PLL must make, for each family and sampler."""

from arcref_gateware.boards.pll_ecp5 import Ecp5Pll, ecp5_pll
from arcref_gateware.boards.pll_ice40 import Ice40Pll, ice40_pll


def pll_output_hz(samples_per_word: int, word_clock_hz: float) -> float:
    """The PLL's frequency: the word clock, or twice that for four samples a word (the edge clock of the gearing)."""
    return 2 * word_clock_hz if samples_per_word == 4 else word_clock_hz


def word_clock_pll(
    family: str, samples_per_word: int, oscillator_hz: float, word_clock_hz: float
) -> Ecp5Pll | Ice40Pll:
    """Settings of the family's PLL. Raises `InputError` with the nearest frequencies when there are none."""
    calculate = {"ecp5": ecp5_pll, "ice40": ice40_pll}[family]
    return calculate(oscillator_hz, pll_output_hz(samples_per_word, word_clock_hz))
