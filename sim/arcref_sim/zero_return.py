"""The zero-return test: full turns forward, the same turns back, and every count must be there again.

The synthetic encoder starts a little before its zero mark, so that the first index homes, makes the turns forward,
goes a little past the last index and returns. The Verilated core counts and corrects, an SPI controller reads the
angle back, and a second thread compares every word with the golden model and with the truth.
"""

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numpy as np

from arcref import __version__
from arcref.angle import COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.zero_return.result import CORRECTION_LIMIT_COUNTS, TWO_TABLES_LIMIT_COUNTS, ZeroReturnResult
from arcref_gateware.golden.core import CoreModel
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_sim.core_log import Comparison, CoreLog
from arcref_sim.encoder import EncoderPiece, SyntheticEncoder
from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.spi_plan import SNAPSHOT_CLOCKS, SpiPlan, decode_frames
from arcref_sim.truth_check import TruthCheck
from arcref_sim.verilated_core import CompiledCore, VerilatedCore
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER

WORD_CLOCK_HZ = 200e6
"""Word clock of the fastest board; with four samples a word that is 800 M samples/s."""

APPROACH_COUNTS = 5000
"""How far before the zero mark the shaft starts, and how far past the last one it turns back."""

REST_WORDS = FIRST_CORRECTED_WORD + 64
"""Words at rest in the beginning, while the core checks its tables."""

WORDS_PER_SPI_FRAME = 20011
"""Word clocks from one SPI frame to the next: 10 kHz, and prime, so that the frames fall anywhere among the samples."""

FEWEST_SPI_FRAMES = 20
"""Frames in a run too short for the usual distance."""

WORDS_OF_SPI_FRAME = 700
"""Word clocks that a frame takes at most, with room to spare."""

PIECES_WAITING = 3


def zero_return_motion(
    graduation: GraduationError, speed_rps: float, revolutions: int, word_clock_hz: float = WORD_CLOCK_HZ
) -> Motion:
    """The shaft's motion: rest, forward, reverse. It turns back in the middle of a count, so no edge comes twice."""
    start, turning = graduation.true_at_reading(
        np.array([-APPROACH_COUNTS + 0.5, revolutions * COUNTS_PER_TURN + APPROACH_COUNTS + 0.5])
    )
    turns = float(turning - start) / COUNTS_PER_TURN
    motion = Motion(float(start)).standstill(REST_WORDS / word_clock_hz)
    return motion.constant_speed(speed_rps, turns=turns).constant_speed(-speed_rps, turns=turns)


def run_zero_return(
    rom: CorrectionRom,
    curve: Callable,
    *,
    speed_rps: float = 10.0,
    revolutions: int = 10,
    samples_per_word: int = 4,
    word_clock_hz: float = WORD_CLOCK_HZ,
    folder: Path = DEFAULT_BUILD_FOLDER,
    knots: int = 1 << 15,
    progress: Callable[[float], None] = lambda part: None,
) -> ZeroReturnResult:
    """Run the test and return all it found; whether that passes, `result.passed` says.

    `curve` is the encoder's true error in arc seconds as a function of the angle in degrees (array in, array out),
    that is the fitted curve from which `rom` was made. `folder` keeps the compiled core; `knots`: as in
    `GraduationError.from_curve`. `progress` is told the part done, 0 to 1.
    """
    core = VerilatedCore(CompiledCore.of(ReferenceEncoder(rom, samples_per_word), folder))
    graduation = GraduationError.from_curve(curve, knots)
    motion = zero_return_motion(graduation, speed_rps, revolutions, word_clock_hz)
    encoder = SyntheticEncoder(motion, word_clock_hz * samples_per_word, graduation)
    words = encoder.number_of_samples // samples_per_word

    spacing = min(WORDS_PER_SPI_FRAME, words // FEWEST_SPI_FRAMES)
    frame_starts = np.arange(spacing // 2, words - WORDS_OF_SPI_FRAME, spacing)
    core.plan_spi(SpiPlan(frame_starts))
    truth = TruthCheck(encoder, samples_per_word, frame_starts + SNAPSHOT_CLOCKS - core.latency_words)
    checker = _Checker(CoreModel(rom, samples_per_word), truth)
    begun = time.perf_counter()
    # This thread makes the pieces, one runs the core and one checks what it showed.
    with ThreadPoolExecutor(1) as running, ThreadPoolExecutor(1) as checking:
        checks = []
        for piece in encoder.pieces():
            log = running.submit(core.run, piece.changes)
            checks.append(checking.submit(checker.check, piece, log))
            if len(checks) > PIECES_WAITING:
                checks.pop(0).result()  # also raises what went wrong there
            progress(piece.changes.end / encoder.number_of_samples)
        checks.append(checking.submit(checker.check, None, running.submit(core.finish)))
        for check in checks:
            check.result()
    simulation_s = time.perf_counter() - begun

    frames = decode_frames(core.frames())
    pairs = zip(frames, truth.snapshot_positions.tolist(), strict=True)
    wrong = sum(frame is None or frame.position != position for frame, position in pairs)
    before, after = truth.errors()
    return ZeroReturnResult(
        speed_rps=speed_rps,
        revolutions=revolutions,
        samples_per_word=samples_per_word,
        sample_rate_hz=encoder.sample_rate_hz,
        counts=2 * (revolutions * COUNTS_PER_TURN + 2 * APPROACH_COUNTS),
        index_passes=tuple(truth.index_passes),
        illegal_steps=core.output("illegal_steps"),
        lost_counts=truth.lost_counts,
        flags=int(truth.flags),
        shortest_edge_spacing_samples=core.output("shortest_edge_spacing"),
        before=before,
        after=after,
        correction_deviation_counts=truth.correction_deviation_counts,
        spi_frames=len(frames),
        spi_frames_wrong=wrong,
        words=words,
        difference=checker.comparison.difference,
        simulation_s=simulation_s,
        error_over_turn=truth.error_over_turn(),
        waveforms=tuple(truth.waveforms),
        correction_limit_counts=TWO_TABLES_LIMIT_COUNTS if rom.subdivision_table.any() else CORRECTION_LIMIT_COUNTS,
        provenance={
            "arcref_version": __version__,
            "rom_crc32": f"0x{rom.crc32:08X}",
            "rom": rom.provenance,
            "core": {key: value for key, value in core.description.items() if key != "ports"},
        },
    )


class _Checker:
    """What the second thread does with each piece."""

    def __init__(self, model: CoreModel, truth: TruthCheck):
        self._model, self._truth = model, truth
        self.comparison = Comparison()

    def check(self, piece: EncoderPiece | None, shown: Future[CoreLog]) -> None:
        """Compare one piece with what the core will have shown of it; None for the end of the run."""
        log = shown.result()
        self.comparison.add(log, None if piece is None else self._model.run(piece.changes))
        self._truth.add(piece, log)
