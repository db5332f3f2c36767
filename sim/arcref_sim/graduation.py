"""The encoder's own error: what its disc, heads and interpolator add to the true angle."""

from collections.abc import Callable

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN


class GraduationError:
    """The reading of an encoder as a function of the true angle: `reading = true angle + error`.

    The error is kept at evenly spaced readings over one turn and is linear between them. That line *is* the synthetic
    encoder's error, so the way from a reading back to the truth is exact. Angles and errors are floats in counts.
    """

    def __init__(self, error_counts):
        """`error_counts`: one value at each of the readings 0, S, 2S ... of one turn, S = 2^23 / length.

        Raises ValueError when the length does not divide a turn or the error is so steep that a reading would return.
        """
        self._error = np.asarray(error_counts, dtype=np.float64)
        if self._error.ndim != 1 or COUNTS_PER_TURN % len(self._error):
            raise ValueError("the number of error values must divide the counts of a turn")
        self._spacing = COUNTS_PER_TURN // len(self._error)
        self._step = np.roll(self._error, -1) - self._error
        if np.any(np.abs(self._step) >= 0.5 * self._spacing):
            raise ValueError("the error changes too steeply to be the error of an encoder")
        self._is_zero = not self._error.any()

    @classmethod
    def none(cls) -> "GraduationError":
        """The perfect encoder."""
        return cls(np.zeros(1))

    @classmethod
    def from_curve(cls, error_arcsec: Callable, knots: int = 1 << 15) -> "GraduationError":
        """An error given as a function of the true angle in degrees (array in, array out), in arc seconds.

        `knots` is how many straight pieces stand for the curve in one turn: a few dozen a grating line where an error
        within the line matters, the default for errors of the whole turn.
        """
        reading = np.arange(knots) * (COUNTS_PER_TURN / knots)
        true = reading
        for _ in range(20):  # contracts by the curve's slope each time, which is far below 1
            angle_deg = np.mod(true, COUNTS_PER_TURN) * (360 / COUNTS_PER_TURN)
            true = reading - np.asarray(error_arcsec(angle_deg), dtype=np.float64) / ARCSEC_PER_COUNT
        return cls(reading - true)

    def true_at_reading(self, reading):
        """True angle at which the encoder reads `reading`, turns included."""
        return reading - self._error_at_reading(reading)

    def true_at_counts(self, first: int, number: int) -> np.ndarray:
        """True angles of the `number` whole readings from `first` on: `true_at_reading` made fast for a row."""
        if self._is_zero:
            return np.arange(first, first + number, dtype=np.float64)
        if self._spacing > number:
            return self.true_at_reading(np.arange(first, first + number, dtype=np.float64))
        cell = first // self._spacing
        cells = np.arange(cell, (first + number - 1) // self._spacing + 1)
        base = cells * float(self._spacing) - np.take(self._error, cells, mode="wrap")
        slope = 1 - np.take(self._step, cells, mode="wrap") / self._spacing
        true = np.multiply.outer(slope, np.arange(self._spacing, dtype=np.float64))
        true += base[:, None]
        skip = first - cell * self._spacing
        return true.reshape(-1)[skip : skip + number]

    def reading_at(self, true):
        """Reading (not rounded) at a true angle, turns included: the inverse of `true_at_reading`."""
        reading = np.asarray(true, dtype=np.float64)
        if self._is_zero:
            return reading
        for _ in range(60):
            before, reading = reading, true + self._error_at_reading(reading)
            if np.all(np.abs(reading - before) < 1e-9):
                break
        return reading

    def error_at(self, true):
        """Error in counts at a true angle."""
        return self.reading_at(true) - true

    def _error_at_reading(self, reading):
        place = np.asarray(reading, dtype=np.float64) / self._spacing
        cell = np.floor(place)
        index = cell.astype(np.int64)
        return np.take(self._error, index, mode="wrap") + np.take(self._step, index, mode="wrap") * (place - cell)
