"""Polygon runs that cannot be used, through the command: one line on stderr, exit status 2, no file written.

Then what Excel makes of a good run, which is read as it was meant.
"""

import numpy as np
import pytest
from refused_runs import refusal

from arcref.calibration.polygon_reduction import reduce_polygon
from arcref.calibration.polygon_run import read_polygon_run

NAMES = "position_deg,face_deviation_arcsec,autocollimator_x_arcsec,autocollimator_y_arcsec"
DEVIATION = (0.0, 1.2, -0.7, 0.4, 2.1, -1.5, 0.3, -0.9)
ROWS = tuple(
    f"{45 * face}.0002,{DEVIATION[face % 8]},{DEVIATION[face % 8] + 0.31 * (face % 8):.2f},{0.1 * face:.1f}"
    for face in range(9)
)
KEYS = ("# faces: 8", "# autocollimator_sign: +1")
"""A good run is KEYS, NAMES and ROWS: its readings stand in rows 4 to 12, the closing one in row 12."""

EXPECTED = (
    "expected were 'autocollimator_x_arcsec' (and, if wanted, "
    "'position_deg,count,face_deviation_arcsec,autocollimator_y_arcsec,round,direction')"
)
NOT_A_NUMBER = "is not a finite number"


def run(rows=ROWS, names=NAMES, keys=KEYS) -> str:
    return "\n".join([*keys, names, *rows]) + "\n"


def changed(row: int, column: int, cell: str, rows=ROWS) -> str:
    """The run with one cell changed; `row` as the file counts, from 4."""
    cells = rows[row - 4].split(",")
    cells[column] = cell
    return run([*rows[: row - 4], ",".join(cells), *rows[row - 3 :]])


def column(number: int, change) -> str:
    """The run with every cell of a column changed."""
    rows = []
    for row in ROWS:
        cells = row.split(",")
        cells[number] = change(float(cells[number]))
        rows.append(",".join(cells))
    return run(rows)


def with_columns(name: str, values) -> str:
    """The run with one more column."""
    return run([f"{row},{value}" for row, value in zip(ROWS, values, strict=True)], f"{NAMES},{name}")


def without(number: int) -> str:
    """The run without one column."""

    def rest(line: str) -> str:
        cells = line.split(",")
        return ",".join(cells[:number] + cells[number + 1 :])

    return run([rest(row) for row in ROWS], rest(NAMES))


def with_key(*keys: str) -> str:
    return run(keys=(*KEYS, *keys))


BAD = {
    # The file
    "empty": ("", ": the file is empty"),
    "metadata alone": (
        "\n".join(KEYS),
        ": no line of column names, 'autocollimator_x_arcsec' were expected",
    ),
    "UTF-16": (
        run().encode("utf-16"),
        ": UTF-16 text, as Excel's 'Unicode Text' is; UTF-8 was expected, which Excel calls 'CSV UTF-8'",
    ),
    "UTF-16 without its mark": (
        run().encode("utf-16-le"),
        ": UTF-16 text, as Excel's 'Unicode Text' is; UTF-8 was expected, which Excel calls 'CSV UTF-8'",
    ),
    "Latin-1": (
        ("# operator: Jürgen\n" + run()).encode("latin-1"),
        ", row 1: not UTF-8 text: byte 0xFC at offset 13",
    ),
    "tabs": (
        run().replace(",", "\t"),
        ", row 3: tabs stand between the column names, commas were expected (or semicolons)",
    ),
    "an announced separator that is none": (
        "sep=|\n" + run(),
        ": sep=|: commas or semicolons between the cells were expected",
    ),
    # Columns
    "no column names": (run()[len("\n".join(KEYS)) + len(NAMES) + 2 :], ", row 1: the columns are"),
    "x lost": (without(2), f", row 3: the columns are '{NAMES.replace(',autocollimator_x_arcsec', '')}', {EXPECTED}"),
    "position lost": (
        without(0),
        ", row 3: columns position_deg and count: neither stands here, one of them was expected",
    ),
    "position and count": (
        with_columns("count", range(9)),
        ", row 3: columns position_deg and count: both stand here, one of them was expected",
    ),
    "x in another unit": (
        run(names=NAMES.replace("x_arcsec", "x_arcmin")),
        f", row 3: the columns are '{NAMES.replace('x_arcsec', 'x_arcmin')}', {EXPECTED}",
    ),
    "a column twice": (
        with_columns("autocollimator_x_arcsec", range(9)),
        f", row 3: the columns are '{NAMES},autocollimator_x_arcsec', {EXPECTED}",
    ),
    "a row short of a cell": (
        run([*ROWS[:3], "135.0002,0.4,1.33", *ROWS[4:]]),
        f", row 7: 3 cells, 4 were expected ('{NAMES}')",
    ),
    "a column lost from one row on": (
        run([*ROWS[:6], *(row.rpartition(",")[0] for row in ROWS[6:])]),
        f", row 10: 3 cells, 4 were expected ('{NAMES}')",
    ),
    "decimal commas between commas": (
        changed(6, 2, "0,31"),
        f", row 6: 5 cells, 4 were expected ('{NAMES}'); decimal commas need semicolons between the columns",
    ),
    "decimal commas in quotation marks": (
        changed(6, 2, '"0,31"'),
        ", row 6, column autocollimator_x_arcsec: '0,31' has a comma; a decimal point was expected, or semicolons "
        "between the columns",
    ),
    "decimal points among decimal commas": (
        run().replace(",", ";").replace(".", ",").replace("0,4;", "0.4;"),
        ", row 7, column face_deviation_arcsec: '0.4' has a decimal point, row 4 has a decimal comma: one was expected",
    ),
    "thousands and decimals marked": (
        run().replace(",", ";").replace("360.0002", "3.600,2"),
        f", row 12, column position_deg: '3.600,2' {NOT_A_NUMBER}",
    ),
    "columns swapped": (
        run(names="autocollimator_x_arcsec,face_deviation_arcsec,position_deg,autocollimator_y_arcsec"),
        ", row 4, column position_deg: the positions fit no faces, but autocollimator_x_arcsec does: the two columns "
        "seem to be swapped",
    ),
    # Cells
    "an empty cell": (
        changed(8, 2, ""),
        ", row 8, column autocollimator_x_arcsec: the cell is empty, a number was expected",
    ),
    "text": (changed(8, 2, "off"), f", row 8, column autocollimator_x_arcsec: 'off' {NOT_A_NUMBER}"),
    "NaN": (changed(9, 2, "nan"), f", row 9, column autocollimator_x_arcsec: 'nan' {NOT_A_NUMBER}"),
    "a unit in the cell": (changed(5, 0, "45 deg"), f", row 5, column position_deg: '45 deg' {NOT_A_NUMBER}"),
    "degrees and minutes": (changed(5, 0, "45:00:00.7"), f", row 5, column position_deg: '45:00:00.7' {NOT_A_NUMBER}"),
    "a typographic minus": (changed(6, 1, "−0.7"), f", row 6, column face_deviation_arcsec: '−0.7' {NOT_A_NUMBER}"),
    "metadata below": (
        run([*ROWS[:4], "# note: pause", *ROWS[4:]]),
        ", row 8: a line with # stands behind the column names, it belongs before them",
    ),
    "an open quotation mark": (changed(6, 1, '"-0.7'), ", row 6: not a CSV row: unexpected end of data"),
    # Numbers that no such instrument shows
    "an absurd angle": (
        changed(7, 0, "1e6"),
        ", row 7, column position_deg: 1e+06 deg, at most 36000 deg (100 turns) were expected",
    ),
    "absurd x": (
        changed(7, 2, "54000"),
        ", row 7, column autocollimator_x_arcsec: 54000 arcsec, at most 3600 arcsec were expected",
    ),
    "absurd y": (
        changed(7, 3, "-7201"),
        ", row 7, column autocollimator_y_arcsec: -7201 arcsec, at most 7200 arcsec were expected",
    ),
    "absurd face deviation": (
        changed(7, 1, "400"),
        ", row 7, column face_deviation_arcsec: 400 arcsec, at most 300 arcsec were expected",
    ),
    "face angles for deviations": (
        run([",".join((row.split(",")[0], row.split(",")[0], *row.split(",")[2:])) for row in ROWS]),
        ", row 11, column face_deviation_arcsec: 315 looks like a face's angle in degrees, its deviation from nominal "
        "was expected",
    ),
    "positions in arcsec": (
        column(0, lambda value: f"{value * 3600:.1f}"),
        ", row 5, column position_deg: the positions step by 162000, which is one face (45 deg) in arcsec; "
        "degrees were "
        "expected",
    ),
    "positions in radians": (
        column(0, lambda value: f"{np.radians(value):.7f}"),
        ", row 5, column position_deg: the positions step by 0.785398, which is one face (45 deg) in radians; degrees "
        "were expected",
    ),
    "counts under position_deg": (
        column(0, lambda value: f"{value * 2**23 / 360:.0f}"),
        ", row 5, column position_deg: the positions step by 1.04858e+06, which is one face (45 deg) in counts; "
        "degrees "
        "were expected",
    ),
    "half a count": (
        run(
            [f"{face * 2**20 + 0.5 * (face == 3)},{row.partition(',')[2]}" for face, row in enumerate(ROWS)],
            NAMES.replace("position_deg", "count"),
        ),
        ", row 7, column count: 3145728.5 is no whole number, counts were expected",
    ),
    "an angle between the faces": (
        changed(7, 0, "137.3"),
        ", row 7, column position_deg: 137.3 deg is 2.3 deg from the nearest face (135 deg), at most 0.5 deg were "
        "expected",
    ),
    # Faces
    "faces not stated": (
        run(keys=KEYS[1:]),
        ": metadata faces is missing: state the number of faces, as in '# faces: 24'",
    ),
    "another number of faces": (
        run(keys=("# faces: 9", KEYS[1])),
        ", row 5, column position_deg: the positions step by 45 deg, as with 8 faces, but the metadata says 9",
    ),
    "half a face": (
        run(keys=("# faces: 8.5", KEYS[1])),
        ", row 1: metadata faces: 8.5 faces, a whole number in 3 .. 360 was expected",
    ),
    "two faces": (run(keys=("# faces: 2", KEYS[1])), ", row 1: metadata faces: 2 is below 3, the least that can be"),
    "faces in words": (
        run(keys=("# faces: eight", KEYS[1])),
        ", row 1: metadata faces: 'eight' is not a finite number (1 expected)",
    ),
    "faces twice": (
        run(keys=("# faces: 8", "# faces: 8", KEYS[1])),
        ", row 1: metadata faces: stated more than once (8; 8), one line was expected",
    ),
    "fewer readings than faces": (
        run(ROWS[:5]),
        ": 5 readings, at least one for each of the 8 faces was expected",
    ),
    "a face read twice": (
        run([*ROWS[:4], ROWS[3], *ROWS[4:]]),
        ", row 8, column position_deg: face 4 (135 deg) is read twice in a row, face 5 (180 deg) was expected",
    ),
    "an earlier face again": (
        run([*ROWS[:5], ROWS[2], *ROWS[5:]]),
        ", row 9, column position_deg: face 3 (90 deg) was already read in row 6 of this round, face 6 (225 deg) was "
        "expected",
    ),
    "faces in the wrong order": (
        run([*ROWS[:2], ROWS[3], ROWS[2], *ROWS[4:]]),
        ", row 6, column position_deg: face 4 (135 deg) stands where face 3 (90 deg) was expected, which comes only in "
        "row 7: faces in the wrong order",
    ),
    "a face skipped": (
        run([*ROWS[:5], *ROWS[6:]]),
        ", row 9, column position_deg: face 7 (270 deg) follows face 5 (180 deg): face 6 (225 deg) was skipped",
    ),
    "an empty row for a reading": (
        run([*ROWS[:5], ",,,", *ROWS[6:]]),
        ", row 10, column position_deg: face 7 (270 deg) follows face 5 (180 deg): face 6 (225 deg) was skipped",
    ),
    "two faces skipped": (
        run([*ROWS[:3], *ROWS[5:], *ROWS[:2]]),
        ", row 7, column position_deg: face 6 (225 deg) follows face 3 (90 deg): face 4 (135 deg) and 1 more "
        "was skipped",
    ),
    "a jump of one face": (
        run([*ROWS[:4], *(f"{float(row.split(',')[0]) + 45:.4f},{row.partition(',')[2]}" for row in ROWS[4:])]),
        ", row 8, column position_deg: face 6 (225 deg) follows face 4 (135 deg): face 5 (180 deg) was skipped",
    ),
    "the last face missing": (
        run([*ROWS, *ROWS[1:7]]),
        ", row 18, column position_deg: round 2 ends after 7 of 8 faces, face 8 (315 deg) is missing",
    ),
    "the certificate changes": (
        run([*ROWS, *ROWS[:3], "135.0,0.5,1.3,0.3", *ROWS[4:]]),
        ", row 16, column face_deviation_arcsec: 0.5 arcsec for face 4 (135 deg), row 7 has 0.4: a face has one "
        "deviation in its certificate",
    ),
    "the closing row with another deviation": (
        changed(12, 1, "1.2"),
        ", row 12, column face_deviation_arcsec: 1.2 arcsec for face 1 (0 deg), row 4 has 0: a face has one "
        "deviation in "
        "its certificate",
    ),
    # Rounds and directions
    "clockwise for counter-clockwise": (
        run([f"{row},1" for row in ROWS[::-1]], f"{NAMES},direction"),
        ", row 5, column position_deg: the direction is +1 (forward), but the position falls back from 360 to 315 deg: "
        "was it turned clockwise for counter-clockwise?",
    ),
    "backward that goes on": (
        with_columns("direction", [-1] * 9),
        ", row 5, column position_deg: the direction is -1 (backward), but the position goes on from 0.0002 to 45.0002 "
        "deg: was it turned clockwise for counter-clockwise?",
    ),
    "direction 0": (
        with_columns("direction", [1, 1, 0, 1, 1, 1, 1, 1, 1]),
        ", row 6, column direction: 0, +1 (forward) or -1 (backward) was expected",
    ),
    "round 0": (with_columns("round", [0] * 9), ", row 4, column round: 0, whole numbers from 1 were expected"),
    "round one and a half": (
        with_columns("round", [1] * 8 + [1.5]),
        ", row 12, column round: 1.5, whole numbers from 1 were expected",
    ),
    "a round in two pieces": (
        run(
            [*(f"{row},1" for row in ROWS), *(f"{row},2" for row in ROWS), *(f"{row},1" for row in ROWS)],
            f"{NAMES},round",
        ),
        ", row 22, column round: round 1 begins a second time, it already stood in rows 4 to 12; each was "
        "expected once, "
        "in one piece",
    ),
    "two rounds under one number": (
        run([f"{row},1" for row in (*ROWS, *ROWS)], f"{NAMES},round"),
        ", row 13, column round: round 1 goes on behind its 8 faces and their closing reading; a new round was "
        "expected",
    ),
    "a round cut short": (
        with_columns("round", [1] * 6 + [2] * 3),
        ", row 9, column position_deg: round 1 ends after 6 of 8 faces, face 7 (270 deg) and 1 more are missing",
    ),
    # Metadata
    "a key misspelt": (
        with_key("# autocolimator_roll_arcmin: 2"),
        ", row 3: the metadata key 'autocolimator_roll_arcmin' is not known, 'autocollimator_roll_arcmin' was probably "
        "meant",
    ),
    "a key in another unit": (
        with_key("# u_autocollimator_arcmin: 0.1"),
        ", row 3: the metadata key 'u_autocollimator_arcmin' is not known, 'u_autocollimator_arcsec' was "
        "probably meant",
    ),
    "a key with capitals": (
        run(keys=("# Faces: 8", KEYS[1])),
        ", row 1: the metadata key 'Faces' is not known, 'faces' was probably meant",
    ),
    "an uncertainty nobody asks for": (
        with_key("# u_moon_phase: 3"),
        ", row 3: the uncertainty 'u_moon_phase' is not one of this kind of run; these are: ",
    ),
    "a sign of 0": (
        run(keys=(KEYS[0], "# autocollimator_sign: 0")),
        ", row 2: metadata autocollimator_sign: 0, +1 or -1 was expected",
    ),
    "a sign in words": (
        run(keys=(KEYS[0], "# autocollimator_sign: plus")),
        ", row 2: metadata autocollimator_sign: 'plus' is not a finite number (1 expected)",
    ),
    "a roll of degrees": (
        with_key("# autocollimator_roll_arcmin: 300"),
        ", row 3: metadata autocollimator_roll_arcmin: 300 arcmin of roll, at most 120 were expected",
    ),
    "a negative uncertainty": (
        with_key("# u_autocollimator_arcsec: -0.1"),
        ", row 3: metadata u_autocollimator_arcsec: -0.1 is below 0, the least that can be",
    ),
    "an uncertainty that is none": (
        with_key("# u_face_certificate_arcsec: 0.1 arcsec"),
        ", row 3: metadata u_face_certificate_arcsec: '0.1 arcsec' is not a finite number (arcsec expected)",
    ),
    "standard and expanded": (
        with_key("# u_face_certificate_arcsec: 0.1", "# expanded_face_certificate_arcsec: 0.2"),
        ", row 4: metadata expanded_face_certificate_arcsec: u_face_certificate_arcsec stands here too, one of "
        "them was "
        "expected",
    ),
    "a grade that is none": (
        with_key("# encoder_grade: 9"),
        ", row 3: metadata encoder_grade: 9, one of 1 .. 7 was expected",
    ),
    "grade and accuracy": (
        with_key("# encoder_grade: 2", "# required_accuracy_arcsec: 1"),
        ", row 3: metadata encoder_grade: required_accuracy_arcsec stands here too, one was expected",
    ),
    "screws in words": (
        with_key("# screw_angles_deg: left and right", "# screw_radius_mm: 60"),
        ", row 3: metadata screw_angles_deg: 'left and right' are no angles; degrees from face 1 were expected, as in "
        "'0 120 240'",
    ),
    "one screw": (
        with_key("# screw_angles_deg: 0", "# screw_radius_mm: 60"),
        ", row 3: metadata screw_angles_deg: '0', 2 to 12 different angles were expected",
    ),
    "screws without a radius": (
        with_key("# screw_angles_deg: 0 120 240", "# screw_radius_mm: 0"),
        ", row 4: metadata screw_radius_mm: 0 mm, more than that was expected",
    ),
}


@pytest.mark.parametrize(("content", "expected"), BAD.values(), ids=BAD.keys())
def test_one_line_and_no_file(tmp_path, arcref, content, expected):
    line = refusal(arcref, "polygon", tmp_path, content)
    if expected.endswith(("the columns are", "these are: ")):
        assert line.startswith(expected)
    else:
        assert line == expected


def test_there_are_forty_or_more():
    assert len(BAD) >= 40


def excel_padded() -> bytes:
    """Metadata padded with empty cells, rows of empty cells, and an empty column behind the last."""
    lines = [f"{key},,,," for key in KEYS] + [f"{NAMES},"] + [f"{row}," for row in ROWS[:4]]
    lines += [",,,,"] + [f"{row}," for row in ROWS[4:]] + [",,,,", ",,,,"]
    return "\r\n".join(lines).encode("utf-8-sig")


def semicolons() -> bytes:
    """What a German Excel writes: semicolons, decimal commas, metadata padded."""
    text = run(keys=(*KEYS, "# u_autocollimator_arcsec: 0.1")).replace(",", ";").replace(".", ",")
    return text.replace("# faces: 8\n", "# faces: 8;;;\n").replace("\n", "\r\n").encode("utf-8-sig")


READ = {
    "a byte order mark": run().encode("utf-8-sig"),
    "Excel's padding": excel_padded(),
    "semicolons and decimal commas": semicolons(),
    "semicolons and decimal points": run().replace(",", ";").encode(),
    "a separator announced": b"sep=;\r\n" + semicolons().removeprefix(b"\xef\xbb\xbf"),
    "commas announced": b"sep=,\n" + run().encode(),
    "metadata in quotation marks": run().replace("# faces: 8", '"# faces: 8",,,').encode(),
    "cells in quotation marks": run().replace("1.2,", '"1.2",').encode(),
    "columns in another order": run(
        [",".join(row.split(",")[::-1]) for row in ROWS], ",".join(NAMES.split(",")[::-1])
    ).encode(),
    "line ends of an old Mac": run().replace("\n", "\r").encode(),
}


@pytest.mark.parametrize("content", READ.values(), ids=READ.keys())
def test_what_excel_makes_of_it_is_read(tmp_path, content):
    plain, path = tmp_path / "plain.csv", tmp_path / "run.csv"
    plain.write_text(run(), encoding="utf-8")
    path.write_bytes(content)
    there, here = (reduce_polygon(read_polygon_run(each)) for each in (plain, path))
    assert (here.error_arcsec == there.error_arcsec).all()
    assert here.tilt.psi_arcsec == there.tilt.psi_arcsec


def test_a_decimal_comma_in_the_metadata_of_a_semicolon_file(tmp_path):
    path = tmp_path / "run.csv"
    path.write_bytes(semicolons())
    assert read_polygon_run(path).run.metadata["u_autocollimator_arcsec"] == "0.1"
