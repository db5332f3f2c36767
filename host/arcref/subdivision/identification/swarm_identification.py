"""The particle swarm as a way to identify both channels."""

import time

import numpy as np

from arcref.subdivision.identification.identification import USUAL_ORDERS, IdentifiedParameters, PeriodSamples
from arcref.subdivision.identification.least_squares import check_samples, design_matrix, identified
from arcref.subdivision.identification.particle_swarm import CORRECTED, SwarmSettings, swarm_search
from arcref.subdivision.signal_model import ChannelModel, Harmonic, SignalModel


def channel_of_swarm(parameters, orders: tuple[int, ...]) -> ChannelModel:
    """The channel of a swarm's parameters A0, A1, c1, ...: amplitudes of 0 or more, phases within -pi .. pi."""
    offset, *rest = (float(value) for value in parameters)
    pairs = zip(orders, rest[::2], rest[1::2], strict=True)
    return ChannelModel(offset, {order: Harmonic(amplitude, phase) for order, amplitude, phase in pairs}).canonical


def particle_swarm(
    samples: PeriodSamples,
    orders: tuple[int, ...] = USUAL_ORDERS,
    seed: int = 1,
    inertia_rule: str = CORRECTED,
    settings: SwarmSettings | None = None,
) -> IdentifiedParameters:
    """Offset, amplitudes and phases of both channels, each searched for by a swarm of its own.

    `inertia_rule`: "corrected" or "printed", when no `settings` are given. Raises `InputError` when the samples do not
    determine the parameters. `details` hold the settings; whether it converged only a comparison can tell.
    """
    check_samples(samples, orders)
    settings = settings or SwarmSettings(inertia_rule=inertia_rule)
    started = time.perf_counter()
    columns = design_matrix(samples.theta_rad, orders)
    volts = np.stack([samples.sine_v, samples.cosine_v])
    outcome = swarm_search(columns, volts, [[seed, 0], [seed, 1]], settings)
    channels = [channel_of_swarm(each, orders) for each in outcome.parameters]
    seconds = time.perf_counter() - started
    model = SignalModel(*channels, samples.line_count, samples.cosine_sign)
    details = {
        "particles": settings.particles,
        "iterations": settings.iterations,
        "inertia_rule": settings.inertia_rule,
        "seed": seed,
    }
    name = "swarm" if settings.inertia_rule == CORRECTED else "swarm-printed"
    return identified(samples, model, name, columns.shape[1], seconds, details)
