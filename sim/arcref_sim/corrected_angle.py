"""The Verilated core behind an encoder of known optics, and the errors of its corrected angle over turn and line."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_LINE, COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion
from arcref_sim.optics.optical_encoder import OpticalEncoder
from arcref_sim.verilated_core import CompiledCore, VerilatedCore
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER

SAMPLES_PER_WORD = 4
WORD_CLOCK_HZ = 200e6

LINE_CELLS, TURN_CELLS = 256, 720

_APPROACH_COUNTS = 20_000
_REST_WORDS = FIRST_CORRECTED_WORD + 64
_READINGS_APART = 7
"""Prime to the counts of a line, so that every count of it is seen."""


@dataclass(frozen=True, eq=False)
class CorrectedAngle:
    """Errors (core's position - true angle) over one turn, about their mean.

    `rms_arcsec`, `largest_arcsec`: of the corrected angle, the rounding to a count in it; `raw_rms_arcsec`: of the
    angle before correction; `line_arcsec`, `raw_line_arcsec`: float64[256], mean by phase of the reading within the
    line, from which rounding is averaged away; `turn_arcsec`, `raw_turn_arcsec`: float64[720], mean by angle;
    `readings`: how many.
    """

    rms_arcsec: float
    largest_arcsec: float
    raw_rms_arcsec: float
    line_arcsec: np.ndarray
    raw_line_arcsec: np.ndarray
    turn_arcsec: np.ndarray
    raw_turn_arcsec: np.ndarray
    readings: int

    @property
    def within_line_arcsec(self) -> float:
        """Peak to peak of what is left within the line."""
        return float(np.ptp(self.line_arcsec))

    def to_json(self) -> dict:
        """All of it, ready for JSON."""
        values = {name: np.round(v, 6).tolist() if np.ndim(v) else v for name, v in vars(self).items()}
        return values | {"within_line_arcsec": self.within_line_arcsec}


@dataclass(frozen=True, eq=False)
class CorePositions:
    """What the core showed in one turn: `raw`, `corrected` int64[n] in counts, and the true angle float64[n]."""

    raw: np.ndarray
    corrected: np.ndarray
    true: np.ndarray


def run_core(
    encoder: OpticalEncoder,
    rom: CorrectionRom,
    *,
    speed_rps: float = 20.0,
    folder: Path = DEFAULT_BUILD_FOLDER,
    progress: Callable[[float], None] = lambda part: None,
) -> CorePositions:
    """Turn the encoder once forward before a core with `rom`, and keep the core's positions and the true angle.

    Raises RuntimeError when the core raises a fault flag: then its positions say nothing.
    """
    graduation = encoder.graduation()
    start = float(graduation.true_at_reading(-_APPROACH_COUNTS + 0.5))
    motion = Motion(start).standstill(_REST_WORDS / WORD_CLOCK_HZ)
    motion = motion.constant_speed(speed_rps, turns=1.0 + 2 * _APPROACH_COUNTS / COUNTS_PER_TURN)
    rate_hz = SAMPLES_PER_WORD * WORD_CLOCK_HZ
    synthetic = SyntheticEncoder(motion, rate_hz, graduation, encoder.interpolator.waves())
    core = VerilatedCore(CompiledCore.of(ReferenceEncoder(rom, SAMPLES_PER_WORD), folder))
    # The positions are those of the signals a delay ago.
    delay_samples = encoder.interpolator.delay_ns * 1e-9 * rate_hz
    kept, flags = [], Flag(0)
    for log in _logs(core, synthetic, progress):
        flags |= Flag(int(np.bitwise_or.reduce(log.status["flags"], initial=0)))
        positions = log.positions[::_READINGS_APART]
        sample = (positions["word"] + 1) * SAMPLES_PER_WORD - 1 - delay_samples
        kept.append((positions["raw_position"], positions["position"], synthetic.true_angle_at(sample)))
    if flags & ~(Flag.CORRECTION_ACTIVE | Flag.LAST_DIRECTION_REVERSE | Flag.EDGE_SPACING_LIMIT):
        raise RuntimeError(f"the core raised a fault: {flags!r}")
    raw, corrected, true = (np.concatenate(values) for values in zip(*kept, strict=True))
    # Before the zero mark the core counts from its start and does not correct.
    first = int(np.flatnonzero(np.abs(raw + 0.5 - true) < COUNTS_PER_LINE)[0])
    turn = slice(first, first + int(np.searchsorted(raw[first:], raw[first] + COUNTS_PER_TURN)))
    return CorePositions(raw[turn], corrected[turn], true[turn])


def _logs(core: VerilatedCore, synthetic: SyntheticEncoder, progress):
    for piece in synthetic.pieces():
        yield core.run(piece.changes)
        progress(piece.changes.end / synthetic.number_of_samples)
    yield core.finish()


def corrected_angle(positions: CorePositions) -> CorrectedAngle:
    """The errors of a turn."""
    raw, corrected, true = positions.raw, positions.corrected, positions.true
    line_cell = (raw & (COUNTS_PER_LINE - 1)) * LINE_CELLS // COUNTS_PER_LINE
    turn_cell = (raw & (COUNTS_PER_TURN - 1)) * TURN_CELLS // COUNTS_PER_TURN
    rms, largest, line, turn = [], [], [], []
    for position in (raw, corrected):
        error = (position + 0.5 - true) * ARCSEC_PER_COUNT
        error = error - error.mean()
        rms.append(float(np.sqrt(np.mean(error**2))))
        largest.append(float(np.abs(error).max()))
        line.append(_mean_by_cell(line_cell, error, LINE_CELLS))
        turn.append(_mean_by_cell(turn_cell, error, TURN_CELLS))
    return CorrectedAngle(rms[1], largest[1], rms[0], line[1], line[0], turn[1], turn[0], raw.size)


def _mean_by_cell(cell, error, cells: int) -> np.ndarray:
    return np.bincount(cell, error, cells) / np.bincount(cell, minlength=cells)
