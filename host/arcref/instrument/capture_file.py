"""Captures in a file, written as they arrive: CSV, or HDF5 with units and provenance as attributes.

A killed process loses nothing that was received: every batch is on the disk before the next is taken. A file that
exists is never written over, and one that got no capture is taken away again.
"""

import os
from pathlib import Path

import h5py
import numpy as np

from arcref.atomic_file import write_bytes
from arcref.input_error import InputError
from arcref.instrument.captures import CAPTURE_DTYPE
from arcref.instrument.recorded_captures import DATASET, journal_of, read_capture_file
from arcref.instrument.uninterrupted import uninterrupted

UNITS = {
    "time_s": "s",
    "angle_deg": "deg",
    "position_counts": "counts",
    "raw_position_counts": "counts",
    "time_samples": "sample periods",
    "flags": "",
    "lost_before": "captures",
}


def open_capture_file(path: Path, provenance: dict) -> "CsvCaptures | Hdf5Captures":
    """A new file, by its suffix: .csv, .h5 or .hdf5. Raises `InputError` for others, when it exists already, and when
    it cannot be written.
    """
    kinds = {".csv": CsvCaptures, ".h5": Hdf5Captures, ".hdf5": Hdf5Captures}
    kind = kinds.get(path.suffix.lower())
    if kind is None:
        raise InputError(f"{path}: the name of a capture file must end in .csv, .h5 or .hdf5")
    return kind(path, provenance)


class CsvCaptures:
    """A run file of captures: `# key: value` lines, one line of column names, one row for each capture.

    `captures`: rows that are on the disk.
    """

    def __init__(self, path: Path, provenance: dict):
        self.captures = 0
        self._path = path
        self._file = _new_file(path)
        lines = [f"# {key}: {' '.join(str(value).split())}" for key, value in provenance.items()]
        try:
            self._put("\n".join([*lines, ",".join(CAPTURE_DTYPE.names)]) + "\n")
        except _DiskFull as full:
            self.close()
            raise InputError(f"{path}: {full}") from full

    def append(self, captures: np.ndarray) -> None:
        """Add captures and put them on the disk. Ctrl-C waits until that is done.

        Raises `InputError` when the disk is full; the rows that found room stand in the file, and none in part.
        """
        rows = (
            (
                f"{row['time_s']:.9f}",
                f"{row['angle_deg']:.8f}",
                *(str(int(row[name])) for name in CAPTURE_DTYPE.names[2:]),
            )
            for row in captures
        )
        before = self.captures
        with uninterrupted():
            try:
                self._put("".join(",".join(row) + "\n" for row in rows))
            except _DiskFull as full:
                self.captures += full.lines
                left = before + len(captures) - self.captures
                room = f"{self.captures} captures stand in it, {left} more found no room"
                raise InputError(f"{self._path}: {full}; {room}") from full
            self.captures += len(captures)

    def close(self) -> None:
        """Close the file; without a capture in it, it goes."""
        os.close(self._file)
        if not self.captures:
            self._path.unlink()

    def _put(self, text: str) -> None:
        """Bring whole lines to the disk."""
        data, written = text.encode(), 0
        before = os.lseek(self._file, 0, os.SEEK_CUR)
        try:
            while written < len(data):
                written += os.write(self._file, data[written:])
            os.fsync(self._file)
        except OSError as error:
            whole = data[:written].rfind(b"\n") + 1
            os.ftruncate(self._file, before + whole)
            os.lseek(self._file, before + whole, os.SEEK_SET)
            raise _DiskFull(f"cannot be written ({error.strerror})", data[:whole].count(b"\n")) from error


class Hdf5Captures:
    """An HDF5 file with one data set, made when the capture ends.

    HDF5 does not survive a killed writer, so until then the captures stand beside it in a CSV file, `X.h5.csv`, which
    is removed only when the HDF5 file is whole, and is what stays when the disk was full.
    """

    def __init__(self, path: Path, provenance: dict):
        self._path, self._provenance = path, provenance
        self._disk_full = False
        os.close(_new_file(path))  # the name is taken now, not when the capture is over
        self._journal_path = journal_of(path)
        try:
            self._journal = CsvCaptures(self._journal_path, provenance)
        except InputError:
            path.unlink()
            raise

    @property
    def captures(self) -> int:
        """Captures that are on the disk."""
        return self._journal.captures

    def append(self, captures: np.ndarray) -> None:
        """Add captures and put them on the disk. Raises as `CsvCaptures.append` does."""
        try:
            self._journal.append(captures)
        except InputError:
            self._disk_full = True
            raise

    def close(self) -> None:
        """Make the HDF5 file out of the CSV file. Raises `InputError`, and keeps that, when there is no room."""
        self._journal.close()
        if not self.captures or self._disk_full:
            self._path.unlink()
            return
        captures = read_capture_file(self._journal_path).captures
        try:
            write_bytes(self._path, _hdf5(captures, self._provenance))
        except InputError as error:
            self._path.unlink(missing_ok=True)
            raise InputError(f"{error}; the captures are in {self._journal_path}") from error
        self._journal_path.unlink()


class _DiskFull(InputError):
    """`lines` whole lines found room before it was."""

    def __init__(self, problem: str, lines: int):
        super().__init__(problem)
        self.lines = lines


def _new_file(path: Path) -> int:
    """Descriptor of a file that did not exist. Raises `InputError`."""
    try:
        # Made here and never replaced: what was measured before must not be lost.
        return os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY | getattr(os, "O_BINARY", 0), 0o666)
    except FileExistsError:
        raise InputError(f"{path}: exists already; captures are never written over, choose another name") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from None


def _hdf5(captures: np.ndarray, provenance: dict) -> bytes:
    # Made in memory: the library does not survive a full disk.
    with h5py.File("captures", "w", driver="core", backing_store=False) as file:
        data = file.create_dataset(DATASET, data=captures)
        for name, unit in UNITS.items():
            data.attrs[f"unit of {name}"] = unit
        for key, value in provenance.items():
            file.attrs[key] = str(value)
        file.flush()
        return file.id.get_file_image()
