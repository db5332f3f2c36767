"""The PLL of the iCE40, SB_PLL40 with simple feedback: dividers for a wanted frequency.

    reference / (DIVR + 1) = phase detector;  VCO = phase detector * (DIVF + 1);  output = VCO / 2 ** DIVQ

Limits: Lattice FPGA-DS-02029 (iCE40 LP/HX family data sheet) and FPGA-DS-02008 (iCE40 UltraPlus family data sheet),
"sysCLOCK PLL Timing"; dividers and filter range: FPGA-TN-02052 (iCE40 sysCLOCK PLL design and usage guide).
"""

from dataclasses import dataclass

from arcref.input_error import InputError
from arcref_gateware.boards.pll_choice import frequency_refused, in_range, nearest

REFERENCE_HZ = (10e6, 133e6)
PHASE_DETECTOR_HZ = (10e6, 133e6)
VCO_HZ = (533e6, 1066e6)
OUTPUT_HZ = (16e6, 275e6)
REFERENCE_DIVIDERS = range(16)
FEEDBACK_DIVIDERS = range(128)
OUTPUT_DIVIDERS = range(1, 7)

_FILTER_RANGES = ((17e6, 1), (26e6, 2), (44e6, 3), (66e6, 4), (101e6, 5))


@dataclass(frozen=True)
class Ice40Pll:
    """Dividers of an SB_PLL40 as its parameters DIVR, DIVF and DIVQ have them, and what they give, in hertz."""

    divr: int
    divf: int
    divq: int
    reference_hz: float

    @property
    def phase_detector_hz(self) -> float:
        """Frequency at which the phases are compared."""
        return self.reference_hz / (self.divr + 1)

    @property
    def vco_hz(self) -> float:
        """Frequency of the oscillator inside."""
        return self.phase_detector_hz * (self.divf + 1)

    @property
    def output_hz(self) -> float:
        """Frequency of the output."""
        return self.vco_hz / 2**self.divq

    @property
    def filter_range(self) -> int:
        """Parameter FILTER_RANGE for this phase detector frequency."""
        return next((value for limit_hz, value in _FILTER_RANGES if self.phase_detector_hz < limit_hz), 6)


def ice40_pll(reference_hz: float, wanted_hz: float) -> Ice40Pll:
    """Dividers that give exactly `wanted_hz`, the phase detector as fast as can be.

    Raises `InputError` with the nearest frequencies when there are none.
    """
    if not in_range(reference_hz, REFERENCE_HZ):
        raise InputError(frequency_refused("the iCE40's PLL takes", reference_hz, REFERENCE_HZ))
    if not in_range(wanted_hz, OUTPUT_HZ):
        raise InputError(frequency_refused("the iCE40's PLL gives", wanted_hz, OUTPUT_HZ))
    settings = []
    for divr in REFERENCE_DIVIDERS:
        for divf in FEEDBACK_DIVIDERS:
            for divq in OUTPUT_DIVIDERS:
                pll = Ice40Pll(divr, divf, divq, reference_hz)
                if (
                    in_range(pll.phase_detector_hz, PHASE_DETECTOR_HZ)
                    and in_range(pll.vco_hz, VCO_HZ)
                    and in_range(pll.output_hz, OUTPUT_HZ)
                ):
                    settings.append(pll)
    return nearest(settings, wanted_hz, reference_hz, key=lambda pll: -pll.phase_detector_hz)
