"""Readings of an encoder under test, each beside the reference's capture at the same strobe."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.angle import COUNTS_PER_TURN, wrapped
from arcref.flags import FAULT_FLAGS, Flag, describe_faults
from arcref.input_error import InputError
from arcref.instrument.recorded_captures import UNCERTAINTY_KEY, RecordedCaptures, read_capture_file
from arcref.run_file import read_run_file

FEWEST_PAIRS = 20

MOST_STROBES = 10**12

LARGEST_READING_DEG = 360e6
"""A million turns; far beyond them a number no longer tells the angle within a turn."""

LARGEST_DIFFERENCE_DEG = 5.0
"""Readings that differ by more, after their mean difference, are of other strobes or of another scale."""


@dataclass(frozen=True, eq=False)
class PairedReadings:
    """Strobes that both encoders read, in order of time.

    `angle_deg`: the reference's corrected angle, 0..360; `speed_rps`: its speed at the strobe, signed;
    `difference_arcsec`: reading of the encoder under test less reference, within half a turn; all float64[n].
    `provenance`: of both files; `reference_expanded_arcsec`: what the reference states about itself (k=2), or None;
    `strobe_spacing_s`: the shortest; `cautions`: sentences about what may make the figures wrong.
    """

    angle_deg: np.ndarray
    speed_rps: np.ndarray
    difference_arcsec: np.ndarray
    provenance: dict
    reference_expanded_arcsec: float | None = None
    strobe_spacing_s: float = np.inf
    cautions: tuple[str, ...] = ()

    def __len__(self):
        return len(self.angle_deg)


def read_pairs(capture_path: Path, readings_path: Path) -> PairedReadings:
    """The strobes of a capture file and of a file with the column `reading_deg`, and perhaps `strobe`.

    Row k of the readings belongs to strobe k, counted from 0 at the first capture, captures that were lost too; a
    column `strobe` says otherwise. Raises `InputError` for files that do not belong together: too few common strobes,
    another sense of rotation, readings of another scale, a gap in the captures whose length nobody knows.
    """
    recorded = read_capture_file(capture_path)
    captures, capture_metadata = recorded.captures, recorded.provenance
    run = read_run_file(readings_path, ("reading_deg",), ("strobe",))
    if len(captures) < FEWEST_PAIRS:
        raise InputError.at(capture_path, f"{len(captures)} captures, at least {FEWEST_PAIRS} were expected")
    strobe = _strobe_numbers(recorded)
    of_reading = _whole(run, "strobe") if "strobe" in run.columns else _in_order(run)
    both, in_captures, in_readings = np.intersect1d(strobe, of_reading, return_indices=True)
    if len(both) < FEWEST_PAIRS:
        problem = f"{len(both)} strobes in common with {capture_path}, at least {FEWEST_PAIRS} were expected"
        raise InputError.at(readings_path, problem)
    speed_rps = np.gradient(captures["raw_position_counts"] / COUNTS_PER_TURN, captures["time_s"])[in_captures]
    angle_deg = captures["angle_deg"][in_captures]
    reading_deg = run["reading_deg"][in_readings]
    _refuse_absurd(run)
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
    return PairedReadings(
        angle_deg,
        speed_rps,
        wrapped(reading_deg - angle_deg) * 3600.0,
        provenance,
        _expanded_arcsec(recorded),
        float(np.min(np.diff(captures["time_s"]) / np.diff(strobe))),
        capture_cautions(recorded, in_captures) + _pairing_cautions(run, readings_path, strobe),
    )


def join_pairs(runs: list[PairedReadings]) -> PairedReadings:
    """Several runs as one: at several speeds, for instance. The encoder stays mounted, so one zero serves them all."""
    stated = [run.reference_expanded_arcsec for run in runs]
    zero_deg = _mean_deg(runs[0].difference_arcsec / 3600.0)
    difference_deg = np.concatenate([run.difference_arcsec for run in runs]) / 3600.0
    return PairedReadings(
        np.concatenate([run.angle_deg for run in runs]),
        np.concatenate([run.speed_rps for run in runs]),
        wrapped(difference_deg - zero_deg) * 3600.0,
        {"runs": [run.provenance for run in runs], "zero_deg": zero_deg},
        None if None in stated else max(stated),
        min(run.strobe_spacing_s for run in runs),
        tuple(dict.fromkeys(caution for run in runs for caution in run.cautions)),
    )


def capture_cautions(recorded: RecordedCaptures, chosen) -> tuple[str, ...]:
    """What the flags of the captures at the places `chosen` say against them."""
    flags, name, cautions = recorded.captures["flags"][chosen], recorded.path.name, []
    faulty = flags & int(FAULT_FLAGS) != 0
    if faulty.any():
        faults = ", ".join(describe_faults(int(np.bitwise_or.reduce(flags[faulty]))))
        cautions.append(
            f"{name}: {np.count_nonzero(faulty)} of {len(flags)} captures have a fault flag up ({faults}); the "
            "reference may have lost counts"
        )
    uncorrected = np.count_nonzero(flags & int(Flag.CORRECTION_ACTIVE) == 0)
    if uncorrected:
        cautions.append(
            f"{name}: {uncorrected} of {len(flags)} captures are not corrected; the reference's own error is in these "
            "figures"
        )
    return tuple(cautions)


def _pairing_cautions(run, path: Path, strobe: np.ndarray) -> tuple[str, ...]:
    strobes = int(strobe[-1]) + 1
    if "strobe" in run.columns or len(run.rows) == strobes:
        return ()
    return (
        f"{path.name}: {len(run.rows)} readings for {strobes} strobes, taken in order from the first strobe; if one is "
        "missing in between, number them in a column strobe",
    )


def _in_order(run) -> np.ndarray:
    """Strobe numbers of readings without a column for them."""
    gap = np.flatnonzero(np.diff(run.rows) != 1)
    if gap.size:
        problem = "an empty line stands before this reading; which strobe is it of? Number them in a column strobe"
        raise run.error(problem, reading=int(gap[0]) + 1, column="reading_deg")
    return np.arange(len(run.rows))


def _strobe_numbers(recorded: RecordedCaptures) -> np.ndarray:
    captures = recorded.captures
    unknown = np.flatnonzero(captures["lost_before"][1:] < 0) + 1
    if unknown.size:
        problem = "captures were lost before this one and nobody knows how many; strobes behind it cannot be counted"
        raise recorded.error(problem, int(unknown[0]), "lost_before")
    lost = captures["lost_before"].copy()
    lost[0] = 0  # what was lost before the first capture was before the first strobe
    return np.cumsum(lost + 1) - 1


def _whole(run, column: str) -> np.ndarray:
    values = run[column]
    bad = np.flatnonzero((values != np.rint(values)) | (values < 0) | (values > MOST_STROBES))
    if bad.size:
        problem = f"is {values[bad[0]]:g}, the number of a strobe was expected, 0 .. {MOST_STROBES}"
        raise run.error(problem, reading=int(bad[0]), column=column)
    repeated = np.flatnonzero(np.diff(values) <= 0)
    if repeated.size:
        reading = int(repeated[0]) + 1
        raise run.error(f"is {values[reading]:g}, increasing numbers were expected", reading=reading, column=column)
    return values.astype(np.int64)


def _refuse_absurd(run) -> None:
    values = run["reading_deg"]
    absurd = np.flatnonzero(np.abs(values) > LARGEST_READING_DEG)
    if absurd.size:
        problem = f"is {values[absurd[0]]:g} deg, at most {LARGEST_READING_DEG:g} deg (a million turns) were expected"
        raise run.error(problem, reading=int(absurd[0]), column="reading_deg")


def _check_sense(run, in_readings, angle_deg: np.ndarray, reading_deg: np.ndarray) -> None:
    forward = np.abs(_about_mean_deg(reading_deg - angle_deg))
    reverse = np.abs(_about_mean_deg(reading_deg + angle_deg))
    if np.median(reverse) < 0.1 * np.median(forward):
        problem = "the readings fall while the reference rises: turn the sign of reading_deg"
        raise run.error(problem, reading=int(in_readings[0]), column="reading_deg")


def _mean_deg(difference_deg: np.ndarray) -> float:
    """Mean direction of angles."""
    return float(np.degrees(np.angle(np.mean(np.exp(1j * np.radians(difference_deg))))))


def _about_mean_deg(difference_deg: np.ndarray) -> np.ndarray:
    """Angles about their mean direction, -180..180."""
    return wrapped(difference_deg - _mean_deg(difference_deg))


def _expanded_arcsec(recorded: RecordedCaptures) -> float | None:
    """The number in "0.31 arcsec (k=2)", which the captures bring from the identity of the ROM; None where not stated.

    Raises `InputError` for a number that is no uncertainty.
    """
    stated = recorded.provenance.get(UNCERTAINTY_KEY, "")
    try:
        value = float(stated.split(" ")[0])
    except ValueError:
        return None
    if not 0 <= value < np.inf:
        raise InputError.at(recorded.path, f"metadata {UNCERTAINTY_KEY}: {stated!r} is no uncertainty")
    return value
