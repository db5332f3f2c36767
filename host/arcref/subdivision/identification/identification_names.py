"""The ways to identify the signals, by the names that the command knows."""

from arcref.subdivision.identification.identification import USUAL_ORDERS, IdentifiedParameters, PeriodSamples
from arcref.subdivision.identification.least_squares import least_squares

DEFAULT_METHOD = "least-squares"

METHODS = {"least-squares": "linear least squares"}
"""Name of each way, and what the report calls it."""


def identify(
    samples: PeriodSamples, method: str = DEFAULT_METHOD, orders: tuple[int, ...] = USUAL_ORDERS, seed: int = 1
) -> IdentifiedParameters:
    """Identify both channels by the way called `method`. See `Identification` for errors raised."""
    return least_squares(samples, orders)
