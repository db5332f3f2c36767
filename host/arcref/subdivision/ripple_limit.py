"""What ripple of the speed does to edge timing: found by putting it through the reduction of the run at hand."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import ARCSEC_PER_TURN, COUNTS_PER_TURN, LINES_PER_TURN
from arcref.subdivision.edge_timing import WaveSolver
from arcref.subdivision.line_wave import wave_columns

TOLERANCE_ARCSEC = 0.05
"""Error of the curve at which edge timing counts as failed."""

ORDERS = (1, 10, 100, 500, 1000, 1500, 2000, 3000, 3900, 4000, 4080, 4095, 4096, 4097, 4200, 8191, 8192, 12288, 16384)
"""Orders of the turn, ripples a turn, that are tried."""

_PHASES = 256


@dataclass(frozen=True)
class RippleLimit:
    """`order`: ripples a turn; `false_arcsec`: largest error of the curve from 1 % of ripple (amplitude of speed)."""

    order: int
    false_arcsec: float

    @property
    def limit_percent(self) -> float:
        """Ripple that makes an error of `TOLERANCE_ARCSEC`, in percent of the speed."""
        return TOLERANCE_ARCSEC / max(self.false_arcsec, 1e-12)


def ripple_limits(solver: WaveSolver, orders: tuple[int, ...] = ORDERS) -> tuple[RippleLimit, ...]:
    """What 1 % of ripple of each order adds to the curve of this run, at the worst phase of the ripple."""
    angle = np.multiply.outer(solver.edges.reading_counts * (2 * np.pi / COUNTS_PER_TURN), np.array(orders))
    # Speed 1 + a cos(m angle) puts the shaft ahead by a sin(m angle) / m radians: the reading is late by as much.
    ahead = 0.01 * ARCSEC_PER_TURN / (2 * np.pi) / np.array(orders)
    phases = np.arange(_PHASES) * (2 * np.pi / _PHASES)
    columns = wave_columns(phases, solver.columns.shape[1] // 2)
    false = [columns @ solver.coefficients(wave(angle) * ahead) for wave in (np.sin, np.cos)]
    largest = np.hypot(*false).max(axis=0)
    return tuple(RippleLimit(order, float(value)) for order, value in zip(orders, largest, strict=True))


def in_step(limits: tuple[RippleLimit, ...]) -> RippleLimit:
    """The ripple in step with the lines, once a line: nothing within the run tells it from an error."""
    return next(limit for limit in limits if limit.order == LINES_PER_TURN)
