"""Sample files that cannot be used, through the command: one exact line on stderr, exit status 2, no file written."""

import numpy as np
import pytest
from made_signals import UnevenSpeed, at_equal_angles, in_time
from published_signals import published_signals

SIGNALS = published_signals(4096)

HEADER, TIME_HEADER = "sample,sine_v,cosine_v", "time_s,sine_v,cosine_v"

RATE = {"samples_per_period": 64}


def text(columns, header=HEADER, metadata=None) -> str:
    lines = [f"# {key}: {value}" for key, value in (RATE if metadata is None else metadata).items()]
    rows = [",".join(f"{value:.12g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([*lines, header, *rows]) + "\n"


def columns(periods=2):
    """Sample numbers, sine and cosine; with one line of metadata reading k stands in row k + 3."""
    return [np.array(each, float) for each in at_equal_angles(SIGNALS, periods)]


def times():
    """The same in time; without metadata reading k stands in row k + 2."""
    return [np.array(each, float) for each in in_time(SIGNALS, UnevenSpeed(4, 0.0, start_rad=0.1), rate=50.0)]


def changed(place, rows, value, made=columns, **options) -> str:
    given = made()
    given[place][rows] = value(given[place][rows]) if callable(value) else value
    return text(given, **options)


def without(rows, made=columns, **options) -> str:
    return text([np.delete(each, rows) for each in made()], **options)


def renumbered(given) -> list:
    return [np.arange(given[0].size, dtype=float), *given[1:]]


def turned_back() -> str:
    theta = 2 * np.pi * np.concatenate([np.arange(100), np.arange(98, -58, -1)]) / 64
    return text([np.arange(theta.size), *SIGNALS.signals_v(theta)])


def swapped(given) -> list:
    return [given[0], given[2], given[1]]


BAD = {
    "other columns": (
        "sample,sine,cosine\n0,1,0\n",
        ", row 1: the columns are 'sample,sine,cosine', expected were 'sample,sine_v,cosine_v' or "
        "'time_s,sine_v,cosine_v' or 'count,time_s' or 'count,autocollimator_x_arcsec'",
    ),
    "sample and time": (
        "sample,time_s,sine_v,cosine_v\n0,0,1,0\n",
        ", row 1: the columns are 'sample,time_s,sine_v,cosine_v', expected were 'sample,sine_v,cosine_v' or "
        "'time_s,sine_v,cosine_v' or 'count,time_s' or 'count,autocollimator_x_arcsec'",
    ),
    "no rows": (HEADER + "\n", ": 0 samples, at least one period of them was expected"),
    "a cell that is no number": (
        HEADER + "\n0,1,overflow\n",
        ", row 2, column cosine_v: 'overflow' is not a finite number",
    ),
    "a gap in the numbers": (
        without(slice(40, 44)),
        ", row 43, column sample: 44 follows 39, 40 was expected: a gap",
    ),
    "a number twice": (
        changed(0, slice(40, None), lambda number: number - 1),
        ", row 43, column sample: 39 follows 39, 40 was expected",
    ),
    "half a number": (changed(0, 7, 7.5), ", row 10, column sample: 7.5 is no whole number"),
    "a gap behind renumbered samples": (
        text(renumbered([np.delete(each, slice(40, 48)) for each in columns()])),
        ", row 43: the phase goes on by 50.2 deg of a line from the row before, 5.63 deg are usual here: a gap",
    ),
    "a gap in time": (
        without(slice(60, 63), made=times, header=TIME_HEADER, metadata={}),
        ", row 62, column time_s: 0.02 s after the sample before, 0.005 s are usual: a gap",
    ),
    "time that stands still": (
        changed(0, 61, 0.3, made=times, header=TIME_HEADER, metadata={}),
        ", row 63, column time_s: 0.3 follows 0.3, growing times were expected",
    ),
    "a dead sine": (
        changed(1, slice(None), -0.0179),
        ", row 3, column sine_v: dead: 0 V peak to peak, cosine_v has 7.33 V",
    ),
    "a weak cosine": (
        changed(2, slice(None), lambda volts: 0.05 * volts),
        ", row 3, column cosine_v: dead: 0.367 V peak to peak, sine_v has 7.41 V",
    ),
    "both channels dead": (
        text([np.arange(64), np.zeros(64), np.zeros(64)]),
        ", row 3, column sine_v: dead: 0 V peak to peak, cosine_v has 0 V",
    ),
    "one channel in both columns": (
        text([columns()[0], columns()[1], columns()[1]]),
        ", row 3, column cosine_v: sine and cosine are about 0 deg of a line apart, 90 was expected: "
        "both columns are the same channel",
    ),
    "channels half a right angle apart": (
        text([np.arange(64), np.sin(2 * np.pi * np.arange(64) / 64), np.sin(2 * np.pi * np.arange(64) / 64 + 0.7)]),
        ", row 3, column cosine_v: sine and cosine are about 40 deg of a line apart, 90 was expected",
    ),
    "a clipped sine": (
        changed(1, slice(None), lambda volts: np.minimum(volts, 3.5)),
        ", row 16, column sine_v: clipped: stays at 3.5 V for 7 samples",
    ),
    "a cosine clipped from below": (
        changed(2, slice(None), lambda volts: np.maximum(volts, -3.2)),
        ", row 61, column cosine_v: clipped: stays at -3.2 V for 12 samples",
    ),
    "signals that stand on a reference voltage": (
        changed(1, slice(None), lambda volts: volts + 5.0),
        ", row 3, column sine_v: an offset of about 4.98 V with an amplitude of 3.76 V: take off the reference "
        "voltage, or nothing can be interpolated",
    ),
    "swapped by what it states": (
        text(columns(), metadata=RATE | {"cosine_sign": 1}),
        ", row 4, column sine_v: the phase falls with '# cosine_sign: +1': are the columns of sine and cosine "
        "swapped, or did the shaft turn backwards?",
    ),
    "swapped by where it begins": (
        text(swapped(columns())),
        ", row 3, column sine_v: the sine column begins at -89 deg, as a cosine does: are the columns swapped? If "
        "the samples begin anywhere in a line, state '# cosine_sign: ...'",
    ),
    "swapped in time": (
        text(swapped(times()), TIME_HEADER, {"cosine_sign": -1}),
        ", row 3, column sine_v: the phase falls with '# cosine_sign: -1': are the columns of sine and cosine "
        "swapped, or did the shaft turn backwards?",
    ),
    "both senses of rotation": (
        turned_back(),
        ", row 102: the phase turns back here: both senses of rotation are mixed, one was expected",
    ),
    "half a period": (
        text([each[:32] for each in columns()]),
        ": the samples cover 0.506 of a signal period, one or more was expected",
    ),
    "less than two periods in time": (
        text([each[:80] for each in times()], TIME_HEADER, {}),
        ": 1 whole periods, at least 2 were expected: samples in time are made into equal angles only so",
    ),
    "a period that does not fit": (
        text(columns(3), metadata={"samples_per_period": 60}),
        ", row 1: metadata samples_per_period: 60 does not fit, the signals repeat every 64 samples",
    ),
    "no whole number of periods": (
        text([each[:100] for each in columns()]),
        ", row 67: 100 samples are 1.562 periods of 64, a whole number of periods was expected",
    ),
    "a period that is not stated and not whole": (
        text([each[:100] for each in columns()], metadata={}),
        ": the signals repeat about every 64 samples: state it as '# samples_per_period: ...'",
    ),
    "too few samples a period": (
        text(at_equal_angles(SIGNALS, 4, 10), metadata={"samples_per_period": 10}),
        ", row 1: metadata samples_per_period: 10 do not show harmonics up to order 5, 11 or more do",
    ),
    "hardly two samples a period": (
        text(at_equal_angles(SIGNALS, 40, 3), metadata={}),
        ": about 3 samples a signal period, too few to follow the phase: at least 8 were expected",
    ),
    "samples a period that are no whole number": (
        text(columns(), metadata={"samples_per_period": 63.5}),
        ", row 1: metadata samples_per_period: 63.5 is no whole number up to 1000000",
    ),
    "a disc without lines": (
        text(columns(), metadata=RATE | {"line_count": 0}),
        ", row 2: metadata line_count: 0 is below 1, the least that can be",
    ),
    "a first line beyond the disc": (
        text(columns(), metadata=RATE | {"line_count": 4096, "first_line": 4096}),
        ", row 3: metadata first_line: 4096 is no whole number up to 4095",
    ),
    "a sign that is none": (
        text(columns(), metadata=RATE | {"cosine_sign": 0}),
        ", row 2: metadata cosine_sign: 0 is neither +1 nor -1",
    ),
    "a misspelt key": (
        text(columns(), metadata={"samples_per_periode": 64}),
        ", row 1: the metadata key 'samples_per_periode' is not known, 'samples_per_period' was probably meant",
    ),
    "too slow in time": (
        text(in_time(SIGNALS, UnevenSpeed(20), rate=9.0), TIME_HEADER, {}),
        ": 9 samples a signal period, at least 16 were expected to make equal angles of times",
    ),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_file_gets_one_line_and_status_2(arcref, tmp_path, name):
    content, line = BAD[name]
    run, output, page = tmp_path / "run.csv", tmp_path / "cal.json", tmp_path / "r.html"
    run.write_text(content, encoding="utf-8")
    done = arcref("calibrate", "subdivision", run, "-o", output, "--report", page)
    assert done.stderr == f"arcref: {run}{line}\n"
    assert done.exit_code == 2
    assert not output.exists()
    assert not page.exists()


@pytest.mark.parametrize(
    ("orders", "problem"),
    [
        ("3,5", "--orders 3,5: each once, 1 among them, none above 31 were expected"),
        ("1,3,3", "--orders 1,3,3: each once, 1 among them, none above 31 were expected"),
        ("1,99", "--orders 1,99: each once, 1 among them, none above 31 were expected"),
        ("1;3", "--orders 1;3: whole numbers with commas between them were expected, as in 1,3,5"),
        ("1,-3", "--orders 1,-3: whole numbers with commas between them were expected, as in 1,3,5"),
    ],
)
def test_bad_orders(arcref, tmp_path, orders, problem):
    run = tmp_path / "run.csv"
    run.write_text(text(columns()), encoding="utf-8")
    done = arcref("calibrate", "subdivision", run, "-o", tmp_path / "cal.json", "--orders", orders)
    assert (done.exit_code, done.stderr) == (2, f"arcref: {problem}\n")


def test_options_of_samples_are_refused_for_other_runs(arcref, tmp_path):
    run = tmp_path / "edges.csv"
    run.write_text("count,time_s\n0,0\n1,1e-8\n", encoding="utf-8")
    done = arcref("calibrate", "subdivision", run, "-o", tmp_path / "cal.json", "--compare")
    problem = f"--compare belongs to samples of the signals, {run} holds a run of edge times"
    assert (done.exit_code, done.stderr) == (2, f"arcref: {problem}\n")


def test_a_run_that_is_good_is_taken(arcref, tmp_path):
    """The files above are bad for what was done to them, and for nothing else."""
    for content in (text(columns()), text(times(), TIME_HEADER, {}), text(columns(), metadata={})):
        run = tmp_path / "run.csv"
        run.write_text(content, encoding="utf-8")
        assert arcref("calibrate", "subdivision", run, "-o", tmp_path / "cal.json").exit_code == 0
