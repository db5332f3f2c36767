"""The one interface of the ways to identify a channel pair: samples at known phases in, a parameter set out."""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.subdivision.signal_model import SignalModel

USUAL_ORDERS = (1, 3, 5)
"""Orders of the published model: its seven parameters a channel."""


@dataclass(frozen=True, eq=False)
class PeriodSamples:
    """Sine and cosine at known phases of a grating line: what every identification takes.

    `theta_rad`: float64[n], true phase of each sample; `sine_v`, `cosine_v`: float64[n]. Samples of many periods may
    stand behind each other; `theta_rad` then counts on or starts anew at each, as one likes. `cosine_sign`: as in
    `SignalModel`.
    """

    theta_rad: np.ndarray
    sine_v: np.ndarray
    cosine_v: np.ndarray
    line_count: int = LINES_PER_TURN
    cosine_sign: int | None = None


@dataclass(frozen=True, eq=False)
class IdentifiedParameters:
    """What every identification gives.

    `model`: the signals, amplitudes of 0 or more; `method`: name of the way; `residual_rms_v`: rms of samples less
    model, (sine, cosine); `noise_v`: the same per degree of freedom, an estimate of one sample's standard deviation;
    `samples`: how many there were; `seconds`: what it took; `details`: numbers of the method alone, ready for JSON.
    """

    model: SignalModel
    method: str
    residual_rms_v: tuple[float, float]
    noise_v: tuple[float, float]
    samples: int
    seconds: float
    details: dict = field(default_factory=dict)
