"""Closure files that cannot be used, through the command: one line on stderr, exit status 2, no file written."""

import numpy as np
import pytest
from closure_files import COLUMNS, closure_rows, closure_text
from refused_runs import refusal

ROWS = closure_rows(seed=5)
META = "# faces: 8\n# setting_step_deg: 45\n# autocollimator_sign: 1\n"
GOOD = closure_text(ROWS)
FIRST = 5
"""Row of the first reading."""


def changed(index, **cells) -> str:
    """The good run with cells of one row changed."""
    rows = list(ROWS)
    row = dict(zip(("setting", "face", "position", "x"), rows[index], strict=True)) | cells
    rows[index] = tuple(row.values())
    return closure_text(rows)


def every(change) -> str:
    """The good run with each row put through `change`."""
    return closure_text([change(*row) for row in ROWS])


def with_metadata(metadata) -> str:
    return closure_text(ROWS, metadata)


def position(index) -> str:
    return f"{float(f'{ROWS[index][2]:.8f}'):g}"


BAD = {
    "no faces": (
        with_metadata("# setting_step_deg: 45\n"),
        ": metadata faces is missing: state the number of faces, as in '# faces: 24'",
    ),
    "faces no whole number": (
        with_metadata("# faces: 8.5\n# setting_step_deg: 45\n"),
        ", row 1: metadata faces: 8.5 faces, a whole number in 3 .. 360 was expected",
    ),
    "no step": (
        with_metadata("# faces: 8\n"),
        ": metadata setting_step_deg is missing: state by how much the polygon is turned on the encoder from one "
        "setting to the next, as in '# setting_step_deg: 15'",
    ),
    "step in arcmin": (
        with_metadata("# faces: 8\n# setting_step_deg: 2700\n"),
        ", row 2: metadata setting_step_deg: 2700 deg, 0.1 deg to less than a turn were expected, either way",
    ),
    "step misspelt": (
        with_metadata("# faces: 8\n# settings_step_deg: 45\n"),
        ", row 2: the metadata key 'settings_step_deg' is not known, 'setting_step_deg' was probably meant",
    ),
    "step of another run": (
        with_metadata("# faces: 8\n# setting_step_deg: 90\n"),
        f", row {FIRST + 7}, column position_deg: {position(8)} deg: all positions fit settings 45 deg apart, "
        "setting_step_deg states 90",
    ),
    "sign neither way": (
        with_metadata("# faces: 8\n# setting_step_deg: 45\n# autocollimator_sign: 0\n"),
        ", row 3: metadata autocollimator_sign: 0, +1 or -1 was expected",
    ),
    "column lost": (
        META + "setting,face,position_deg\n1,1,0\n",
        ", row 4: the columns are 'setting,face,position_deg', expected were "
        "'setting,face,position_deg,autocollimator_x_arcsec' (and, if wanted, 'round')",
    ),
    "x in arcmin by its name": (
        META + "setting,face,position_deg,autocollimator_x_arcmin\n1,1,0,0\n",
        ", row 4: the columns are 'setting,face,position_deg,autocollimator_x_arcmin', expected were "
        "'setting,face,position_deg,autocollimator_x_arcsec' (and, if wanted, 'round')",
    ),
    "no readings": (
        META + COLUMNS + "\n",
        ": no readings, at least two settings of the polygon were expected",
    ),
    "faces counted from 0": (
        every(lambda s, f, p, x: (s, f - 1, p, x)),
        f", row {FIRST}, column face: 0, a whole number in 1 .. 8 was expected: the first face is 1",
    ),
    "face beyond the polygon": (
        changed(9, face=9),
        f", row {FIRST + 9}, column face: 9, a whole number in 1 .. 8 was expected: are the columns setting and face "
        "swapped, or is metadata faces too small?",
    ),
    "half a setting": (
        changed(3, setting=1.5),
        f", row {FIRST + 3}, column setting: 1.5, a whole number in 1 .. 10000 was expected",
    ),
    "face twice": (
        changed(12, face=ROWS[11][1], position=ROWS[11][2]),
        f", row {FIRST + 12}, column face: face 4 at setting 2 is given twice (before in row {FIRST + 11}); a second "
        "round needs a column round, a closing reading a position one turn further on",
    ),
    "one setting": (
        closure_text(ROWS[:8]),
        ": setting 1 alone: the errors of encoder and polygon cannot be told apart, at least two settings were "
        "expected",
    ),
    "x absurd": (
        changed(20, x=7200.0),
        f", row {FIRST + 20}, column autocollimator_x_arcsec: 7200 arcsec, at most 3600 arcsec were expected",
    ),
    "position absurd": (
        changed(20, position=1e6),
        f", row {FIRST + 20}, column position_deg: 1e+06 deg, at most 36000 deg were expected",
    ),
    "one position a face further": (
        changed(2, position=ROWS[3][2]),
        f", row {FIRST + 2}, column position_deg: {position(3)} deg, near 90 deg was expected (face 3 at setting 1); "
        "face 4 is met there",
    ),
    "position and x swapped in one row": (
        changed(4, position=ROWS[4][3], x=ROWS[4][2]),
        f", row {FIRST + 4}, column position_deg: {float(f'{ROWS[4][3]:.8f}'):g} deg, near 180 deg was expected (face "
        "5 at setting 1); 180 in column autocollimator_x_arcsec fits: are the two swapped?",
    ),
    "positions in arcmin": (
        every(lambda s, f, p, x: (s, f, p * 60, x)),
        f", row {FIRST + 1}, column position_deg: {ROWS[1][2] * 60:g} deg: all positions fit when they are read as "
        "arcmin, degrees were expected",
    ),
    "positions in radians": (
        every(lambda s, f, p, x: (s, f, np.radians(p), x)),
        None,
    ),
    "faces the other way round": (
        every(lambda s, f, p, x: (s, (9 - f) % 8 + 1, p, x)),
        None,
    ),
    "polygon turned the other way": (
        with_metadata("# faces: 8\n# setting_step_deg: -45\n"),
        None,
    ),
    "x with the other sign": (
        with_metadata("# faces: 8\n# setting_step_deg: 45\n# autocollimator_sign: -1\n"),
        None,
    ),
    "x in arcmin under the name of arcsec": (
        every(lambda s, f, p, x: (s, f, p, x / 60)),
        None,
    ),
    "x in arcmin of the other sign": (
        every(lambda s, f, p, x: (s, f, p, -x / 60)),
        None,
    ),
    "x in a unit of its own": (
        every(lambda s, f, p, x: (s, f, p, x / 7)),
        None,
    ),
    "another unit of uncertainty": (
        with_metadata(META + "# u_face_certificate_arcsec: 0.1\n"),
        None,
    ),
    "negative uncertainty": (
        with_metadata(META + "# u_autocollimator_arcsec: -0.1\n"),
        None,
    ),
    "decimal commas": (
        META + COLUMNS + "\n1,1,0,0,0,1\n",
        f", row {FIRST}: 6 cells, 4 were expected ('{COLUMNS}'); decimal commas need semicolons between the columns",
    ),
    "UTF-16": (
        GOOD.encode("utf-16"),
        None,
    ),
    "rounds no whole numbers": (
        META + "round," + COLUMNS + "\n0,1,1,0,0\n0,2,1,45,0\n",
        f", row {FIRST}, column round: 0, a whole number in 1 .. 10000 was expected: the first round is 1",
    ),
}

PARTS = {
    "positions in radians": "column position_deg: ",
    "faces the other way round": "all positions fit faces that are numbered the other way round",
    "polygon turned the other way": "all positions fit a polygon turned the other way: setting_step_deg is 45, not -45",
    "x with the other sign": "with this column with the other sign: autocollimator_sign is +1, not -1",
    "x in arcmin under the name of arcsec": "with this column taken for arcmin",
    "x in arcmin of the other sign": "with this column taken for arcmin and with the other sign",
    "x in a unit of its own": "with this column times 7",
    "another unit of uncertainty": "the uncertainty 'u_face_certificate_arcsec' is not one of this kind of run",
    "negative uncertainty": "u_autocollimator_arcsec: -0.1 is below 0, the least that can be",
    "UTF-16": "UTF-16",
}
"""What the line must say where its numbers come from the noise of the readings."""


@pytest.mark.parametrize("name", BAD)
def test_one_line_and_no_file(tmp_path, arcref, name):
    content, expected = BAD[name]
    line = refusal(arcref, "closure", tmp_path, content)
    if expected is None:
        assert PARTS[name] in line
    else:
        assert line == expected


def test_the_good_run_is_good(tmp_path, arcref):
    (tmp_path / "run.csv").write_text(GOOD)
    assert arcref("calibrate", "closure", tmp_path / "run.csv", "-o", tmp_path / "cal.json").exit_code == 0


def test_as_excel_writes_it(tmp_path, arcref):
    """Semicolons, decimal commas and a byte order mark are read where they are unambiguous."""
    text = GOOD.replace(",", ";").replace(".", ",")
    (tmp_path / "run.csv").write_text(text, encoding="utf-8-sig")
    (tmp_path / "plain.csv").write_text(GOOD)
    for name in ("run", "plain"):
        result = arcref(
            "calibrate",
            "closure",
            tmp_path / f"{name}.csv",
            "-o",
            tmp_path / f"{name}.json",
            "--csv",
            tmp_path / f"{name}.out.csv",
        )
        assert (result.exit_code, result.stderr) == (0, "")
    assert (tmp_path / "run.out.csv").read_text().split("\n")[-3:] == (tmp_path / "plain.out.csv").read_text().split(
        "\n"
    )[-3:]


def test_the_first_words_of_a_column_swap_are_not_a_silent_repair(tmp_path, arcref):
    """Setting and face swapped in a whole set fit the positions as well; the mountings then stand for faces."""
    rows = [(face, setting, position, x + (200 if setting % 2 else -200)) for setting, face, position, x in ROWS]
    (tmp_path / "run.csv").write_text(closure_text([(s, f, p, 3 * x) for s, f, p, x in rows]))
    result = arcref("calibrate", "closure", tmp_path / "run.csv", "-o", tmp_path / "cal.json")
    assert result.exit_code == 2
    assert "more than 300 arcsec is no polygon" in result.stderr
    assert not (tmp_path / "cal.json").exists()
