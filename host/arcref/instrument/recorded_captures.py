"""Captures read back from a file that `arcref capture` wrote."""

from dataclasses import dataclass, field
from pathlib import Path

import h5py
import numpy as np

from arcref.angle import COUNTS_PER_TURN, wrapped
from arcref.input_error import InputError
from arcref.instrument.captures import CAPTURE_DTYPE
from arcref.link.capture_record import CORRECTED_BITS
from arcref.run_file import read_run_file

DATASET = "captures"
"""Name of the data set in an HDF5 file."""

UNCERTAINTY_KEY = "calibration_expanded_uncertainty"
"""Where the provenance says what the ROM in the instrument stated, "0.31 arcsec (k=2)" for instance."""

MOST_LOST = 2**32
"""The instrument counts lost captures modulo this."""

LARGEST_CORRECTION = 1 << CORRECTED_BITS - 1
"""Counts between corrected and raw position that a capture record can hold."""

ANGLE_TOLERANCE_DEG = 1e-6
"""How far `angle_deg` may be from what `position_counts` says: it is written with 8 decimals."""


@dataclass(frozen=True, eq=False)
class RecordedCaptures:
    """`captures`: an array of `CAPTURE_DTYPE`; `provenance`: what the file says about itself; `rows`: of each capture
    the line in a CSV file, None in HDF5.
    """

    path: Path
    captures: np.ndarray
    provenance: dict[str, str]
    rows: tuple[int, ...] | None = field(default=None, repr=False)

    def error(self, problem: str, capture: int, column: str) -> InputError:
        """The error for a capture, counted from 0."""
        if self.rows is None:
            return InputError.at(self.path, problem, column=f"{column}[{capture}]")
        return InputError.at(self.path, problem, row=self.rows[capture], column=column)


def journal_of(path: Path) -> Path:
    """The CSV file in which the captures stand until the HDF5 file `path` is made."""
    return path.with_name(path.name + ".csv")


def read_capture_file(path: Path) -> RecordedCaptures:
    """Read CSV or HDF5. Raises `InputError` when the file cannot be read, holds no captures, or contradicts itself."""
    run = _read_csv(path) if path.suffix.lower() == ".csv" else _read_hdf5(path)
    captures = run.captures
    lost = captures["lost_before"]
    _check(run, "lost_before", (lost < -1) | (lost > MOST_LOST), f"-1 .. {MOST_LOST} was expected")
    _check(run, "time_s", np.diff(captures["time_s"], prepend=-np.inf) <= 0, "times that increase were expected")
    stated = captures["position_counts"] % COUNTS_PER_TURN * (360.0 / COUNTS_PER_TURN)
    angle = captures["angle_deg"]
    is_off = (np.abs(wrapped(angle - stated)) > ANGLE_TOLERANCE_DEG) | (np.abs(angle) > 360.0)
    _check(run, "angle_deg", is_off, "it is not the angle of its position_counts")
    correction = captures["position_counts"] - captures["raw_position_counts"]
    _check(run, "raw_position_counts", np.abs(correction) > LARGEST_CORRECTION, "it is too far from position_counts")
    try:
        rate_hz = float(run.provenance.get("sample_rate_hz", ""))
    except ValueError:
        return run  # not stated: time_s stands alone
    late = np.abs(captures["time_s"] * rate_hz - captures["time_samples"])
    _check(run, "time_samples", ~(late < 0.5 + 1e-9 * rate_hz), f"it is not time_s at {rate_hz:g} samples/s")
    return run


def _check(run: RecordedCaptures, column: str, is_bad: np.ndarray, expected: str) -> None:
    bad = np.flatnonzero(is_bad)
    if bad.size:
        raise run.error(f"{run.captures[column][bad[0]]:g} was found, {expected}", int(bad[0]), column)


def _read_csv(path: Path) -> RecordedCaptures:
    run = read_run_file(path, CAPTURE_DTYPE.names)
    captures = np.zeros(len(run.rows), CAPTURE_DTYPE)
    for name in CAPTURE_DTYPE.names:
        values = run[name]
        if CAPTURE_DTYPE[name].kind != "f":
            limits = np.iinfo(CAPTURE_DTYPE[name])
            # A float64 tells whole numbers apart up to 2^53, and no count or time is larger.
            least, most = max(limits.min, -(2**53)), min(limits.max, 2**53)
            bad = np.flatnonzero((values != np.rint(values)) | (values < least) | (values > most))
            if bad.size:
                problem = f"{values[bad[0]]:g} was found, a whole number in {least} .. {most} was expected"
                raise run.error(problem, reading=int(bad[0]), column=name)
        captures[name] = values
    return RecordedCaptures(path, captures, run.metadata, run.rows)


def _read_hdf5(path: Path) -> RecordedCaptures:
    if path.is_file() and not path.stat().st_size and journal_of(path).is_file():
        raise InputError(f"{path}: its capture was cut short; what was received is in {journal_of(path)}")
    try:
        with h5py.File(path, "r") as file:
            data = file.get(DATASET)
            if not isinstance(data, h5py.Dataset) or data.dtype != CAPTURE_DTYPE or data.ndim != 1:
                raise InputError(f"{path}: has no data set {DATASET!r} as `arcref capture` writes it")
            run = RecordedCaptures(path, data[:], {key: str(value) for key, value in file.attrs.items()})
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except (OSError, RuntimeError, ValueError) as error:
        raise InputError(f"{path}: cannot be read as HDF5 ({' '.join(str(error).split())})") from None
    for name in ("time_s", "angle_deg"):
        _check(run, name, ~np.isfinite(run.captures[name]), "a finite number was expected")
    return run
