"""Capture files and readings that are broken, contradict themselves or do not belong together: one line, no output."""

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from test_compare import make_captures, write_run

from arcref.command import main
from arcref.instrument.captures import CAPTURE_DTYPE

HEADER = ",".join(CAPTURE_DTYPE.names)
NUMBER = 1500


@pytest.fixture(scope="module")
def good(tmp_path_factory):
    """A good pair of files as text."""
    pair = write_run(tmp_path_factory.mktemp("good"), "run", make_captures(10.0, NUMBER), 10.0)
    return tuple(path.read_text() for path in pair)


def compare(folder, capture, readings, name="c.csv"):
    contents = {name: capture, "d.csv": readings}
    for file, content in contents.items():
        (folder / file).write_bytes(content if isinstance(content, bytes) else content.encode())
    outputs = {"--json": "o.json", "--plot": "p.svg", "--csv": "t.csv"}
    arguments = [str(folder / name), str(folder / "d.csv")]
    for option, output in outputs.items():
        arguments += [option, str(folder / output)]
    result = CliRunner().invoke(main, ["compare", *arguments])
    if result.exit_code:
        assert sorted(path.name for path in folder.iterdir()) == sorted(contents)
        assert result.stdout == ""
        assert result.stderr.count("\n") == 1
    return result


def cell(text: str, capture: int, column: str, value: str) -> str:
    lines = text.splitlines()
    place = lines.index(HEADER) + 1 + capture
    cells = lines[place].split(",")
    cells[CAPTURE_DTYPE.names.index(column)] = value
    lines[place] = ",".join(cells)
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("column", CAPTURE_DTYPE.names)
@pytest.mark.parametrize("value", ["nan", "inf", "", "abc", "1e400", "1e300", "-1"])
def test_a_cell_of_the_captures_that_is_no_such_value_is_named(good, tmp_path, column, value):
    capture, readings = good
    result = compare(tmp_path, cell(capture, 5, column, value), readings)
    assert result.exit_code == 2
    row = capture.splitlines().index(HEADER) + 7
    named = (f"row {row}", f"row {row + 1}")  # the time behind one that is too large
    assert any(place in result.stderr for place in named)
    if (column, value) != ("position_counts", "-1"):  # then the angle is what contradicts it
        assert f"column {column}:" in result.stderr


BROKEN_CAPTURES = {
    "empty": (lambda text: "", "the file is empty"),
    "no capture": (lambda text: text[: text.index(HEADER)] + HEADER + "\n", "0 captures, at least 20 were expected"),
    "cut off": (lambda text: text[: len(text) // 2 - 3], "cells, 7 were expected"),
    "bytes": (lambda text: b"\x89\xff" * 50, "not UTF-8 text"),
    "a capture twice": (
        lambda text: text.replace(text.splitlines()[9], "\n".join([text.splitlines()[9]] * 2)),
        "row 11, column time_s: 0.000",
    ),
    "other position": (lambda text: cell(text, 5, "position_counts", "7"), "is not the angle of its position_counts"),
    "other raw": (lambda text: cell(text, 5, "raw_position_counts", "7000000"), "is too far from position_counts"),
    "other time": (lambda text: cell(text, 5, "time_samples", "77"), "it is not time_s at 8e+08 samples/s"),
    "unknown loss": (lambda text: cell(text, 5, "lost_before", "-1"), "nobody knows how many"),
    "great loss": (lambda text: cell(text, 5, "lost_before", "1e12"), "lost_before: 1e+12 was found, -1 .. 4294967296"),
    "uncertainty below 0": (lambda text: text.replace("0.4 arcsec", "-0.4 arcsec"), "'-0.4 arcsec (k=2)' is no unc"),
    "no uncertainty": (lambda text: text.replace("0.4 arcsec", "nan"), "'nan (k=2)' is no uncertainty"),
    "a column too many": (lambda text: text.replace("\n", ",1\n"), "columns are"),
}


@pytest.mark.parametrize("what", BROKEN_CAPTURES)
def test_a_broken_capture_file_is_refused(good, tmp_path, what):
    change, sentence = BROKEN_CAPTURES[what]
    result = compare(tmp_path, change(good[0]), good[1])
    assert result.exit_code == 2
    assert sentence in result.stderr


def readings_with(text: str, place: int, value: str) -> str:
    lines = text.splitlines()
    lines[place] = value
    return "\n".join(lines) + "\n"


def numbered(text: str, number) -> str:
    values = text.split()[1:]
    return "reading_deg,strobe\n" + "".join(f"{value},{number(k)}\n" for k, value in enumerate(values))


BROKEN_READINGS = {
    "nan": (lambda text: readings_with(text, 5, "nan"), "row 6, column reading_deg: 'nan' is not a finite number"),
    "a word": (lambda text: readings_with(text, 5, "late"), "row 6, column reading_deg: 'late' is not a finite"),
    "an empty line": (
        lambda text: readings_with(text, 5, ""),
        "row 7, column reading_deg: an empty line stands before",
    ),
    "huge": (lambda text: readings_with(text, 5, "1e300"), "row 6, column reading_deg: is 1e+300 deg"),
    "a decimal comma": (lambda text: readings_with(text, 5, "12,5"), "row 6: 2 cells, 1 were expected"),
    "empty": (lambda text: "", "the file is empty"),
    "none": (lambda text: "reading_deg\n", "0 strobes in common"),
    "one value": (lambda text: "reading_deg\n" + "5.0\n" * NUMBER, "differs by"),
    "radians": (
        lambda text: "reading_deg\n" + "".join(f"{np.radians(float(v)):.9f}\n" for v in text.split()[1:]),
        "differs by",
    ),
    "arcsec": (lambda text: "reading_deg\n" + "".join(f"{3600 * float(v):.4f}\n" for v in text.split()[1:]), "differs"),
    "strobe twice": (lambda text: numbered(text, lambda k: 3), "row 3, column strobe: is 3, increasing"),
    "strobe below 0": (lambda text: numbered(text, lambda k: k - 5), "row 2, column strobe: is -5"),
    "strobe and a half": (lambda text: numbered(text, lambda k: k + 0.5), "row 2, column strobe: is 0.5"),
    "strobe beyond": (lambda text: numbered(text, lambda k: k + 10_000), "0 strobes in common"),
    "strobe immense": (
        lambda text: numbered(text, lambda k: 1e300 if k == 9 else k),
        "row 11, column strobe: is 1e+300",
    ),
    "latin": (lambda text: b"reading_deg\n\xb05\n", "row 2: not UTF-8 text"),
    "utf-16": (lambda text: text.encode("utf-16"), "UTF-16 text"),
    "two columns": (lambda text: text.replace("reading_deg", "reading_deg,volt"), "the columns are 'reading_deg,volt'"),
}


@pytest.mark.parametrize("what", BROKEN_READINGS)
def test_broken_readings_are_refused(good, tmp_path, what):
    change, sentence = BROKEN_READINGS[what]
    result = compare(tmp_path, good[0], change(good[1]))
    assert result.exit_code == 2
    assert sentence in result.stderr


def hdf5(change) -> bytes:
    with h5py.File("c", "w", driver="core", backing_store=False) as file:
        change(file)
        file.flush()
        return file.id.get_file_image()


def broken_value(file):
    captures = make_captures(10.0, NUMBER)
    captures["time_s"][7] = np.nan
    file.create_dataset("captures", data=captures)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"no hdf5", "cannot be read as HDF5"),
        (hdf5(lambda file: None), "has no data set 'captures'"),
        (hdf5(lambda file: file.create_group("captures")), "has no data set 'captures'"),
        (hdf5(lambda file: file.create_dataset("captures", data=np.zeros(9))), "has no data set 'captures'"),
        (hdf5(broken_value), "column time_s[7]: nan was found, a finite number was expected"),
        (
            hdf5(lambda file: file.create_dataset("captures", data=make_captures(10.0, NUMBER)))[:-3000],
            "cannot be read",
        ),
    ],
)
def test_a_broken_hdf5_file_is_refused(good, tmp_path, content, sentence):
    result = compare(tmp_path, content, good[1], "c.h5")
    assert result.exit_code == 2
    assert sentence in result.stderr


CAUTIONS = {
    "faults": (
        lambda c, d: (cell(c, 5, "flags", "194"), d),
        "1 of 1500 captures have a fault flag up (illegal step, clo",
    ),
    "not corrected": (lambda c, d: (cell(c, 5, "flags", "0"), d), "1 of 1500 captures are not corrected"),
    "a reading short": (lambda c, d: (c, "\n".join(d.splitlines()[:-1]) + "\n"), "1499 readings for 1500 strobes"),
}


@pytest.mark.parametrize("what", CAUTIONS)
def test_what_may_make_the_figures_wrong_is_told(good, tmp_path, what):
    change, sentence = CAUTIONS[what]
    result = compare(tmp_path, *change(*good))
    assert result.exit_code == 0, result.output
    assert f"Caution: {'c' if what != 'a reading short' else 'd'}.csv: {sentence}" in result.stdout


def test_good_files_raise_no_caution(good, tmp_path):
    assert "Caution" not in compare(tmp_path, *good).stdout


def test_readings_one_strobe_late_are_suspected(tmp_path):
    """At an even strobe rate nothing else tells them from a delay of one period."""
    pairs = []
    for name, speed in (("slow", 1.0), ("fast", 2.0)):
        captures = make_captures(speed, NUMBER)
        captures["time_samples"] = np.arange(NUMBER) * 1_000_000
        captures["time_s"] = captures["time_samples"] / 8e8
        position = np.rint(speed * captures["time_s"] * 2**23).astype(np.int64)
        captures["position_counts"] = captures["raw_position_counts"] = position
        captures["angle_deg"] = position % 2**23 * 360 / 2**23
        capture, readings = write_run(tmp_path, name, captures, speed)
        lines = readings.read_text().splitlines()
        readings.write_text("\n".join([lines[0], lines[1], *lines[1:-1]]) + "\n")
        pairs += [capture, readings]
    result = CliRunner().invoke(main, ["compare", *map(str, pairs)])
    assert result.exit_code == 0, result.output
    assert "Caution: the delay is 1.00 strobe periods: are the readings beside the right strobes?" in result.stdout
