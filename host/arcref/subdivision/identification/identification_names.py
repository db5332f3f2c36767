"""The ways to identify the signals, by the names that the command knows."""

from arcref.subdivision.identification.heydemann_ellipse import heydemann_ellipse
from arcref.subdivision.identification.identification import USUAL_ORDERS, IdentifiedParameters, PeriodSamples
from arcref.subdivision.identification.least_squares import least_squares
from arcref.subdivision.identification.particle_swarm import CORRECTED, PRINTED
from arcref.subdivision.identification.swarm_identification import particle_swarm

DEFAULT_METHOD = "least-squares"

METHODS = {
    "least-squares": "linear least squares",
    "swarm": "particle swarm, inertia rule corrected",
    "swarm-printed": "particle swarm, inertia rule as printed",
    "heydemann": "Heydemann ellipse",
}
"""Name of each way, and what the report calls it."""


def identify(
    samples: PeriodSamples, method: str = DEFAULT_METHOD, orders: tuple[int, ...] = USUAL_ORDERS, seed: int = 1
) -> IdentifiedParameters:
    """Identify both channels by the way called `method`.

    `orders`: harmonics of the model, which the ellipse does not use; `seed`: of the swarm. Raises `InputError` when the
    samples do not determine the parameters.
    """
    if method == "heydemann":
        return heydemann_ellipse(samples)
    if method == "least-squares":
        return least_squares(samples, orders)
    return particle_swarm(samples, orders, seed, {"swarm": CORRECTED, "swarm-printed": PRINTED}[method])
