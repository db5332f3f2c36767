"""A run of samples of sine and cosine: checked, and brought to equal angles."""

from dataclasses import dataclass

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.calibration.stated_values import stated_number
from arcref.input_error import InputError
from arcref.run_file import RunFile
from arcref.subdivision.equal_angle_sampling import FEWEST_PERIODS, SAMPLES_PER_PERIOD, EqualAngleSamples, resample
from arcref.subdivision.samples_checks import check_columns, check_period_count, growing_reading, samples_per_period
from arcref.subdivision.subdivision_run import COSINE, SAMPLE, SINE, TIME

LARGEST_LINE_COUNT = 1_000_000

SLIP_RAD = 2 * np.pi * 1e-3
"""Periods that are off their place by more than this (0.1 %, rms) are resampled though they are numbered samples."""


@dataclass(frozen=True, eq=False)
class SamplesRun:
    """Samples at equal angles with what is known of them.

    `samples`: one row a period; `line_count`, `first_line`; `cosine_sign`: of the reading, see `signal_model`,
    `sign_is_stated`: by the run file; `count_zero_phase_deg`: None when not stated; `rate_per_period`: samples a period
    as taken, mean; `resampled`: False when they are those of the file; `slip`: relative change of the duration from
    each period to the next, float64[periods - 1], None where one period or exact samples cannot show it.
    """

    run: RunFile
    samples: EqualAngleSamples
    line_count: int
    first_line: int
    cosine_sign: int
    sign_is_stated: bool
    count_zero_phase_deg: float | None
    rate_per_period: float
    resampled: bool
    slip: np.ndarray | None

    @property
    def has_time(self) -> bool:
        """True when the samples came with times."""
        return TIME in self.run.columns


def samples_run(run: RunFile, orders: tuple[int, ...]) -> SamplesRun:
    """Check the samples of `run` and bring them to equal angles; `orders`: harmonics that will be identified.

    Raises `InputError` for a gap, times or numbers that do not increase, a dead or clipped channel, channels that are
    not a quarter of a line apart or swapped, both senses of rotation, less than one period, and a number of samples a
    period that does not fit.
    """
    line_count = _whole(run, "line_count", LARGEST_LINE_COUNT) or LINES_PER_TURN
    first_line = _whole(run, "first_line", line_count - 1) or 0
    stated_rate = _whole(run, "samples_per_period", 1_000_000)
    sign = _cosine_sign(run)
    zero_phase = stated_number(run, "count_zero_phase_deg")
    check_columns(run, stated_rate, orders)
    reading, found_sign = growing_reading(run, sign)
    common = {
        "run": run,
        "line_count": line_count,
        "first_line": first_line,
        "cosine_sign": found_sign,
        "sign_is_stated": sign is not None,
        "count_zero_phase_deg": zero_phase,
    }
    if TIME in run.columns:
        return _resampled(run[TIME], run, reading, orders, stated_rate or SAMPLES_PER_PERIOD, common)
    rate = samples_per_period(run, reading, stated_rate)
    check_period_count(run, reading, rate, orders, sign is not None)
    drift = np.diff(_drift(reading, rate))
    if drift.size >= FEWEST_PERIODS and np.sqrt(np.mean(drift**2)) > SLIP_RAD:
        return _resampled(run[SAMPLE], run, reading, orders, rate, common)
    samples = EqualAngleSamples(run[SINE].reshape(-1, rate), run[COSINE].reshape(-1, rate))
    slip = drift / (2 * np.pi) if drift.size else None
    return SamplesRun(**common, samples=samples, rate_per_period=float(rate), resampled=False, slip=slip)


def _drift(reading_rad: np.ndarray, rate: int) -> np.ndarray:
    """How far each period is ahead of its place, rad, float64[periods]; equal readings lie at equal phases."""
    periods = reading_rad.reshape(-1, rate)
    return (periods - 2 * np.pi * np.arange(len(periods))[:, np.newaxis]).mean(axis=1)


def _resampled(time: np.ndarray, run: RunFile, reading, orders, rate: int, common: dict) -> SamplesRun:
    periods = (reading[-1] - reading[0]) / (2 * np.pi)
    own_rate = (len(reading) - 1) / periods
    try:
        samples = resample(time, run[SINE], run[COSINE], reading, rate, orders)
    except ValueError as error:
        problem = f"{error}: samples in time are made into equal angles only so"
        raise InputError.at(run.path, problem) from None
    duration = np.diff(samples.mark_s)
    slip = duration[:-1] / duration[1:] - 1.0
    return SamplesRun(**common, samples=samples, rate_per_period=float(own_rate), resampled=True, slip=slip)


def _whole(run: RunFile, key: str, largest: int) -> int | None:
    value = stated_number(run, key)
    if value is None:
        return None
    if value != int(value) or value > largest:
        raise run.metadata_error(key, f"{value:g} is no whole number up to {largest}")
    return int(value)


def _cosine_sign(run: RunFile) -> int | None:
    sign = stated_number(run, "cosine_sign")
    if sign not in (None, 1.0, -1.0):
        raise run.metadata_error("cosine_sign", f"{sign:g} is neither +1 nor -1")
    return None if sign is None else int(sign)
