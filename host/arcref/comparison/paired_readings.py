"""Readings of an encoder under test, each beside the reference's capture at the same strobe."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.angle import COUNTS_PER_TURN
from arcref.input_error import InputError
from arcref.instrument.capture_file import read_capture_file
from arcref.run_file import read_run_file

FEWEST_PAIRS = 20

LARGEST_DIFFERENCE_DEG = 5.0
"""Readings that differ by more, after their mean difference, are of other strobes or of another scale."""


@dataclass(frozen=True, eq=False)
class PairedReadings:
    """Strobes that both encoders read, in order of time.

    `angle_deg`: the reference's corrected angle, 0..360; `speed_rps`: its speed at the strobe, signed;
    `difference_arcsec`: reading of the encoder under test less reference, within half a turn; all float64[n].
    `provenance`: of both files; `reference_expanded_arcsec`: what the reference states about itself (k=2), or None.
    """

    angle_deg: np.ndarray
    speed_rps: np.ndarray
    difference_arcsec: np.ndarray
    provenance: dict
    reference_expanded_arcsec: float | None = None

    def __len__(self):
        return len(self.angle_deg)


def read_pairs(capture_path: Path, readings_path: Path) -> PairedReadings:
    """The strobes of a capture file and of a file with the column `reading_deg`, and perhaps `strobe`.

    Row k of the readings belongs to strobe k, counted from 0 at the first capture, captures that were lost too; a
    column `strobe` says otherwise. Raises `InputError` for files that do not belong together: too few common strobes,
    another sense of rotation, readings of another scale, a gap in the captures whose length nobody knows.
    """
    captures, capture_metadata = read_capture_file(capture_path)
    run = read_run_file(readings_path, ("reading_deg",), ("strobe",))
    if len(captures) < FEWEST_PAIRS:
        raise InputError.at(capture_path, f"{len(captures)} captures, at least {FEWEST_PAIRS} were expected")
    strobe = _strobe_numbers(capture_path, captures)
    of_reading = np.arange(len(run.rows)) if "strobe" not in run.columns else _whole(run, "strobe")
    both, in_captures, in_readings = np.intersect1d(strobe, of_reading, return_indices=True)
    if len(both) < FEWEST_PAIRS:
        problem = f"{len(both)} strobes in common with {capture_path}, at least {FEWEST_PAIRS} were expected"
        raise InputError.at(readings_path, problem)
    speed_rps = _speed_rps(capture_path, captures)[in_captures]
    angle_deg = captures["angle_deg"][in_captures]
    reading_deg = run["reading_deg"][in_readings]
    _check_sense(run, in_readings, angle_deg, reading_deg)
    scatter_deg = _about_mean_deg(reading_deg - angle_deg)
    worst = int(np.argmax(np.abs(scatter_deg)))
    if abs(scatter_deg[worst]) > LARGEST_DIFFERENCE_DEG:
        problem = (
            f"differs by {scatter_deg[worst]:+.3f} deg from the reference beyond the mean difference; within "
            f"{LARGEST_DIFFERENCE_DEG:g} deg was expected: are these the strobes of {capture_path.name}?"
        )
        raise run.error(problem, reading=int(in_readings[worst]), column="reading_deg")
    provenance = {
        "captures": {"file": capture_path.name, **capture_metadata},
        "readings": run.file.record | {"metadata": run.metadata},
        "strobes": len(both),
        "captures_without_reading": int(len(captures) - len(both)),
        "readings_without_capture": int(len(run.rows) - len(both)),
    }
    expanded = _expanded_arcsec(capture_metadata)
    return PairedReadings(angle_deg, speed_rps, _wrapped_deg(reading_deg - angle_deg) * 3600.0, provenance, expanded)


def join_pairs(runs: list[PairedReadings]) -> PairedReadings:
    """Several runs as one: at several speeds, for instance. The encoder stays mounted, so one zero serves them all."""
    stated = [run.reference_expanded_arcsec for run in runs]
    zero_deg = _mean_deg(runs[0].difference_arcsec / 3600.0)
    difference_deg = np.concatenate([run.difference_arcsec for run in runs]) / 3600.0
    return PairedReadings(
        np.concatenate([run.angle_deg for run in runs]),
        np.concatenate([run.speed_rps for run in runs]),
        _wrapped_deg(difference_deg - zero_deg) * 3600.0,
        {"runs": [run.provenance for run in runs], "zero_deg": zero_deg},
        None if None in stated else max(stated),
    )


def _strobe_numbers(path: Path, captures: np.ndarray) -> np.ndarray:
    unknown = np.flatnonzero(captures["lost_before"] < 0)
    if unknown.size and unknown[0] > 0:
        problem = "captures were lost before this one and nobody knows how many; strobes behind it cannot be counted"
        raise InputError.at(path, problem, column=f"lost_before[{unknown[0]}]")
    lost = np.maximum(captures["lost_before"], 0)
    lost[0] = 0  # what was lost before the first capture was before the first strobe
    return np.cumsum(lost + 1) - 1


def _whole(run, column: str) -> np.ndarray:
    values = run[column]
    bad = np.flatnonzero((values != np.rint(values)) | (values < 0))
    if bad.size:
        problem = f"is {values[bad[0]]:g}, the number of a strobe was expected, 0 or more"
        raise run.error(problem, reading=int(bad[0]), column=column)
    repeated = np.flatnonzero(np.diff(values) <= 0)
    if repeated.size:
        reading = int(repeated[0]) + 1
        raise run.error(f"is {values[reading]:g}, increasing numbers were expected", reading=reading, column=column)
    return values.astype(np.int64)


def _speed_rps(path: Path, captures: np.ndarray) -> np.ndarray:
    """Speed at each capture out of its neighbours: second order at uneven times."""
    time_s = captures["time_s"]
    back = np.flatnonzero(np.diff(time_s) <= 0)
    if back.size:
        problem = f"is {time_s[back[0] + 1]:g} s, times that increase were expected"
        raise InputError.at(path, problem, column=f"time_s[{back[0] + 1}]")
    return np.gradient(captures["raw_position_counts"] / COUNTS_PER_TURN, time_s)


def _check_sense(run, in_readings, angle_deg: np.ndarray, reading_deg: np.ndarray) -> None:
    forward = np.abs(_about_mean_deg(reading_deg - angle_deg))
    reverse = np.abs(_about_mean_deg(reading_deg + angle_deg))
    if np.median(reverse) < 0.1 * np.median(forward):
        problem = "the readings fall while the reference rises: turn the sign of reading_deg"
        raise run.error(problem, reading=int(in_readings[0]), column="reading_deg")


def _wrapped_deg(difference_deg: np.ndarray) -> np.ndarray:
    """The same angles in -180..180."""
    return np.mod(difference_deg + 180.0, 360.0) - 180.0


def _mean_deg(difference_deg: np.ndarray) -> float:
    """Mean direction of angles."""
    return float(np.degrees(np.angle(np.mean(np.exp(1j * np.radians(difference_deg))))))


def _about_mean_deg(difference_deg: np.ndarray) -> np.ndarray:
    """Angles about their mean direction, -180..180."""
    return _wrapped_deg(difference_deg - _mean_deg(difference_deg))


def _expanded_arcsec(metadata: dict) -> float | None:
    """The number in "0.31 arcsec (k=2)", which the captures bring from the identity of the ROM."""
    word = metadata.get("calibration_expanded_uncertainty", "").split(" ")[0]
    try:
        return float(word)
    except ValueError:
        return None
