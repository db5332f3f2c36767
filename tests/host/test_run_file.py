import hashlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from arcref.input_error import InputError
from arcref.run_file import read_run_file

COLUMNS = ("position_deg", "error_arcsec")


@pytest.fixture
def run(tmp_path):
    """Writes a file and reads it: `run(content, optional columns)`."""

    def read(content, optional=()):
        path = tmp_path / "run.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return read_run_file(path, COLUMNS, optional)

    return read


def test_metadata_columns_rows_and_checksum(run):
    content = "# encoder_serial: AR-7\n# a remark\n# note: one\n#note : two: three\n\n"
    content += "position_deg,error_arcsec\n0,1\n\n2,-3.5e1\n"
    result = run(content)
    assert result.metadata == {"encoder_serial": "AR-7", "note": "one; two: three"}
    assert result["position_deg"].tolist() == [0, 2]
    assert result["error_arcsec"].tolist() == [1, -35]
    assert result.rows == (7, 9)
    assert result.file.sha256 == hashlib.sha256(content.encode()).hexdigest()
    assert result.file.record == {"file": "run.csv", "sha256": result.file.sha256}


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_byte_order_mark_and_line_ends(run, end):
    result = run(b"\xef\xbb\xbf" + end.join(["# date: 2024", "position_deg,error_arcsec", "1,2", ""]).encode())
    assert result.metadata == {"date": "2024"}
    assert result["error_arcsec"].tolist() == [2]
    assert result.rows == (3,)


def test_columns_in_any_order_spaces_and_quotes(run):
    result = run(' error_arcsec , "position_deg"\n'.replace(' "', '"') + '"1.5", 30 \n')
    assert result["position_deg"].tolist() == [30]
    assert result["error_arcsec"].tolist() == [1.5]


def test_optional_columns(run):
    result = run("position_deg,error_arcsec,round\n0,1,2\n", optional=("round", "direction"))
    assert result["round"].tolist() == [2]
    with pytest.raises(InputError, match=r"'position_deg,error_arcsec' \(and, if wanted, 'round'\)"):
        run("position_deg,error_arcsec,rounds\n", optional=("round",))


def test_the_error_of_a_reading_names_its_row(run):
    result = run("# a: b\nposition_deg,error_arcsec\n0,1\n")
    assert str(result.error("too large", reading=0, column="error_arcsec")).endswith(
        "run.csv, row 3, column error_arcsec: too large"
    )


@given(st.lists(st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 2), min_size=1))
def test_every_float_comes_back(tmp_path_factory, readings):
    path = tmp_path_factory.mktemp("run") / "run.csv"
    path.write_text("position_deg,error_arcsec\n" + "".join(f"{a!r},{b!r}\n" for a, b in readings))
    result = read_run_file(path, COLUMNS)
    assert np.array_equal(np.column_stack([result[name] for name in COLUMNS]), np.array(readings))


@settings(max_examples=300)
@given(st.binary(max_size=200) | st.text(alphabet='0123456789,.\n\r"#:-eE nai', max_size=200).map(str.encode))
def test_any_bytes_give_a_run_or_one_line(tmp_path_factory, content):
    path = tmp_path_factory.mktemp("run") / "run.csv"
    path.write_bytes(b"position_deg,error_arcsec\n0,0\n" + content)
    try:
        columns, message = read_run_file(path, COLUMNS).columns, ""
    except InputError as error:
        columns, message = {}, str(error)
    assert "\n" not in message
    assert all(np.isfinite(values).all() for values in columns.values())
