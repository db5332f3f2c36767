import json

import numpy as np
import pytest

from arcref.error_curve import ErrorCurve
from arcref.error_statistics import ErrorStatistics
from arcref.input_error import InputError
from arcref.subdivision_curve import SubdivisionCurve

GOOD = {
    "format": "arcref-calibration",
    "version": 1,
    "kind": "polygon",
    "curve": {"angle_deg": [0, 90, 180, 270], "error_arcsec": [0, 1, -1, 0.5], "u_arcsec": [0.1, 0.2, 0.3, 0.2]},
    "results": {},
    "provenance": {"encoder_serial": "AR-7", "date": "2024-05-17"},
}

LINE_DEG = [i * 360 / 64 for i in range(64)]

WITHIN_LINE = GOOD | {
    "kind": "subdivision",
    "curve": {"line_deg": LINE_DEG, "error_arcsec": [float(np.sin(np.radians(4 * deg))) for deg in LINE_DEG]},
}


@pytest.fixture
def file(tmp_path):
    """Writes an object as JSON, or text as it is."""

    def write(content):
        path = tmp_path / "cal.json"
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        return path

    return write


def test_published_table(table_1):
    assert table_1.angle_deg.tolist() == list(range(0, 360, 15))
    assert table_1.error_arcsec[3] == 2.28
    assert table_1.u_arcsec is None
    assert table_1.closure_row == (360.0, 0.0)
    assert table_1.spacing_deg == 15
    assert table_1.places[0] == {"row": 6, "column": "error_arcsec"}
    assert table_1.provenance["inputs"][0]["file"] == "polygon_before_correction.csv"


def test_table_without_closure_row(table_3):
    assert table_3.closure_row is None
    assert table_3.angle_deg[0] == 5
    assert len(table_3.values(with_closure=True)) == 24


def test_closure_tolerance(file):
    path = file("position_deg,error_arcsec\n0,0\n120,1\n240,2\n360,0.5\n")
    assert ErrorCurve.from_polygon_csv(path).closure_row == (360, 0.5)
    with pytest.raises(InputError, match="within 0.4 arcsec"):
        ErrorCurve.from_polygon_csv(path, closure_tolerance_arcsec=0.4)


def test_unequal_spacing(file):
    curve = ErrorCurve.from_polygon_csv(file("position_deg,error_arcsec\n-10,0\n0,1\n10,2\n20,1\n"))
    assert curve.gaps_deg.tolist() == [10, 10, 10, 330]
    assert curve.spacing_deg == 10


def test_statistics_by_hand():
    assert ErrorStatistics.of([1.0, 2.0, 6.0]) == ErrorStatistics(3, 3.0, 7.0**0.5, 5.0)
    with pytest.raises(ValueError, match="at least two"):
        ErrorStatistics.of([1.0])


def test_arrays_must_match():
    with pytest.raises(ValueError, match="one length"):
        ErrorCurve([0, 1, 2], [0, 1])


def test_calibration(file):
    curve = ErrorCurve.from_calibration_json(file(GOOD))
    assert curve.angle_deg.tolist() == [0, 90, 180, 270]
    assert curve.u_arcsec.tolist() == [0.1, 0.2, 0.3, 0.2]
    assert curve.provenance["encoder_serial"] == "AR-7"
    assert curve.provenance["inputs"][0]["kind"] == "polygon"


def test_calibration_without_uncertainty(file):
    content = GOOD | {"curve": {**GOOD["curve"], "u_arcsec": None}}
    assert ErrorCurve.from_calibration_json(file(content)).u_arcsec is None


def test_subdivision_is_periodic(file):
    curve = SubdivisionCurve.from_calibration_json(file(WITHIN_LINE))
    phase = np.linspace(-400, 800, 2001)
    # Straight lines between 64 points miss a sine of order 4 by its curvature, (4 * 2 pi / 64)^2 / 8 = 0.019.
    assert np.abs(curve.evaluate(phase) - np.sin(np.radians(4 * phase))).max() < 0.02


def with_curve(content=GOOD, **changes):
    return content | {"curve": {**content["curve"], **changes}}


def test_arc(file):
    part = with_curve(angle_deg=[-5, 0, 5, 10])
    assert ErrorCurve.from_calibration_json(file(part)).arc_deg is None
    named = with_curve(part, arc_deg=[-6, 10])
    assert ErrorCurve.from_calibration_json(file(named)).arc_deg == (-6, 10)
    theodolite = part | {"kind": "theodolite"}
    assert ErrorCurve.from_calibration_json(file(theodolite)).arc_deg == (-5, 10)
    around = GOOD | {"kind": "theodolite"}
    assert ErrorCurve.from_calibration_json(file(around)).arc_deg is None


BAD = {
    "format": (GOOD | {"format": "arcref-rom"}, "column format: is 'arcref-rom', 'arcref-calibration' was expected"),
    "version": (GOOD | {"version": True}, "column version: is True, 1 was expected"),
    "kind": (
        GOOD | {"kind": "subdivision"},
        "column kind: is 'subdivision', 'polygon' or 'closure' or 'theodolite' was expected",
    ),
    "kind is a list": (GOOD | {"kind": ["polygon"]}, "column kind: is ['polygon'], 'polygon' or"),
    "curve": (GOOD | {"curve": [1]}, "column curve: is [1], a JSON object was expected"),
    "no angles": (with_curve(angle_deg=None), "column curve.angle_deg: is missing, a list of numbers was expected"),
    "lengths": (with_curve(error_arcsec=[1, 2]), "column curve.error_arcsec: has 2 numbers, 4 were expected"),
    "NaN": (
        with_curve(error_arcsec=[0, float("nan"), 1, 2]),
        "column curve.error_arcsec[1]: is nan, a finite number was expected",
    ),
    "text": (with_curve(angle_deg=[0, "90", 180, 270]), "column curve.angle_deg[1]: is '90', a finite number"),
    "huge integer": (with_curve(angle_deg=[0, 10**400, 180, 270]), "column curve.angle_deg[1]: is 1000"),
    "u below zero": (with_curve(u_arcsec=[1, 1, 1, -0.1]), "column curve.u_arcsec[3]: is -0.1, an uncertainty"),
    "order": (with_curve(angle_deg=[0, 180, 90, 270]), "column curve.angle_deg[2]: 90 deg follows 180 deg"),
    "repeated": (
        with_curve(angle_deg=[0, 90, 90, 270]),
        "column curve.angle_deg[2]: 90 deg is given twice (before in curve.angle_deg[1]) with different",
    ),
    "arc, text": (with_curve(arc_deg="0..40"), "column curve.arc_deg: is '0..40', a list of numbers was expected"),
    "arc of one": (with_curve(arc_deg=[0]), "column curve.arc_deg: has 1 numbers, 2 were expected, the first and the"),
    "arc backwards": (with_curve(arc_deg=[40, 0]), "column curve.arc_deg: is 40 .. 0 deg, an increasing arc of less"),
    "arc of a turn": (with_curve(arc_deg=[0, 360]), "column curve.arc_deg: is 0 .. 360 deg, an increasing arc of less"),
    "arc too short": (
        with_curve(arc_deg=[0, 200]),
        "column curve.arc_deg: is 0 .. 200 deg, which leaves out angles of curve.angle_deg",
    ),
    "provenance": (GOOD | {"provenance": "me"}, "column provenance: is 'me', a JSON object was expected"),
    "provenance NaN": (
        GOOD | {"provenance": {"t": float("inf")}},
        "column provenance: holds a number that is not finite",
    ),
}


@pytest.mark.parametrize(("content", "expected"), BAD.values(), ids=BAD.keys())
def test_bad_calibration(file, content, expected):
    with pytest.raises(InputError) as caught:
        ErrorCurve.from_calibration_json(file(content))
    assert str(caught.value).startswith(f"{file(content)}, {expected}")


BAD_SUBDIVISION = {
    "kind": (GOOD, "column kind: is 'polygon', 'subdivision' was expected"),
    "few": (
        with_curve(WITHIN_LINE, line_deg=[0, 90, 180], error_arcsec=[0, 0, 0]),
        "column curve.line_deg: has 3 points, at least 8 were expected",
    ),
    "order": (
        with_curve(WITHIN_LINE, line_deg=[*LINE_DEG[:-1], 0]),
        "column curve.line_deg[63]: is 0, increasing phases within 360 deg of the first were expected",
    ),
    "a whole line": (
        with_curve(WITHIN_LINE, line_deg=[*LINE_DEG[:-1], 360]),
        "column curve.line_deg[63]: is 360, increasing phases",
    ),
}


@pytest.mark.parametrize(("content", "expected"), BAD_SUBDIVISION.values(), ids=BAD_SUBDIVISION.keys())
def test_bad_subdivision(file, content, expected):
    with pytest.raises(InputError) as caught:
        SubdivisionCurve.from_calibration_json(file(content))
    assert str(caught.value).startswith(f"{file(content)}, {expected}")
