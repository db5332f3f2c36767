"""Choosing among the settings of a PLL, and saying which frequencies can be had instead."""

from arcref.input_error import InputError

RELATIVE_TOLERANCE = 1e-9
"""Two frequencies this near are the same one: rounding of the arithmetic, far below any oscillator's own error."""


def in_range(frequency_hz: float, limits_hz: tuple[float, float]) -> bool:
    """True when the frequency keeps to the data sheet's limits, both included."""
    lowest_hz, highest_hz = limits_hz
    return lowest_hz * (1 - RELATIVE_TOLERANCE) <= frequency_hz <= highest_hz * (1 + RELATIVE_TOLERANCE)


def frequency_refused(what: str, frequency_hz: float, limits_hz: tuple[float, float]) -> str:
    """The line for a frequency outside of `limits_hz`; `what` begins it ("the ECP5's PLL takes")."""
    return f"{what} {_mhz(limits_hz[0])} .. {_mhz(limits_hz[1])} MHz, not {_mhz(frequency_hz)} MHz"


def nearest(settings, wanted_hz: float, reference_hz: float, *, key):
    """The setting whose `output_hz` is `wanted_hz`, the first one by `key`.

    Raises `InputError` when none is, with the frequencies next to it that can be had.
    """
    exact = [pll for pll in settings if abs(pll.output_hz - wanted_hz) <= RELATIVE_TOLERANCE * wanted_hz]
    if exact:
        return min(exact, key=key)
    outputs_hz = [pll.output_hz for pll in settings]
    below_hz = max((output_hz for output_hz in outputs_hz if output_hz < wanted_hz), default=None)
    above_hz = min((output_hz for output_hz in outputs_hz if output_hz > wanted_hz), default=None)
    neighbours = " and ".join(_mhz(output_hz) for output_hz in (below_hz, above_hz) if output_hz is not None)
    raise InputError(
        f"{_mhz(wanted_hz)} MHz cannot be had from {_mhz(reference_hz)} MHz; the nearest that can: {neighbours} MHz"
    )


def _mhz(frequency_hz: float) -> str:
    return f"{frequency_hz / 1e6:.6g}"
