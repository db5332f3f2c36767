"""Theodolite files that cannot be used, through the command: one line on stderr, exit status 2, no file written."""

import pytest
from refused_runs import refusal
from theodolite_files import COLUMNS, STATED, theodolite_rows, theodolite_text

ROWS = theodolite_rows()
GOOD = theodolite_text(ROWS)
FIRST = 4
"""Row of the first reading."""


def changed(index, **cells) -> str:
    """The good run with cells of one row changed."""
    rows = list(ROWS)
    row = dict(zip(("reading", "azimuth", "zenith"), rows[index], strict=True)) | cells
    rows[index] = tuple(row.values())
    return theodolite_text(rows)


def every(change) -> str:
    """The good run with each row put through `change`."""
    return theodolite_text([change(*row) for row in ROWS])


def shown(value: float) -> str:
    return f"{float(f'{value:.8f}'):g}"


BAD = {
    "column lost": (
        "reading_deg,azimuth_deg\n0,0\n",
        ", row 1: the columns are 'reading_deg,azimuth_deg', expected were 'reading_deg,azimuth_deg,zenith_deg' (and, "
        "if wanted, 'round')",
    ),
    "elevation by its name": (
        "reading_deg,azimuth_deg,elevation_deg\n0,0,0\n",
        ", row 1: the columns are 'reading_deg,azimuth_deg,elevation_deg', expected were "
        "'reading_deg,azimuth_deg,zenith_deg' (and, if wanted, 'round')",
    ),
    "four readings": (theodolite_text(ROWS[:4]), ": 4 readings, at least 5 were expected"),
    "no readings": (STATED + COLUMNS + "\n", ": 0 readings, at least 5 were expected"),
    "elevation for zenith": (
        every(lambda r, a, z: (r, a, z - 90)),
        f", row {FIRST}, column zenith_deg: {shown(ROWS[0][2] - 90)} deg, 45 .. 135 deg was expected: a level line of "
        "sight reads 90 deg; is this the elevation? The zenith reading is 90 deg more",
    ),
    "circle right": (
        every(lambda r, a, z: (r, a, 360 - z)),
        f", row {FIRST}, column zenith_deg: {shown(360 - ROWS[0][2])} deg, 45 .. 135 deg was expected: a level line of "
        "sight reads 90 deg; was it read with the circle right? Then write 360 deg less the reading",
    ),
    "one zenith absurd": (
        changed(7, zenith=8.9),
        f", row {FIRST + 7}, column zenith_deg: 8.9 deg, 45 .. 135 deg was expected: a level line of sight reads 90 "
        "deg",
    ),
    "azimuth and zenith swapped": (
        every(lambda r, a, z: (r, z, a)),
        f", row {FIRST}, column zenith_deg: {shown(ROWS[0][1])} deg: this column turns with the encoder and "
        "azimuth_deg does not, are the two swapped?",
    ),
    "reading in counts": (
        every(lambda r, a, z: (r * 2**23 / 360, a, z)),
        f", row {FIRST + 1}, column reading_deg: {ROWS[1][0] * 2**23 / 360:g} deg, at most 720 deg were expected: are "
        "these counts or arcsec?",
    ),
    "one reading absurd": (
        changed(5, reading=5000.0),
        None,
    ),
    "encoder that counts the other way": (every(lambda r, a, z: (360 - r, a, z)), None),
    "angles in gon": (every(lambda r, a, z: (r, a / 0.9, z / 0.9)), None),
    "azimuth in radians": (every(lambda r, a, z: (r, a / 57.3, z)), None),
    "a degree misread": (changed(17, azimuth=ROWS[17][1] + 1), None),
    "a zenith degree misread": (changed(17, zenith=ROWS[17][2] + 1), None),
    "a place twice": (
        theodolite_text([*ROWS, ROWS[9]]),
        f", row {FIRST + 41}, column reading_deg: {shown(ROWS[9][0])} deg is given twice (before in row {FIRST + 9}); "
        "a second round needs a column round",
    ),
    "shaft that stands still": (
        theodolite_text([(0.001 * i, 0.001 * i, 90.0) for i in range(8)]),
        f", row {FIRST}, column reading_deg: all readings lie within 0.007 deg, an arc of 0.1 deg or more was expected",
    ),
    "direction neither way": (
        theodolite_text(ROWS, STATED + "# encoder_direction: 2\n"),
        ", row 3: metadata encoder_direction: 2, +1 or -1 was expected",
    ),
    "uncertainty no number": (
        theodolite_text(ROWS, "# u_azimuth_arcsec: half a second\n"),
        None,
    ),
    "uncertainty misspelt": (
        theodolite_text(ROWS, "# u_azimut_arcsec: 0.5\n"),
        ", row 1: the metadata key 'u_azimut_arcsec' is not known, 'u_azimuth_arcsec' was probably meant",
    ),
    "empty cell": (
        theodolite_text(ROWS) + "41,,90\n",
        f", row {FIRST + 41}, column azimuth_deg: the cell is empty, a number was expected",
    ),
    "too short for what is asked": (
        theodolite_text(theodolite_rows(theta_deg=range(6)), STATED + "# required_expanded_uncertainty_arcsec: 1\n"),
        None,
    ),
    "asked without a word on the azimuths": (
        theodolite_text(ROWS, "# required_expanded_uncertainty_arcsec: 1\n"),
        ": an expanded uncertainty of 1 arcsec was asked, but nothing tells that of an azimuth: state it as "
        "'# u_azimuth_arcsec: ...', or read a second round",
    ),
    "round no whole number": (
        f"round,{COLUMNS}\n" + "".join(f"1.5,{i},{i},90\n" for i in range(6)),
        ", row 2, column round: 1.5, whole numbers from 1 were expected",
    ),
}

PARTS = {
    "one reading absurd": f"row {FIRST + 5}, column reading_deg: 5000 deg, at most 720 deg were expected",
    "encoder that counts the other way": "the other way than encoder_direction +1 says",
    "angles in gon": "are these gon, 400 to the turn?",
    "azimuth in radians": "about as much was expected",
    "a degree misread": f"row {FIRST + 17}, column azimuth_deg: {shown(ROWS[17][1] + 1)} deg is about +1 deg off",
    "a zenith degree misread": f"row {FIRST + 17}, column zenith_deg: {shown(ROWS[17][2] + 1)} deg is +",
    "uncertainty no number": "metadata u_azimuth_arcsec: 'half a second' is not a finite number (arcsec expected)",
    "too short for what is asked": "1 arcsec was asked: with as many readings an arc of ",
}
"""What the line must say where its numbers come from the noise of the readings."""


@pytest.mark.parametrize("name", BAD)
def test_one_line_and_no_file(tmp_path, arcref, name):
    content, expected = BAD[name]
    line = refusal(arcref, "theodolite", tmp_path, content)
    if expected is None:
        assert PARTS[name] in line
    else:
        assert line == expected


def test_the_good_run_is_good(tmp_path, arcref):
    (tmp_path / "run.csv").write_text(GOOD)
    assert arcref("calibrate", "theodolite", tmp_path / "run.csv", "-o", tmp_path / "cal.json").exit_code == 0


@pytest.mark.parametrize("text", ["0", "-1", "nan", "much"])
def test_a_requirement_that_is_none(tmp_path, arcref, text):
    (tmp_path / "run.csv").write_text(GOOD)
    result = arcref("calibrate", "theodolite", tmp_path / "run.csv", "-o", tmp_path / "cal.json", "--require", text)
    assert result.exit_code == 2
    assert not (tmp_path / "cal.json").exists()
