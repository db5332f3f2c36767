"""Captures in a file, written as they arrive: CSV, or HDF5 with units and provenance as attributes.

A killed process loses nothing that was received: every batch is on the disk before the next is taken. A file that
exists is never written over.
"""

import csv
import os
from pathlib import Path

import h5py
import numpy as np

from arcref.input_error import InputError
from arcref.instrument.captures import CAPTURE_DTYPE

UNITS = {
    "time_s": "s",
    "angle_deg": "deg",
    "position_counts": "counts",
    "raw_position_counts": "counts",
    "time_samples": "sample periods",
    "flags": "",
    "lost_before": "captures",
}

DATASET = "captures"
"""Name of the data set in an HDF5 file."""


def open_capture_file(path: Path, provenance: dict) -> "CsvCaptures | Hdf5Captures":
    """A new file, by its suffix: .csv, .h5 or .hdf5. Raises `InputError` for others, and when it exists already."""
    kinds = {".csv": CsvCaptures, ".h5": Hdf5Captures, ".hdf5": Hdf5Captures}
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise InputError(f"{path}: the name of a capture file must end in .csv, .h5 or .hdf5")
    try:
        # Made here and never replaced: what was measured before must not be lost.
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o644))
    except FileExistsError:
        raise InputError(f"{path}: exists already; captures are never written over, choose another name") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None
    return kind(path, provenance)


class CsvCaptures:
    """A run file of captures: `# key: value` lines, one line of column names, one row for each capture."""

    def __init__(self, path: Path, provenance: dict):
        self._file = open(path, "w", newline="", encoding="utf-8")  # noqa: SIM115 - closed by `close`
        for key, value in provenance.items():
            self._file.write(f"# {key}: {' '.join(str(value).split())}\n")
        self._writer = csv.writer(self._file, lineterminator="\n")
        self._writer.writerow(CAPTURE_DTYPE.names)
        self._flush()

    def append(self, captures: np.ndarray) -> None:
        """Add captures and put them on the disk. Raises OSError when the disk is full."""
        self._writer.writerows(
            (f"{row['time_s']:.9f}", f"{row['angle_deg']:.8f}", *(int(row[name]) for name in CAPTURE_DTYPE.names[2:]))
            for row in captures
        )
        self._flush()

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _flush(self) -> None:
        self._file.flush()
        os.fsync(self._file.fileno())


class Hdf5Captures:
    """An HDF5 file with one data set, made when the capture ends.

    HDF5 does not survive a killed writer, so until then the captures stand beside it in a CSV file, `X.h5.csv`, which
    is removed only when the HDF5 file is whole.
    """

    def __init__(self, path: Path, provenance: dict):
        self._path, self._provenance = path, provenance
        self._journal_path = path.with_name(path.name + ".csv")
        self._journal = open_capture_file(self._journal_path, provenance)

    def append(self, captures: np.ndarray) -> None:
        """Add captures and put them on the disk. Raises OSError when the disk is full."""
        self._journal.append(captures)

    def close(self) -> None:
        """Make the HDF5 file out of the CSV file."""
        self._journal.close()
        captures, _ = read_capture_file(self._journal_path)
        with h5py.File(self._path, "w") as file:
            data = file.create_dataset(DATASET, data=captures)
            for name, unit in UNITS.items():
                data.attrs[f"unit of {name}"] = unit
            for key, value in self._provenance.items():
                file.attrs[key] = str(value)
        self._journal_path.unlink()


def read_capture_file(path: Path) -> tuple[np.ndarray, dict[str, str]]:
    """Captures, an array of `CAPTURE_DTYPE`, and the provenance of a file. Raises `InputError` when it is none."""
    if path.suffix.lower() == ".csv":
        return _read_csv(path)
    try:
        with h5py.File(path, "r") as file:
            if DATASET not in file or file[DATASET].dtype != CAPTURE_DTYPE:
                raise InputError(f"{path}: has no data set {DATASET!r} of captures")
            return file[DATASET][:], {key: str(value) for key, value in file.attrs.items()}
    except OSError as error:
        raise InputError(f"{path}: cannot be read as HDF5 ({error})") from None


def _read_csv(path: Path) -> tuple[np.ndarray, dict[str, str]]:
    # Imported here: the reader of run files is not needed for writing.
    from arcref.run_file import read_run_file

    run = read_run_file(path, CAPTURE_DTYPE.names)
    captures = np.zeros(len(run.rows), CAPTURE_DTYPE)
    for name in CAPTURE_DTYPE.names:
        values = run[name]
        if CAPTURE_DTYPE[name].kind != "f":
            bad = np.flatnonzero(values != np.rint(values))
            if bad.size:
                raise run.error(
                    f"{values[bad[0]]:g} was found, a whole number was expected", reading=bad[0], column=name
                )
        captures[name] = values
    return captures, run.metadata
