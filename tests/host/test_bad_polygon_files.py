"""Polygon files that cannot be used, through the command: one line on stderr, exit status 2, no file written."""

import subprocess
import sys

import pytest

HEADER = "position_deg,error_arcsec\n"

FACES = "0,0\n90,1\n180,2\n270,-1\n"

NOT_A_NUMBER = "is not a finite number"

BAD = {
    "empty": (b"", ": the file is empty"),
    "metadata alone": ("# date: 2024\n", ": no line of column names, 'position_deg,error_arcsec' were expected"),
    "blank lines alone": ("\n\n", ": no line of column names, 'position_deg,error_arcsec' were expected"),
    "Latin-1": (
        "# operator: Müller\n".encode("latin-1") + (HEADER + FACES).encode(),
        ", row 1: not UTF-8 text: byte 0xFC at offset 13",
    ),
    "a byte of zero": (
        HEADER + "0,0\0\n90,1\n180,2\n270,1\n",
        ": no text: bytes of zero stand in it; UTF-8 text was expected",
    ),
    "UTF-16": (
        (HEADER + FACES).encode("utf-16"),
        ": UTF-16 text, as Excel's 'Unicode Text' is; UTF-8 was expected, which Excel calls 'CSV UTF-8'",
    ),
    "broken UTF-8 further down": (
        HEADER.encode() + b"0,0\n90,\xc3\n",
        ", row 3: not UTF-8 text: byte 0xC3 at offset 33",
    ),
    "no column names": (
        FACES,
        ", row 1: the columns are '0,0', expected were 'position_deg,error_arcsec'",
    ),
    "one column short": (
        "position_deg\n0\n90\n180\n",
        ", row 1: the columns are 'position_deg', expected were 'position_deg,error_arcsec'",
    ),
    "one column more": (
        "position_deg,error_arcsec,weight\n0,0,1\n",
        ", row 1: the columns are 'position_deg,error_arcsec,weight', expected were 'position_deg,error_arcsec'",
    ),
    "another unit": (
        "# unit: minutes\nposition_deg,error_arcmin\n0,0\n",
        ", row 2: the columns are 'position_deg,error_arcmin', expected were 'position_deg,error_arcsec'",
    ),
    "a column twice": (
        "position_deg,error_arcsec,error_arcsec\n0,0,0\n",
        ", row 1: the columns are 'position_deg,error_arcsec,error_arcsec', expected were 'position_deg,error_arcsec'",
    ),
    "semicolons and commas": (
        "position_deg;error_arcsec,\n0;0\n",
        ", row 1: the columns are 'position_deg;error_arcsec', expected were 'position_deg,error_arcsec'",
    ),
    "decimal commas": (
        HEADER + "0,0\n15,0,81\n",
        ", row 3: 3 cells, 2 were expected ('position_deg,error_arcsec'); "
        "decimal commas need semicolons between the columns",
    ),
    "a row cut short": (
        HEADER + "0,0\n90,1\n18",
        ", row 4: 1 cells, 2 were expected ('position_deg,error_arcsec')",
    ),
    "text for a number": (HEADER + "0,0\n90,large\n", f", row 3, column error_arcsec: 'large' {NOT_A_NUMBER}"),
    "a unit in the cell": (HEADER + "0,0\n90 deg,1\n", f", row 3, column position_deg: '90 deg' {NOT_A_NUMBER}"),
    "NaN": (HEADER + "0,0\n90,nan\n", f", row 3, column error_arcsec: 'nan' {NOT_A_NUMBER}"),
    "infinity": (HEADER + "0,0\n-inf,1\n", f", row 3, column position_deg: '-inf' {NOT_A_NUMBER}"),
    "beyond a float": (HEADER + "0,0\n90,1e999\n", f", row 3, column error_arcsec: '1e999' {NOT_A_NUMBER}"),
    "underscores": (HEADER + "0,0\n9_0,1\n", f", row 3, column position_deg: '9_0' {NOT_A_NUMBER}"),
    "other digits": (HEADER + "0,0\n90,١\n", f", row 3, column error_arcsec: '١' {NOT_A_NUMBER}"),
    "an empty cell": (
        HEADER + "0,0\n90,\n",
        ", row 3, column error_arcsec: the cell is empty, a number was expected",
    ),
    "an open quotation mark": (HEADER + '0,0\n"90,1\n180,2\n', ", row 3: not a CSV row: unexpected end of data"),
    "metadata below": (
        HEADER + "0,0\n# note: late\n",
        ", row 3: a line with # stands behind the column names, it belongs before them",
    ),
    "angles out of order": (
        HEADER + "0,0\n180,1\n90,2\n270,3\n",
        ", row 4, column position_deg: 90 deg follows 180 deg, increasing angles were expected",
    ),
    "falling angles": (
        HEADER + "270,0\n180,1\n90,2\n",
        ", row 3, column position_deg: 180 deg follows 270 deg, increasing angles were expected",
    ),
    "repeated with another error": (
        "# a: b\n" + HEADER + "0,0\n90,1\n90,1.5\n180,0\n",
        ", row 5, column position_deg: 90 deg is given twice (before in row 4) with different errors, 1 and 1.5 arcsec",
    ),
    "repeated with the same error": (
        HEADER + "0,0\n90,1\n90,1\n180,0\n",
        ", row 4, column position_deg: 90 deg is given twice (before in row 3), each time with 1 arcsec; "
        "each face was expected once",
    ),
    "repeated far below": (
        HEADER + "0,0\n90,1\n180,1\n0,2\n",
        ", row 5, column position_deg: 0 deg is given twice (before in row 2) with different errors, 0 and 2 arcsec",
    ),
    "beyond the turn": (
        HEADER + FACES + "361,0\n",
        ", row 6, column position_deg: 361 deg is outside the turn 0 .. 360 deg",
    ),
    "far away": (
        HEADER + "1e9,0\n",
        ", row 2, column position_deg: 1e+09 deg, the first angle was expected in -360 .. 360 deg",
    ),
    "no rows": (HEADER, ": 0 faces, at least 3 were expected"),
    "two faces": (HEADER + "0,0\n180,1\n", ": 2 faces, at least 3 were expected"),
    "two faces and the closure row": (
        HEADER + "0,0\n180,1\n360,0\n",
        ": 2 faces besides the closure row, at least 3 were expected",
    ),
    "a closure row that disagrees": (
        HEADER + FACES + "360,0.8\n",
        ", row 6, column error_arcsec: the closure row at 360 deg has 0.8 arcsec, the first row at 0 deg 0 arcsec: "
        "they must agree within 0.5 arcsec",
    ),
    "an error beyond a table entry": (
        HEADER + "0,0\n90,1\n180,-400\n270,0\n",
        ", row 4, column error_arcsec: -400 arcsec, a table entry holds up to +-316.4 arcsec (+-2047.9 counts)",
    ),
    "an error near the end of floats": (
        HEADER + "0,0\n90,1e308\n180,0\n270,0\n",
        ", row 3, column error_arcsec: 1e+308 arcsec, a table entry holds up to +-316.4 arcsec (+-2047.9 counts)",
    ),
}


@pytest.mark.parametrize(("content", "expected"), BAD.values(), ids=BAD.keys())
def test_one_line_and_no_file(tmp_path, arcref, content, expected):
    path = tmp_path / "run.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    result = arcref(
        "rom", path, "-o", tmp_path / "x.rom.json", "--json", tmp_path / "x.json", "--plot", tmp_path / "x.svg"
    )
    assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"arcref: {path}{expected}\n")
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_missing_file(tmp_path, arcref):
    result = arcref("rom", tmp_path / "none.csv", "-o", tmp_path / "x.rom.json")
    assert result.exit_code == 2
    assert result.stderr == f"arcref: {tmp_path / 'none.csv'}: there is no such file\n"
    assert not list(tmp_path.iterdir())


def test_folder(tmp_path, arcref):
    result = arcref("rom", tmp_path, "-o", tmp_path / "x.rom.json")
    assert (result.exit_code, result.stderr) == (2, f"arcref: {tmp_path}: is a folder, a file was expected\n")


def test_a_fit_that_swings_beyond_a_table_entry_between_its_faces(tmp_path, arcref):
    path = tmp_path / "run.csv"
    path.write_text(HEADER + "".join(f"{15 * i},{316 if i // 2 % 2 else -316}\n" for i in range(24)))
    result = arcref("rom", path, "-o", tmp_path / "x.rom.json", "--spread", 30)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"arcref: {path}: the error at ")
    assert result.stderr.endswith("arcsec, a table entry holds up to +-316.4 arcsec (+-2047.9 counts)\n")
    assert [file.name for file in tmp_path.iterdir()] == ["run.csv"]


def test_the_line_is_the_same_in_a_process_of_its_own(tmp_path):
    """The command as a person runs it: no traceback, nothing on stdout."""
    path = tmp_path / "run.csv"
    path.write_text(HEADER + "0,0\n90,nan\n")
    command = [sys.executable, "-m", "arcref.command", "rom", str(path), "-o", str(tmp_path / "x.rom.json")]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert result.returncode == 2
    assert result.stdout == ""
    assert result.stderr == f"arcref: {path}, row 3, column error_arcsec: 'nan' is not a finite number\n"
