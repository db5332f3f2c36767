"""How often a particle swarm finds the least squares optimum, by its size."""

from dataclasses import dataclass, replace

import numpy as np

from arcref.subdivision.identification.identification import USUAL_ORDERS, PeriodSamples
from arcref.subdivision.identification.least_squares import design_matrix
from arcref.subdivision.identification.particle_swarm import SwarmSettings, coefficients_of, swarm_search

CONVERGED_V = 1e-9
"""A swarm whose signals are within this of the least squares ones, rms, in both channels, has converged."""


@dataclass(frozen=True, eq=False)
class SwarmConvergence:
    """Of one size of swarm: distance of each search from the optimum, rms in volts, the worse of both channels.

    `least_below_v2`: by how much the best sum of squares is below that of least squares: no more than rounding.
    """

    settings: SwarmSettings
    distance_v: np.ndarray
    least_below_v2: float

    @property
    def share(self) -> float:
        """Share of the searches that converged."""
        return float(np.mean(self.distance_v < CONVERGED_V))


def swarm_convergence(
    samples: PeriodSamples,
    particles: tuple[int, ...],
    seeds=range(100),
    orders: tuple[int, ...] = USUAL_ORDERS,
    settings: SwarmSettings | None = None,
) -> tuple[SwarmConvergence, ...]:
    """Search with every seed by a swarm of each size; all other settings are those given."""
    settings = settings or SwarmSettings(iterations=500)
    return tuple(_of_size(samples, seeds, orders, replace(settings, particles=size)) for size in particles)


def _of_size(samples: PeriodSamples, seeds, orders, settings: SwarmSettings) -> SwarmConvergence:
    columns = design_matrix(samples.theta_rad, orders)
    distance, below = [], []
    for place, volts in enumerate((samples.sine_v, samples.cosine_v)):
        optimum = np.linalg.lstsq(columns, volts, rcond=None)[0]
        outcome = swarm_search(columns, volts, [[seed, place] for seed in seeds], settings)
        missed = (coefficients_of(outcome.parameters) - optimum) @ columns.T
        distance.append(np.sqrt(np.mean(missed**2, axis=1)))
        below.append(np.sum((volts - columns @ optimum) ** 2) - outcome.square_v2.min())
    return SwarmConvergence(settings, np.maximum(*distance), float(max(below)))
