"""Identification by the particle swarm of Gao Xu et al. 2013, equations (10) to (15): many searches side by side.

Each particle is a guess of a channel's parameters A0, A1, c1, A3, c3, ... Its velocity is drawn to the best place it
saw and to the best that any saw (12), (13), and clamped to -1 .. 1.8 (14), lopsided as printed. The inertia w is of
the distance l of the particle from the best place of all (15). As printed, with iteration k of kmax,

    w = wmin for l < lmin;  wmax - (l - lmin) (wmax - wmin) k / ((lmax - lmin) kmax);  wmax for l > lmax,

which falls with the distance where its ends rise, and jumps at both. The corrected rule has (lmax - l) for (l - lmin):
it meets wmax at lmax always, and wmin at lmin in the last iteration. The paper gives neither the size of the swarm, nor
kmax, lmin, lmax, c1, c2, nor where the particles start; `SwarmSettings` says what is taken here.

Its stopping rule, a small difference of successive best values, would stop at the first iteration or a little after it,
because the best value often stays the same for an iteration. Here every search runs its kmax iterations.
"""

from dataclasses import dataclass

import numpy as np

CORRECTED, PRINTED = "corrected", "printed"


@dataclass(frozen=True)
class SwarmSettings:
    """Numbers of the search. Lengths of a step and distances are in volts and radians mixed, as in the paper.

    `own`, `common`: c1 and c2, the pull of a particle's own best place and of the best of all; `inertia`: wmin, wmax;
    `velocity`: least and largest; `distance`: lmin and lmax; `inertia_rule`: "corrected" or "printed".
    """

    particles: int = 60
    iterations: int = 2000
    own: float = 2.0
    common: float = 2.0
    inertia: tuple[float, float] = (0.4, 0.9)
    velocity: tuple[float, float] = (-1.0, 1.8)
    distance: tuple[float, float] = (0.1, 5.0)
    inertia_rule: str = CORRECTED


@dataclass(frozen=True, eq=False)
class SwarmOutcome:
    """Best parameters of each search, float64[searches, 1 + 2 orders] as A0, A1, c1, ..., and its sum of squares (V^2).

    `history`: float64[iterations, searches], best sum of squares after each iteration.
    """

    parameters: np.ndarray
    square_v2: np.ndarray
    history: np.ndarray


def inertia(distance, iteration: int, settings: SwarmSettings) -> np.ndarray:
    """Equation (15) for distances of any shape; `iteration` counts from 1 to kmax."""
    (low, high), (near, far) = settings.inertia, settings.distance
    beyond = (far - distance) if settings.inertia_rule == CORRECTED else (distance - near)
    between = high - beyond * ((high - low) * iteration / ((far - near) * settings.iterations))
    return np.where(distance < near, low, np.where(distance > far, high, between))


def coefficients_of(parameters: np.ndarray) -> np.ndarray:
    """Amplitudes and phases as the linear coefficients of the design matrix: A0, A cos c, A sin c, ..."""
    linear = np.empty_like(parameters)
    linear[..., 0] = parameters[..., 0]
    linear[..., 1::2] = parameters[..., 1::2] * np.cos(parameters[..., 2::2])
    linear[..., 2::2] = parameters[..., 1::2] * np.sin(parameters[..., 2::2])
    return linear


class SumOfSquares:
    """Sum over the samples of (samples less model) squared, for any number of guesses at once.

    `columns`: float64[n, p], the design matrix; `volts`: float64[searches, n]. With columns = Q R it is
    |Q^T u - R p|^2 plus what no parameters can reach: the same number from p terms in place of n.
    """

    def __init__(self, columns: np.ndarray, volts: np.ndarray):
        q, self._r = np.linalg.qr(columns)
        self._seen = volts @ q
        self._out_of_reach = np.maximum(0.0, np.sum((volts - self._seen @ q.T) ** 2, axis=-1))

    def __call__(self, parameters: np.ndarray) -> np.ndarray:
        """float64[searches, particles] for guesses float64[searches, particles, p]."""
        missed = self._seen[:, np.newaxis] - coefficients_of(parameters) @ self._r.T
        return np.einsum("spi,spi->sp", missed, missed) + self._out_of_reach[:, np.newaxis]


def swarm_search(columns: np.ndarray, volts: np.ndarray, seeds, settings: SwarmSettings | None = None) -> SwarmOutcome:
    """Search for the parameters of one channel, once for each of `seeds`, all side by side.

    `columns`: design matrix float64[n, p]; `volts`: float64[n], or float64[searches, n] for other samples to each seed.
    A search depends on its seed and its samples alone, not on those beside it.
    """
    settings = settings or SwarmSettings()
    generators = [np.random.default_rng(seed) for seed in seeds]
    volts = np.broadcast_to(volts, (len(generators), columns.shape[0]))
    square_of = SumOfSquares(columns, volts)
    shape = (len(generators), settings.particles, columns.shape[1])
    place = _start(volts, shape, generators)
    speed = np.zeros(shape)
    best, best_square = place.copy(), square_of(place)
    history = np.empty((settings.iterations, shape[0]))
    pull = np.empty((2, *shape))
    every = np.arange(shape[0])
    for iteration in range(1, settings.iterations + 1):
        leader = best[every, best_square.argmin(axis=1)][:, np.newaxis]
        away = leader - place
        weight = inertia(np.sqrt(np.einsum("spi,spi->sp", away, away)), iteration, settings)
        for own, generator in enumerate(generators):
            pull[:, own] = generator.random((2, *shape[1:]))
        speed *= weight[..., np.newaxis]
        speed += settings.own * pull[0] * (best - place) + settings.common * pull[1] * away
        np.clip(speed, *settings.velocity, out=speed)
        place += speed
        square = square_of(place)
        better = square < best_square
        best[better], best_square[better] = place[better], square[better]
        history[iteration - 1] = best_square.min(axis=1)
    leader = best_square.argmin(axis=1)
    return SwarmOutcome(best[every, leader], best_square[every, leader], history)


def _start(volts: np.ndarray, shape: tuple[int, int, int], generators: list) -> np.ndarray:
    """Offsets within half of the signal's range about zero, amplitudes up to its range either way, any phases."""
    span = np.ptp(volts, axis=-1)
    place = np.stack([generator.random(shape[1:]) for generator in generators])
    place[..., 0] = (place[..., 0] - 0.5) * span[:, np.newaxis]
    place[..., 1::2] = (2 * place[..., 1::2] - 1) * span[:, np.newaxis, np.newaxis]
    place[..., 2::2] *= 2 * np.pi
    return place
