"""Sine and cosine of a grating with their faults, and the error of the angle that is interpolated from them.

After Gao Xu et al., Acta Optica Sinica 33(7) 2013 0712001, equations (8) and (9), with any set of harmonics:

    u(theta) = A0 + A1 sin(theta + c1) + A3 sin(3 theta + c3) + A5 sin(5 theta + c5) + ...

for the sine channel, and the same with its own numbers for the cosine channel. `theta` is the true phase within a
grating line, 2 pi to a line; offsets and amplitudes are in volts, phases in radians.

The *reading* is the phase phi = atan2(u_sine, s u_cosine). Its sign s is +1 when the cosine is a quarter of a line
ahead of the sine, and -1 when it is behind, as in the paper, whose cosine is -cos(theta): with +1 the reading would run
backwards there. The plain arctangent of its equations (2) and (5) needs a quadrant logic that this form contains.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np

from arcref.angle import ARCSEC_PER_TURN, LINES_PER_TURN

FINE_POINTS = 4096
"""Phases over a line at which curves are evaluated when nothing else is asked."""


def line_phases_rad(points: int = FINE_POINTS) -> np.ndarray:
    """Equally spaced phases over one line from 0, float64[points]."""
    return np.arange(points) * (2 * np.pi / points)


def wrapped_rad(phase_rad):
    """Phases brought into -pi .. pi."""
    return np.remainder(np.add(phase_rad, np.pi), 2 * np.pi) - np.pi


@dataclass(frozen=True)
class Harmonic:
    """`amplitude_v` sin(order theta + `phase_rad`)."""

    amplitude_v: float
    phase_rad: float

    @property
    def canonical(self) -> "Harmonic":
        """The same wave with an amplitude of 0 or more and a phase within -pi .. pi."""
        turn = math.pi if self.amplitude_v < 0 else 0.0
        return Harmonic(abs(self.amplitude_v), math.remainder(self.phase_rad + turn, 2 * math.pi))


@dataclass(frozen=True)
class ChannelModel:
    """One channel: `offset_v` + sum over the orders k of A_k sin(k theta + c_k).

    `harmonics`: order (1 and up) to `Harmonic`; order 1, the signal itself, must be there.

    >>> ChannelModel(0.1, {1: Harmonic(2.0, 0.0)}).evaluate(np.pi / 2)
    np.float64(2.1)
    """

    offset_v: float
    harmonics: Mapping[int, Harmonic]

    def __post_init__(self):
        if 1 not in self.harmonics or min(self.harmonics) < 1:
            raise ValueError(f"orders from 1 up with order 1 among them were expected, not {sorted(self.harmonics)}")
        object.__setattr__(self, "harmonics", MappingProxyType(dict(sorted(self.harmonics.items()))))

    @property
    def orders(self) -> tuple[int, ...]:
        """Orders of the harmonics, increasing."""
        return tuple(self.harmonics)

    @property
    def fundamental(self) -> Harmonic:
        """The harmonic of order 1."""
        return self.harmonics[1]

    @property
    def canonical(self) -> "ChannelModel":
        """The same signal with amplitudes of 0 or more and phases within -pi .. pi."""
        return ChannelModel(self.offset_v, {order: wave.canonical for order, wave in self.harmonics.items()})

    def evaluate(self, theta_rad) -> np.ndarray:
        """Volts at the phases `theta_rad`, of their shape."""
        theta = np.asarray(theta_rad, float)
        return self.offset_v + sum(wave.amplitude_v * np.sin(k * theta + wave.phase_rad) for k, wave in self._waves)

    def derivative(self, theta_rad) -> np.ndarray:
        """Volts per radian at the phases `theta_rad`, of their shape."""
        theta = np.asarray(theta_rad, float)
        return sum(k * wave.amplitude_v * np.cos(k * theta + wave.phase_rad) for k, wave in self._waves)

    def without(self, orders=(), offset: bool = False) -> "ChannelModel":
        """The channel without the harmonics of `orders`, and without its offset when that is wanted."""
        kept = {order: wave for order, wave in self.harmonics.items() if order not in orders}
        return ChannelModel(0.0 if offset else self.offset_v, kept)

    def to_json(self) -> dict:
        """As CAL.json keeps it: `offset_v` and `harmonics`, with the orders as text."""
        waves = {
            str(order): {"amplitude_v": wave.amplitude_v, "phase_rad": wave.phase_rad} for order, wave in self._waves
        }
        return {"offset_v": self.offset_v, "harmonics": waves}

    @classmethod
    def from_json(cls, content: Mapping) -> "ChannelModel":
        """The channel that `to_json` wrote. Raises KeyError, TypeError or ValueError for anything else."""
        waves = {
            int(order): Harmonic(float(wave["amplitude_v"]), float(wave["phase_rad"]))
            for order, wave in content["harmonics"].items()
        }
        return cls(float(content["offset_v"]), waves)

    @cached_property
    def _waves(self) -> tuple[tuple[int, Harmonic], ...]:
        return tuple(self.harmonics.items())


@dataclass(frozen=True)
class SignalModel:
    """Both channels of one head over one grating line.

    `line_count`: lines of the disc, which makes phases into angles: a line is 1296000 / `line_count` arcsec.
    `cosine_sign`: the sign s of the reading atan2(u_sine, s u_cosine); None takes the one with which the reading grows.
    """

    sine: ChannelModel
    cosine: ChannelModel
    line_count: int = LINES_PER_TURN
    cosine_sign: int | None = None

    def __post_init__(self):
        if self.cosine_sign is None:
            first, second = self.sine.fundamental, self.cosine.fundamental
            quarter = first.amplitude_v * second.amplitude_v * math.sin(second.phase_rad - first.phase_rad)
            object.__setattr__(self, "cosine_sign", 1 if quarter >= 0 else -1)

    @classmethod
    def ideal(cls, amplitude_v: float = 1.0, line_count: int = LINES_PER_TURN, cosine_sign: int = 1) -> "SignalModel":
        """Signals without a fault: `amplitude_v` sin(theta) and `cosine_sign` `amplitude_v` cos(theta)."""
        cosine = Harmonic(cosine_sign * amplitude_v, math.pi / 2)
        return cls(ChannelModel(0.0, {1: Harmonic(amplitude_v, 0.0)}), ChannelModel(0.0, {1: cosine}), line_count)

    @property
    def period_arcsec(self) -> float:
        """One grating line as an angle."""
        return ARCSEC_PER_TURN / self.line_count

    @property
    def arcsec_per_rad(self) -> float:
        """Angle of the shaft for a radian of phase."""
        return self.period_arcsec / (2 * math.pi)

    def signals_v(self, theta_rad) -> tuple[np.ndarray, np.ndarray]:
        """Sine and cosine in volts at the true phases `theta_rad`, each of their shape."""
        return self.sine.evaluate(theta_rad), self.cosine.evaluate(theta_rad)

    def reading_rad(self, sine_v, cosine_v) -> np.ndarray:
        """The phase that an interpolator makes of these voltages, within -pi .. pi."""
        return np.arctan2(sine_v, np.multiply(self.cosine_sign, cosine_v))

    @cached_property
    def common_phase_rad(self) -> float:
        """Mean of reading less true phase over a line: where the line begins, and no error."""
        return float(np.angle(np.exp(1j * self._difference_rad(line_phases_rad())).mean()))

    @cached_property
    def mean_error_rad(self) -> float:
        """What is taken off so that the error has no mean over a line: the common phase, and what bends it."""
        difference = wrapped_rad(self._difference_rad(line_phases_rad()) - self.common_phase_rad)
        return self.common_phase_rad + float(difference.mean())

    def error_arcsec(self, theta_rad) -> np.ndarray:
        """Reading less true angle at the true phases `theta_rad`, of their shape; its mean over a line is zero."""
        return self.arcsec_per_rad * wrapped_rad(self._difference_rad(theta_rad) - self.mean_error_rad)

    def true_phase_rad(self, reading_rad) -> np.ndarray:
        """The true phase at which the angle reads `reading_rad`, counted so that reading and truth agree in the mean.

        Solved by Newton on reading(theta), to rounding. Raises ValueError where the reading does not grow with the
        true phase, for then one reading has several.
        """
        reading = np.asarray(reading_rad, float)
        theta = reading - self.mean_error_rad
        for _ in range(_MOST_STEPS):
            sine, cosine = self.signals_v(theta)
            cosine = self.cosine_sign * cosine
            slope = self.sine.derivative(theta) * cosine
            slope = (slope - self.cosine_sign * self.cosine.derivative(theta) * sine) / (sine**2 + cosine**2)
            if not (slope > 0).all():
                raise ValueError("the reading does not grow with the true phase everywhere on the line")
            step = wrapped_rad(np.arctan2(sine, cosine) - reading) / slope
            theta = theta - np.clip(step, -0.5, 0.5)
            if not (np.abs(step) > _SMALLEST_STEP).any():
                break
        return theta + self.mean_error_rad

    def error_at_reading_arcsec(self, reading_rad) -> np.ndarray:
        """Reading less true angle where the angle reads `reading_rad`: what a table over the reading must hold.

        The same errors as `error_arcsec`, at other abscissae; their mean over the true phase is zero.
        """
        return self.arcsec_per_rad * wrapped_rad(np.asarray(reading_rad) - self.true_phase_rad(reading_rad))

    def _difference_rad(self, theta_rad) -> np.ndarray:
        return wrapped_rad(self.reading_rad(*self.signals_v(theta_rad)) - np.asarray(theta_rad))


_MOST_STEPS = 60
_SMALLEST_STEP = 1e-14
