"""Angle and count arithmetic of the 23-bit encoder.

A *count* is one step of the quadrature signals, the least significant bit of the angle. A position is a signed
integer `turns * COUNTS_PER_TURN + angle` with `0 <= angle < COUNTS_PER_TURN`. Every function takes a number or a
NumPy array and keeps its shape.
"""

import numpy as np

ANGLE_BITS = 23
"""Bits of the angle inside one turn."""

COUNTS_PER_TURN = 1 << ANGLE_BITS
"""Counts in one turn: 4096 line pairs x 512 (interpolator) x 4 (edges of A and B)."""

LINES_PER_TURN = 4096
"""Line pairs of the disc, which are the signal periods of its sine and cosine."""

COUNTS_PER_LINE = COUNTS_PER_TURN // LINES_PER_TURN
"""Counts in one grating line (one signal period): 2048."""

ARCSEC_PER_TURN = 1_296_000
"""Arc seconds in one turn."""

ARCSEC_PER_COUNT = ARCSEC_PER_TURN / COUNTS_PER_TURN
"""One count, 0.154495 arcsec. This is the resolution; it says nothing about accuracy."""

POSITION_BITS = 48
"""Bits of a position in the gateware, two's complement: 25 bits of turns above 23 bits of angle."""


def counts_to_arcsec(counts):
    """Counts to arc seconds."""
    return np.multiply(counts, ARCSEC_PER_COUNT)


def arcsec_to_counts(arcsec):
    """Arc seconds to counts, not rounded."""
    return np.divide(arcsec, ARCSEC_PER_COUNT)


def counts_to_deg(counts):
    """Counts to degrees. Turns are kept: two turns are 720 degrees."""
    return np.multiply(counts, 360.0 / COUNTS_PER_TURN)


def deg_to_counts(angle_deg):
    """Degrees to the nearest count, as an integer (or an int64 array)."""
    counts = np.rint(np.multiply(angle_deg, COUNTS_PER_TURN / 360.0))
    return int(counts) if np.ndim(counts) == 0 else counts.astype(np.int64)


def wrapped(values, period=360.0):
    """Values brought into -period/2 .. period/2: the same directions, in degrees unless told otherwise.

    >>> float(wrapped(359.0))
    -1.0
    """
    rest = np.fmod(values, period)  # exact, however large the values
    return rest - period * np.rint(rest / period)


def split_position(position):
    """Split a position into `(turns, angle)` with `0 <= angle < COUNTS_PER_TURN`; turns are rounded down.

    >>> split_position(-1)
    (-1, 8388607)
    """
    return position >> ANGLE_BITS, position & (COUNTS_PER_TURN - 1)


def join_position(turns, angle):
    """The position of `turns` whole turns and `angle` counts."""
    return turns * COUNTS_PER_TURN + angle


def format_dms(angle_deg: float) -> str:
    """An angle in degrees, minutes and seconds with two decimals of a second, as `12° 34' 56.78"`."""
    hundredths = round(abs(angle_deg) * 360_000)
    minutes, second_hundredths = divmod(hundredths, 6000)
    degrees, minutes = divmod(minutes, 60)
    sign = "-" if angle_deg < 0 and hundredths else ""
    return f"{sign}{degrees}° {minutes:02d}' {second_hundredths / 100:05.2f}\""
