"""The PLL of the ECP5, EHXPLLL: dividers for a wanted frequency.

    reference / CLKI_DIV = phase detector;  output = phase detector * CLKFB_DIV;  VCO = output * CLKOP_DIV

with the feedback taken from CLKOP. Limits: Lattice FPGA-DS-02012 (ECP5 family data sheet), "sysCLOCK PLL Timing".
"""

from dataclasses import dataclass

from arcref.input_error import InputError
from arcref_gateware.boards.pll_choice import frequency_refused, in_range, nearest

REFERENCE_HZ = (8e6, 400e6)
PHASE_DETECTOR_HZ = (10e6, 400e6)
VCO_HZ = (400e6, 800e6)
OUTPUT_HZ = (3.125e6, 400e6)
DIVIDERS = range(1, 129)


@dataclass(frozen=True)
class Ecp5Pll:
    """Dividers of an EHXPLLL and the frequencies they give, in hertz."""

    reference_divider: int
    feedback_divider: int
    output_divider: int
    reference_hz: float

    @property
    def output_hz(self) -> float:
        """Frequency of CLKOP."""
        return self.reference_hz * self.feedback_divider / self.reference_divider

    @property
    def vco_hz(self) -> float:
        """Frequency of the oscillator inside."""
        return self.output_hz * self.output_divider

    @property
    def phase_detector_hz(self) -> float:
        """Frequency at which the phases are compared."""
        return self.reference_hz / self.reference_divider


def ecp5_pll(reference_hz: float, wanted_hz: float) -> Ecp5Pll:
    """Dividers that give exactly `wanted_hz`, the phase detector as fast and then the VCO as fast as can be.

    Raises `InputError` with the nearest frequencies when there are none.
    """
    if not in_range(reference_hz, REFERENCE_HZ):
        raise InputError(frequency_refused("the ECP5's PLL takes", reference_hz, REFERENCE_HZ))
    if not in_range(wanted_hz, OUTPUT_HZ):
        raise InputError(frequency_refused("the ECP5's PLL gives", wanted_hz, OUTPUT_HZ))
    settings = [pll for pll in _all_settings(reference_hz) if in_range(pll.output_hz, OUTPUT_HZ)]
    return nearest(settings, wanted_hz, reference_hz, key=lambda pll: (-pll.phase_detector_hz, -pll.vco_hz))


def _all_settings(reference_hz: float) -> list[Ecp5Pll]:
    settings = []
    for reference_divider in DIVIDERS:
        if not in_range(reference_hz / reference_divider, PHASE_DETECTOR_HZ):
            continue
        for feedback_divider in DIVIDERS:
            output_hz = reference_hz * feedback_divider / reference_divider
            first = max(1, int(VCO_HZ[0] / output_hz))
            for output_divider in range(first, min(DIVIDERS[-1], int(VCO_HZ[1] / output_hz + 1e-9)) + 1):
                pll = Ecp5Pll(reference_divider, feedback_divider, output_divider, reference_hz)
                if in_range(pll.vco_hz, VCO_HZ):
                    settings.append(pll)
    return settings
