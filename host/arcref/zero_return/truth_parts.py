"""Parts of a result that only a simulation knows, because it knows the true angle and every sample."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Waveform:
    """The lines around one index: samples `time` (from the index's sample), `state` from each on, up to `end`.

    Bits of a state: 0 is A, 1 is B, 2 is Z.
    """

    direction: int
    time: np.ndarray
    state: np.ndarray
    end: int


@dataclass(frozen=True)
class ErrorOverTurn:
    """Errors against the truth in arc seconds, in cells of the turn with their middles at `angle_deg`.

    `before_...` is the reading's own error, `after_...` the corrected one's; low and high are the limits that occurred.
    """

    angle_deg: np.ndarray
    before_low: np.ndarray
    before_high: np.ndarray
    after_low: np.ndarray
    after_high: np.ndarray


@dataclass(frozen=True)
class ErrorFigures:
    """Root mean square and largest size of an error, in arc seconds, over so many readings."""

    rms_arcsec: float
    max_arcsec: float
    readings: int
