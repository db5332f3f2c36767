"""What makes samples of sine and cosine unusable: each found with its row."""

import numpy as np
from scipy.ndimage import median_filter

from arcref.input_error import InputError
from arcref.run_file import RunFile
from arcref.subdivision.subdivision_run import COSINE, SAMPLE, SINE, TIME

WEAKEST_CHANNEL = 0.1
"""A channel with less than this share of the other's amplitude is dead."""

LARGEST_OFFSET = 0.7
"""Of an offset, relative to the amplitude: beyond it the reading hardly goes round."""

LARGEST_CORRELATION = 0.7
"""Of sine with cosine, about 45 deg from a quarter of a line: beyond it they are not two channels of one grating."""

FLAT_SHARE = 0.05
"""An extreme value that is held for this share of a period is a clipped one; a sine holds it for 0.014."""

_FLAT_DEPTH = 1e-3
_FEWEST_ROWS = 8
_FEWEST_IN_TIME = 16
_MOST_BACK_RAD = np.pi / 4
_MOST_STEP_RAD = 0.45 * np.pi
_JUMP_FACTOR, _JUMP_RAD = 1.75, 0.1
_SCALE_TOLERANCE, _ONE_PERIOD_TOLERANCE = 0.01, 0.03
_SWAPPED_WITHIN_DEG = 10.0


def check_columns(run: RunFile, stated_rate: int | None, orders: tuple[int, ...]) -> None:
    """Refuse too few rows, gaps, and channels that are dead, alike or clipped, each by its column alone."""
    if len(run.rows) < _FEWEST_ROWS:
        raise InputError.at(run.path, f"{len(run.rows)} samples, at least one period of them was expected")
    parameters = 1 + 2 * len(orders)
    if stated_rate is not None and stated_rate < max(parameters, 2 * max(orders) + 1):
        problem = f"{stated_rate} do not show harmonics up to order {max(orders)}, {2 * max(orders) + 1} or more do"
        raise run.metadata_error("samples_per_period", problem)
    _check_sequence(run)
    _check_amplitudes(run)


def growing_reading(run: RunFile, stated_sign: int | None) -> tuple[np.ndarray, int]:
    """The interpolated phase of every sample, unwrapped and growing, rad, and the sign of the cosine.

    Refuses clipped channels, both senses of rotation, hidden gaps, less than a period, and a sense that contradicts
    `stated_sign`.
    """
    phase = _phase_about_centre(run)
    step = np.diff(phase)
    _refuse_wide_steps(run, step)
    sign = _first_sense(phase)
    _refuse_both_senses(run, sign * phase)
    _refuse_jumps(run, sign * step)
    periods = sign * (phase[-1] - phase[0] + step.mean()) / (2 * np.pi)
    if periods < 1 - _ONE_PERIOD_TOLERANCE:
        raise InputError.at(run.path, f"the samples cover {periods:.3g} of a signal period, one or more was expected")
    _refuse_clipping(run, len(phase) / periods)
    if stated_sign is not None and stated_sign != sign:
        problem = (
            f"the phase falls with '# cosine_sign: {stated_sign:+d}': are the columns of sine and cosine swapped, or "
            "did the shaft turn backwards?"
        )
        raise run.error(problem, reading=0, column=SINE)
    if TIME in run.columns and len(phase) / periods < _FEWEST_IN_TIME:
        problem = f"{len(phase) / periods:.3g} samples a signal period, at least {_FEWEST_IN_TIME} were expected"
        raise InputError.at(run.path, f"{problem} to make equal angles of times")
    raw = np.unwrap(np.arctan2(run[SINE], sign * run[COSINE]))
    return raw, sign


def samples_per_period(run: RunFile, reading_rad: np.ndarray, stated: int | None) -> int:
    """Samples a period: as stated, or else as the signals show. Refuses signals without a whole number of them."""
    if stated is not None:
        return stated
    found = 2 * np.pi * (len(reading_rad) - 1) / (reading_rad[-1] - reading_rad[0])
    rate = round(found)
    if abs(found / rate - 1) > _ONE_PERIOD_TOLERANCE / 2 or len(reading_rad) % rate:
        problem = f"the signals repeat about every {found:.0f} samples: state it as '# samples_per_period: ...'"
        raise InputError.at(run.path, problem)
    return rate


def check_period_count(run: RunFile, reading_rad: np.ndarray, rate: int, orders, sign_is_stated: bool) -> None:
    """Refuse numbered samples that are no whole number of periods, or whose periods are of another length."""
    count = len(reading_rad)
    if count < rate:
        problem = f"{count} samples are {count / rate:.3g} of a period of {rate}, one or more was expected"
        raise InputError.at(run.path, problem)
    if rate < 2 * max(orders) + 1:
        problem = f"{rate} samples a period do not show harmonics up to order {max(orders)}"
        raise InputError.at(run.path, f"{problem}, {2 * max(orders) + 1} or more do")
    if count > rate:
        found = 2 * np.pi * (count - rate) / np.mean(reading_rad[-rate:] - reading_rad[:rate])
    else:
        found = 2 * np.pi * (count - 1) / (reading_rad[-1] - reading_rad[0])
    tolerance = _SCALE_TOLERANCE if count > rate else _ONE_PERIOD_TOLERANCE
    if abs(found / rate - 1) > tolerance:
        problem = f"{rate} does not fit, the signals repeat every {found:.3g} samples"
        if run.metadata_rows.get("samples_per_period") is None:
            raise InputError.at(run.path, f"samples a period: {problem}")
        raise run.metadata_error("samples_per_period", problem)
    if count % rate:
        problem = f"{count} samples are {count / rate:.4g} periods of {rate}, a whole number of periods was expected"
        raise run.error(problem, reading=count - count % rate)
    if not sign_is_stated:
        _refuse_swapped(run, rate)


def _phase_about_centre(run: RunFile) -> np.ndarray:
    """Phase about the middle of the circle that fits best, unwrapped; offsets as large as it are refused."""
    sine, cosine = run[SINE], run[COSINE]
    columns = np.stack([2 * sine, 2 * cosine, np.ones_like(sine)], axis=-1)
    middle = np.linalg.lstsq(columns, sine**2 + cosine**2, rcond=None)[0]
    radius = np.sqrt(middle[2] + middle[0] ** 2 + middle[1] ** 2)
    for name, offset in ((SINE, middle[0]), (COSINE, middle[1])):
        if abs(offset) > LARGEST_OFFSET * radius:
            problem = (
                f"an offset of about {offset:.3g} V with an amplitude of {radius:.3g} V: take off the reference "
                "voltage, or nothing can be interpolated"
            )
            raise run.error(problem, reading=0, column=name)
    return np.unwrap(np.arctan2(sine - middle[0], cosine - middle[1]))


def _first_sense(phase_rad: np.ndarray) -> int:
    """+1 or -1: which way the phase goes at first."""
    moved = phase_rad - phase_rad[0]
    far = np.flatnonzero(np.abs(moved) > _MOST_BACK_RAD)
    return 1 if moved[far[0] if far.size else -1] >= 0 else -1


def _check_sequence(run: RunFile) -> None:
    if SAMPLE in run.columns:
        number = run[SAMPLE]
        for index in np.flatnonzero(number != np.rint(number))[:1]:
            raise run.error(f"{number[index]:g} is no whole number", reading=int(index), column=SAMPLE)
        for index in np.flatnonzero(np.diff(number) != 1)[:1] + 1:
            problem = f"{number[index]:g} follows {number[index - 1]:g}, {number[index - 1] + 1:g} was expected"
            what = ": a gap" if number[index] > number[index - 1] else ""
            raise run.error(problem + what, reading=int(index), column=SAMPLE)
        return
    step = np.diff(run[TIME])
    for index in np.flatnonzero(step <= 0)[:1] + 1:
        problem = f"{run[TIME][index]:.9g} follows {run[TIME][index - 1]:.9g}, growing times were expected"
        raise run.error(problem, reading=int(index), column=TIME)
    usual = float(np.median(step))
    for index in np.flatnonzero(step > 1.5 * usual)[:1] + 1:
        problem = f"{step[index - 1]:.4g} s after the sample before, {usual:.4g} s are usual: a gap"
        raise run.error(problem, reading=int(index), column=TIME)


def _check_amplitudes(run: RunFile) -> None:
    span = {name: float(np.ptp(run[name])) for name in (SINE, COSINE)}
    largest = max(span.values())
    for name, other in ((SINE, COSINE), (COSINE, SINE)):
        if span[name] <= WEAKEST_CHANNEL * largest:
            problem = f"dead: {span[name]:.3g} V peak to peak, {other} has {span[other]:.3g} V"
            raise run.error(problem, reading=0, column=name)
    correlation = float(np.corrcoef(run[SINE], run[COSINE])[0, 1])
    if abs(correlation) > LARGEST_CORRELATION:
        apart = np.degrees(np.arccos(np.clip(correlation, -1, 1)))
        problem = f"sine and cosine are about {apart:.0f} deg of a line apart, 90 was expected"
        if abs(correlation) > 0.999:
            problem += ": both columns are the same channel"
        raise run.error(problem, reading=0, column=COSINE)


def _refuse_clipping(run: RunFile, rate: float) -> None:
    """The extreme held for long, to a thousandth of the amplitude."""
    for name in (SINE, COSINE):
        values, depth = run[name], _FLAT_DEPTH * float(np.ptp(run[name])) / 2
        for flat, limit in (
            (values >= values.max() - depth, values.max()),
            (values <= values.min() + depth, values.min()),
        ):
            edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.view(np.int8), [0]])))
            start, length = edges[::2], edges[1::2] - edges[::2]
            longest = int(np.argmax(length))
            if length[longest] >= max(4, FLAT_SHARE * rate):
                problem = f"clipped: stays at {limit:.4g} V for {length[longest]} samples"
                raise run.error(problem, reading=int(start[longest]), column=name)


def _refuse_wide_steps(run: RunFile, step_rad: np.ndarray) -> None:
    if np.median(np.abs(step_rad)) > _MOST_STEP_RAD:
        rate = 2 * np.pi / np.median(np.abs(step_rad))
        problem = f"about {rate:.2g} samples a signal period, too few to follow the phase"
        raise InputError.at(run.path, f"{problem}: at least 8 were expected")


def _refuse_both_senses(run: RunFile, phase_rad: np.ndarray) -> None:
    back = np.maximum.accumulate(phase_rad) - phase_rad
    for index in np.flatnonzero(back > _MOST_BACK_RAD)[:1]:
        turned = int(np.argmax(phase_rad[: index + 1]))
        problem = "the phase turns back here: both senses of rotation are mixed, one was expected"
        raise run.error(problem, reading=turned)


def _refuse_jumps(run: RunFile, step_rad: np.ndarray) -> None:
    usual = median_filter(step_rad, 9, mode="nearest")
    for index in np.flatnonzero(step_rad > _JUMP_FACTOR * usual + _JUMP_RAD)[:1]:
        problem = (
            f"the phase goes on by {np.degrees(step_rad[index]):.3g} deg of a line from the row before, "
            f"{np.degrees(usual[index]):.3g} deg are usual here: a gap"
        )
        raise run.error(problem, reading=int(index) + 1)


def _refuse_swapped(run: RunFile, rate: int) -> None:
    """Numbered samples begin where the line does: a sine column that begins like a cosine was probably swapped."""
    turning = np.exp(-2j * np.pi * np.arange(rate) / rate)
    first = np.degrees(np.angle(1j * np.sum(run[SINE][:rate] * turning)))
    second = np.degrees(np.angle(1j * np.sum(run[COSINE][:rate] * turning)))
    if abs(abs(first) - 90) < _SWAPPED_WITHIN_DEG and min(abs(second), 180 - abs(second)) < _SWAPPED_WITHIN_DEG:
        problem = (
            f"the sine column begins at {first:+.0f} deg, as a cosine does: are the columns swapped? If the samples "
            "begin anywhere in a line, state '# cosine_sign: ...'"
        )
        raise run.error(problem, reading=0, column=SINE)
