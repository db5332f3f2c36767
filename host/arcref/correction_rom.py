"""The correction tables as the FPGA holds them, and the golden model of the correction.

The gateware is compared with `CorrectionRom.correct` bit for bit. A reading is corrected by two tables of signed 16-bit
entries in 1/16 count: one entry for each of the 4096 grating lines (the full-turn error), and one for each of the 512
groups of four counts inside a line (the sub-divisional error).
"""

import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from arcref.angle import (
    ARCSEC_PER_COUNT,
    COUNTS_PER_LINE,
    COUNTS_PER_TURN,
    LINES_PER_TURN,
    arcsec_to_counts,
    counts_to_deg,
)
from arcref.input_error import InputError

FRACTION_BITS = 4
"""Table entries are in counts / 2^4."""

SUBDIVISION_CELL_COUNTS = 4
"""Counts that share one entry of the subdivision table."""

SUBDIVISION_ENTRIES = COUNTS_PER_LINE // SUBDIVISION_CELL_COUNTS

ENTRY_MIN, ENTRY_MAX = -(1 << 15), (1 << 15) - 1

ENTRY_LIMIT_ARCSEC = ENTRY_MAX / (1 << FRACTION_BITS) * ARCSEC_PER_COUNT
"""The largest error a table entry holds either way: 2047.9 counts, 316.4 arcsec."""

# Positions corrected at a time, so that the intermediate arrays stay in the processor's cache.
_BLOCK = 1 << 15


@dataclass(frozen=True, eq=False)
class CorrectionRom:
    """The two integer tables, and where they come from.

    `line_table` is int16[4096], `subdivision_table` int16[512], both in 1/16 count and read-only; `provenance` is a
    dictionary that JSON can hold. Raises `ValueError` for a table of another length or with an entry beyond int16.
    """

    line_table: np.ndarray
    subdivision_table: np.ndarray = field(default_factory=lambda: np.zeros(SUBDIVISION_ENTRIES, np.int16))
    provenance: dict = field(default_factory=dict)

    def __post_init__(self):
        object.__setattr__(self, "line_table", _int16_table("line_table", self.line_table, LINES_PER_TURN))
        table = _int16_table("subdivision_table", self.subdivision_table, SUBDIVISION_ENTRIES)
        object.__setattr__(self, "subdivision_table", table)

    @classmethod
    def from_fit(
        cls,
        evaluate: Callable[[np.ndarray], np.ndarray],
        subdivision: Callable[[np.ndarray], np.ndarray] | None = None,
        provenance: dict | None = None,
        source: str = "fitted curve",
    ) -> "CorrectionRom":
        """The tables of a fitted error curve.

        `evaluate` takes an array of angles in degrees of the turn and gives the errors (reading - true angle) in
        arcsec; `subdivision` takes an array of phases in degrees of one grating line and gives the errors within the
        line in arcsec. Each entry is the error at the middle of its cell, rounded to the nearest 1/16 count. Without
        `subdivision` the line entry alone decides the whole count that is subtracted; the few entries whose rounding
        up to a half count would turn that count are rounded down, so that it is the count nearest to the error.
        Raises `InputError`, which starts with `source`, for an error that an entry cannot hold.
        """
        line_deg = counts_to_deg(np.arange(LINES_PER_TURN) * COUNTS_PER_LINE + COUNTS_PER_LINE / 2)
        error_arcsec = np.asarray(evaluate(line_deg), float)
        line = _entries(error_arcsec, line_deg, source, "of the turn")
        if subdivision is None:
            nearest = np.floor(arcsec_to_counts(error_arcsec) + 0.5)
            line -= (line + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS != nearest
            return cls(line, provenance=provenance or {})
        cell = np.arange(SUBDIVISION_ENTRIES) * SUBDIVISION_CELL_COUNTS + SUBDIVISION_CELL_COUNTS / 2
        phase_deg = cell * (360.0 / COUNTS_PER_LINE)
        within_line = _entries(np.asarray(subdivision(phase_deg), float), phase_deg, source, "of a grating line")
        return cls(line, within_line, provenance or {})

    @cached_property
    def crc32(self) -> int:
        """CRC-32 (zlib's) over both tables as little-endian int16, line table first."""
        return zlib.crc32(self.line_table.astype("<i2").tobytes() + self.subdivision_table.astype("<i2").tobytes())

    def correction(self, position):
        """The correction in whole counts at `position`: `(line[angle >> 11] + sub[(angle & 2047) >> 2] + 8) >> 4`.

        `position` is an integer or an integer array, of any number of turns either way; the result is an int or an
        int64 array of the same shape. Raises `TypeError` for anything but integers.
        """
        if isinstance(position, (int, np.integer)):
            return int(self._cell_corrections[(int(position) & (COUNTS_PER_TURN - 1)) >> 2])
        return self._by_blocks(position, subtract=False)

    def correct(self, position):
        """The corrected position, `position - correction(position)`, in counts. Takes and gives what `correction` does.

        The turns borrow and carry with the angle: a corrected position never jumps by a turn at zero. The gateware
        keeps the low 48 bits of the result.
        """
        if isinstance(position, (int, np.integer)):
            return int(position) - self.correction(position)
        return self._by_blocks(position, subtract=True)

    @cached_property
    def _cell_corrections(self) -> np.ndarray:
        """The correction of each group of four counts in the turn, int16[2^21]: one look-up in place of two."""
        both = self.line_table.astype(np.int32)[:, np.newaxis] + self.subdivision_table
        return ((both + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS).astype(np.int16).ravel()

    def _by_blocks(self, position, *, subtract: bool) -> np.ndarray:
        position = np.asarray(position)
        if position.dtype.kind not in "iu":
            raise TypeError(f"positions are whole counts, {position.dtype} was given")
        flat = position.astype(np.int64, copy=False).ravel()
        result = np.empty(flat.size, np.int64)
        cells = self._cell_corrections
        index = np.empty(min(_BLOCK, flat.size), np.int64)
        value = np.empty(index.size, np.int16)
        for start in range(0, flat.size, _BLOCK):
            block = flat[start : start + _BLOCK]
            cell, found = index[: block.size], value[: block.size]
            np.right_shift(block, 2, out=cell)
            np.bitwise_and(cell, cells.size - 1, out=cell)
            # The mask keeps every index in range; "clip" spares NumPy a copy that its default mode would make.
            np.take(cells, cell, out=found, mode="clip")
            target = result[start : start + _BLOCK]
            if subtract:
                np.subtract(block, found, out=target)
            else:
                target[:] = found
        return result.reshape(position.shape)

    def __eq__(self, other):
        if not isinstance(other, CorrectionRom):
            return NotImplemented
        return (
            np.array_equal(self.line_table, other.line_table)
            and np.array_equal(self.subdivision_table, other.subdivision_table)
            and self.provenance == other.provenance
        )

    def __hash__(self):
        return self.crc32


def _int16_table(name: str, values, length: int) -> np.ndarray:
    table = np.asarray(values)
    if table.shape != (length,):
        raise ValueError(f"{name} has shape {table.shape}, {length} entries were expected")
    if table.dtype.kind not in "iu":
        raise ValueError(f"{name} holds {table.dtype}, integers were expected")
    if table.min() < ENTRY_MIN or table.max() > ENTRY_MAX:
        raise ValueError(f"{name} has an entry beyond {ENTRY_MIN} .. {ENTRY_MAX}")
    table = table.astype(np.int16)  # a copy, so that the caller's array stays its own
    table.setflags(write=False)
    return table


def _entries(error_arcsec: np.ndarray, angle_deg: np.ndarray, source: str, place: str) -> np.ndarray:
    """Errors in arcsec as table entries, refused when one does not fit."""
    entries = np.rint(arcsec_to_counts(error_arcsec) * (1 << FRACTION_BITS))
    bad = ~((entries >= ENTRY_MIN) & (entries <= ENTRY_MAX))  # written so that NaN is bad, too
    if bad.any():
        worst = int(np.argmax(bad))
        raise InputError(
            f"{source}: the error at {angle_deg[worst]:.3f} deg {place} is {error_arcsec[worst]:.6g} arcsec, "
            f"a table entry holds up to +-{ENTRY_LIMIT_ARCSEC:.1f} arcsec (+-2047.9 counts)"
        )
    return entries.astype(np.int64)
