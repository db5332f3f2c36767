"""Running the zero-return test: every sample of A, B and Z into the Verilated core, with a watch beside it."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from time import perf_counter

from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.graduation import GraduationError
from arcref_sim.spi_plan import SNAPSHOT_CLOCKS
from arcref_sim.verilated_core import DEFAULT_BUILD_FOLDER, VerilatedCore
from arcref_sim.zero_return import ZeroReturnPlan, ZeroReturnResult
from arcref_sim.zero_return_watch import ZeroReturnWatch

PIECES_IN_FLIGHT = 3
"""Pieces of input that may wait for the core or for their check, so that memory stays small."""


def run_zero_return(
    plan: ZeroReturnPlan, progress: Callable[[float], None] = lambda part: None, folder=DEFAULT_BUILD_FOLDER
) -> ZeroReturnResult:
    """Build the core if need be, run the plan and judge it. `progress` is told the part done, 0..1."""
    core = VerilatedCore(ReferenceEncoder(plan.rom, plan.samples_per_word), folder)
    graduation = GraduationError.from_curve(plan.error_arcsec)
    encoder = SyntheticEncoder(plan.motion(), plan.sample_rate_hz, graduation)
    result = ZeroReturnResult(plan, words=encoder.number_of_samples // plan.samples_per_word)
    spi = plan.spi_plan(result.words)
    core.plan_spi(spi)
    watch = ZeroReturnWatch(result, encoder, spi.start + SNAPSHOT_CLOCKS - core.latency_words)
    started = perf_counter()
    with ThreadPoolExecutor(1) as running, ThreadPoolExecutor(1) as checking:
        flying: list[Future] = []
        for piece in encoder.pieces():
            shown = running.submit(core.run, piece.changes)
            flying.append(checking.submit(lambda piece=piece, shown=shown: watch.piece(piece, shown.result())))
            if len(flying) > PIECES_IN_FLIGHT:
                flying.pop(0).result()
            progress(piece.changes.end / encoder.number_of_samples)
        for future in flying:
            future.result()
    result.seconds = perf_counter() - started
    watch.finish(core)
    return result
