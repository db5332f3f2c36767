"""Run files of `arcref calibrate subdivision`: which of the three kinds a file is, told by its columns."""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from arcref.calibration.calibration_result import CalibrationResult
from arcref.calibration.metadata_key import SUBDIVISION
from arcref.calibration.metadata_keys import known_keys
from arcref.run_file import RunFile, read_run_file

SAMPLE, TIME, SINE, COSINE = "sample", "time_s", "sine_v", "cosine_v"
COUNT, AUTOCOLLIMATOR = "count", "autocollimator_x_arcsec"


@dataclass(frozen=True)
class SubdivisionOptions:
    """What the command's options say to a reduction; each takes what concerns it.

    `method`: name of the way to identify the signals; `orders`: harmonics of the signal model; `compare`: by every way;
    `seed`: of the particle swarm; `plots`: draw them, for a report is wanted.
    """

    method: str = "least-squares"
    orders: tuple[int, ...] = (1, 3, 5)
    compare: bool = False
    seed: int = 1
    plots: bool = False


@dataclass(frozen=True)
class RunKind:
    """A kind of run: its `name`, the sets of columns it may have, and `module:function` that reduces it.

    The function takes (RunFile, SubdivisionOptions) and gives a `CalibrationResult` whose curve is a
    `SubdivisionCurve`. It raises `InputError` for a run that cannot be used.
    """

    name: str
    columns: tuple[tuple[str, ...], ...]
    reduction: str

    def reduce(self, run: RunFile, options: SubdivisionOptions) -> CalibrationResult:
        """Reduce `run`, which must have the columns of this kind."""
        module, _, function = self.reduction.partition(":")
        return getattr(import_module(module), function)(run, options)


SAMPLES = RunKind(
    "samples",
    ((SAMPLE, SINE, COSINE), (TIME, SINE, COSINE)),
    "arcref.subdivision.samples_result:samples_result",
)
EDGE_TIMES = RunKind("edge times", ((COUNT, TIME),), "arcref.subdivision.edge_timing_result:edge_timing_result")
FINE_SCAN = RunKind("fine scan", ((COUNT, AUTOCOLLIMATOR),), "arcref.subdivision.fine_scan_result:fine_scan_result")

RUN_KINDS = (SAMPLES, EDGE_TIMES, FINE_SCAN)
"""Every kind of run; the first whose columns a file has is taken."""


def read_subdivision_run(path: Path) -> tuple[RunKind, RunFile]:
    """Read a run file and tell its kind by its columns.

    Raises `InputError` for all that `read_run_file` refuses, and for columns that are those of no kind.
    """
    first, *others = (names for kind in RUN_KINDS for names in kind.columns)
    run = read_run_file(path, first, (), known_keys(SUBDIVISION), others)
    kind = next(kind for kind in RUN_KINDS if set(run.columns) in map(set, kind.columns))
    return kind, run
