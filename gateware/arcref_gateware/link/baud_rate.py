"""The divisor of a baud rate."""

LARGEST_ERROR = 0.02
"""How far a rate may be off, as a part of it: with both ends 2 % off, the stop bit is still met in its second half."""

LEAST_DIVISOR = 8
"""Clocks in a bit, at the least: the receiver must find the middle of a bit to an eighth."""


def baud_divisor(clock_hz: float, baud: float) -> int:
    """Clocks in a bit. Raises ValueError, which says what can be had, when the clock does not give the rate."""
    divisor = max(1, round(clock_hz / baud))
    error = clock_hz / divisor / baud - 1
    if divisor < LEAST_DIVISOR:
        raise ValueError(
            f"{baud:g} baud needs a clock of {LEAST_DIVISOR * baud / 1e6:g} MHz, it is {clock_hz / 1e6:g} MHz"
        )
    if abs(error) > LARGEST_ERROR:
        raise ValueError(
            f"{baud:g} baud would be {100 * error:+.1f} % off at a clock of {clock_hz / 1e6:g} MHz; 2 % is the most"
        )
    return divisor
