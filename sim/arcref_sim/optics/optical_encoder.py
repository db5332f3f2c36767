"""From the disc's angle to the interpolated reading: heads that look at the disc, their signals, the interpolator."""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, ARCSEC_PER_TURN, COUNTS_PER_TURN, LINES_PER_TURN
from arcref.subdivision.signal_model import SignalModel
from arcref_sim.graduation import GraduationError
from arcref_sim.optics.grating_disc import GratingDisc
from arcref_sim.square_waves import SquareWaves

ARCSEC_PER_LINE = ARCSEC_PER_TURN / LINES_PER_TURN

KNOTS_PER_LINE = 64
"""Straight pieces that stand for the error within a line in `graduation`: they miss 2 % of order 4, 4 % of order 6."""

_ANGLES_AT_ONCE = 1 << 15
_ROUNDS_TO_INVERT = 40
_LINES_FOR_MEAN = 64


@dataclass(frozen=True)
class Interpolator:
    """The chip that makes A, B and Z of sine and cosine.

    `conversion_rate_hz`: conversions a second, 0 for one that follows at once; `delay_ns`: from the signals to A and B;
    `hysteresis_counts`: A and B in reverse lag by so much; `shortest_edge_spacing_ns`: of the counts of one conversion.
    """

    conversion_rate_hz: float = 0.0
    delay_ns: float = 0.0
    hysteresis_counts: float = 0.0
    shortest_edge_spacing_ns: float = 0.0

    def waves(self) -> SquareWaves:
        """A and B of the synthetic encoder."""
        return SquareWaves(
            conversion_interval_ns=1e9 / self.conversion_rate_hz if self.conversion_rate_hz else 0.0,
            delay_ns=self.delay_ns,
            hysteresis_counts=self.hysteresis_counts,
            shortest_edge_spacing_ns=self.shortest_edge_spacing_ns,
        )


@dataclass(frozen=True, eq=False)
class OpticalEncoder:
    """An encoder whose error follows from its optics: heads at `head_deg` look at `disc`, their signals are added.

    `signals`: sine and cosine of one head, with seven parameters a channel or more; all heads are alike. With two heads
    half a turn apart odd orders of the disc cancel, even ones stay, and the amplitude falls by the cosine of half the
    heads' difference.
    """

    disc: GratingDisc
    signals: SignalModel
    head_deg: tuple[float, ...] = (0.0, 180.0)
    interpolator: Interpolator = field(default_factory=Interpolator)

    def signals_v(self, true_deg) -> tuple[np.ndarray, np.ndarray]:
        """Sine and cosine in volts, mean of the heads, at true angles in degrees."""
        true_deg = np.asarray(true_deg, float)
        sine, cosine = np.zeros(true_deg.shape), np.zeros(true_deg.shape)
        for head in self.head_deg:
            offset = self.disc.line_offset_arcsec(true_deg + head)
            one_sine, one_cosine = self.signals.signals_v(_line_phase_rad(true_deg, offset))
            sine, cosine = sine + one_sine / len(self.head_deg), cosine + one_cosine / len(self.head_deg)
        return sine, cosine

    def error_arcsec(self, true_deg) -> np.ndarray:
        """Interpolated reading less true angle; both are 0 at 0 deg, where Z has its mark, but for the error there.

        Raises ValueError where the heads' signals cancel each other, as the disc is too eccentric.
        """
        true_deg = np.asarray(true_deg, float)
        mean = np.mean([self.disc.line_offset_arcsec(true_deg + head) for head in self.head_deg], axis=0)
        sine, cosine = self.signals_v(true_deg)
        amplitude = self.signals.sine.fundamental.amplitude_v
        if (np.hypot(sine, cosine) < 0.2 * abs(amplitude)).any():
            raise ValueError("the heads' signals cancel each other: the disc is too eccentric")
        reading = self.signals.reading_rad(sine, cosine) - self.signals.mean_error_rad
        # Only what the reading adds to the mean of the heads is wrapped, for that may be more than half a line.
        more = reading - _line_phase_rad(true_deg, mean)
        more = np.mod(more + np.pi, 2 * np.pi) - np.pi
        return mean + more * (ARCSEC_PER_LINE / (2 * np.pi))

    def reading_deg(self, true_deg, direction: int = 0) -> np.ndarray:
        """The reading, turns kept, not rounded; `direction` -1: with the interpolator's hysteresis."""
        true_deg = np.asarray(true_deg, float)
        lag_deg = self.interpolator.hysteresis_counts * (360.0 / COUNTS_PER_TURN)
        return true_deg + self.error_arcsec(true_deg) / 3600.0 + np.where(np.asarray(direction) < 0, lag_deg, 0.0)

    def true_deg(self, reading_deg, direction: int = 0) -> np.ndarray:
        """The true angle at which the encoder reads `reading_deg`: the inverse of `reading_deg`."""
        reading_deg = np.asarray(reading_deg, float)
        true_deg = reading_deg
        for _ in range(_ROUNDS_TO_INVERT):
            step = self.reading_deg(true_deg, direction) - reading_deg
            true_deg = true_deg - step
            if not (np.abs(step) > 1e-12).any():
                break
        return true_deg

    def count(self, true_deg, direction: int = 0) -> np.ndarray:
        """The count at true angles, turns kept, int64: a count begins at its own reading."""
        return np.floor(self.reading_deg(true_deg, direction) * (COUNTS_PER_TURN / 360.0)).astype(np.int64)

    def graduation(self, knots_per_line: int = KNOTS_PER_LINE) -> GraduationError:
        """The same error for `SyntheticEncoder`, in straight pieces."""
        reading_deg = np.arange(LINES_PER_TURN * knots_per_line) * (360.0 / (LINES_PER_TURN * knots_per_line))
        parts = np.array_split(reading_deg, max(1, reading_deg.size // _ANGLES_AT_ONCE))
        error = np.concatenate([part - self.true_deg(part) for part in parts]) * 3600.0
        return GraduationError(error / ARCSEC_PER_COUNT)

    def within_line_arcsec(self, line_deg) -> np.ndarray:
        """The error within a line where the reading has these phases, as the mean of the lines: what a table can hold.

        The heads of an eccentric disc see the line at phases that part and meet over the turn; the error within the
        line changes with them.
        """
        line = (np.arange(_LINES_FOR_MEAN) + 0.5) * (LINES_PER_TURN / _LINES_FOR_MEAN)
        place = np.floor(line)[:, np.newaxis] + np.append(np.arange(512) / 512, np.ravel(line_deg) / 360.0)
        reading = place * (360.0 / LINES_PER_TURN)
        true = self.true_deg(reading)
        within = ((reading - true) * 3600.0 - self.turn_arcsec(true)).mean(axis=0)
        return (within[512:] - within[:512].mean()).reshape(np.shape(line_deg))

    def turn_arcsec(self, true_deg) -> np.ndarray:
        """The error over the turn alone: mean of the heads' line offsets."""
        return np.mean([self.disc.line_offset_arcsec(np.asarray(true_deg) + head) for head in self.head_deg], axis=0)


def _line_phase_rad(true_deg: np.ndarray, offset_arcsec: np.ndarray) -> np.ndarray:
    # The turn is taken off first: many lines would cost digits of the phase.
    lines = np.mod(true_deg, 360.0) * (LINES_PER_TURN / 360.0)
    return 2 * np.pi * (np.mod(lines, 1.0) + offset_arcsec / ARCSEC_PER_LINE)
