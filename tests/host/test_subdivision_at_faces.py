"""What the error within a line puts into a calibration over the turn, and that it is taken off once and exactly."""

import numpy as np
import pytest
from click.testing import CliRunner
from closure_files import closure_rows, closure_text

from arcref.calibration.polygon_reduction import reduce_polygon
from arcref.calibration.polygon_result import polygon_result
from arcref.calibration.polygon_run import read_polygon_run
from arcref.calibration_file import readings_json
from arcref.command import main
from arcref.error_curve import ErrorCurve
from arcref.input_error import InputError
from arcref.radial_basis_network import RadialBasisNetwork
from arcref.subdivision_at_faces import without_subdivision
from arcref.subdivision_curve import SubdivisionCurve

LINE_DEG = (np.arange(512) + 0.5) * (360 / 512)


def within(line_deg):
    """Orders 1, 2 and 4 of a line, 1 arcsec peak to peak or so."""
    phase = np.radians(line_deg)
    return 0.2 * np.sin(phase + 1) + 0.15 * np.cos(2 * phase) + 0.25 * np.sin(4 * phase + 0.4)


def over_turn(angle_deg):
    return 2.0 * np.sin(np.radians(angle_deg)) + 0.7 * np.sin(2 * np.radians(angle_deg) + 0.3)


TABLE = SubdivisionCurve(LINE_DEG, within(LINE_DEG), {"inputs": []}, np.full(512, 0.03))


HALF_COUNT_DEG = 180.0 / 2**23


def curve_of(angle_deg, weight, *, half_deg=0.0, **more):
    """The curve of readings with both errors in them, zero at its first face; a count stands for its middle."""
    error = over_turn(angle_deg) + within(np.mod((angle_deg + half_deg) * 4096, 360))
    mean = (error * weight).sum(axis=1)
    return ErrorCurve(angle_deg.mean(axis=1), mean - mean[0], np.full(len(mean), 0.04), **more)


def order_8(curve):
    """Amplitude of order 8 in the ROM's line table."""
    line_deg = (np.arange(4096) + 0.5) * (360 / 4096)
    return 2 * np.abs(np.fft.rfft(RadialBasisNetwork.fit(curve).evaluate(line_deg))[8]) / 4096


def test_24_faces_take_it_for_order_8_and_do_not_when_it_is_taken_off():
    angle = np.arange(24.0)[:, np.newaxis] * 15
    curve = curve_of(angle, np.ones(1))
    assert order_8(curve) > 0.15
    taken = without_subdivision(curve, TABLE)
    assert order_8(taken.curve) < 0.001
    assert np.allclose(taken.curve.error_arcsec, over_turn(angle[:, 0]) - over_turn(0.0), atol=2e-4)
    assert "single readings are not known" in taken.basis


def test_each_reading_is_freed_at_its_own_phase():
    """The shaft stops 20 arcsec beside each face, 23 deg of a line: the nominal phase would not do."""
    rng = np.random.default_rng(1)
    readings = np.arange(24)[:, np.newaxis] * 15 + rng.standard_normal((24, 3)) * 20 / 3600
    weight = np.array([0.25, 0.25, 0.5])
    known = {"half_deg": HALF_COUNT_DEG, "readings_deg": readings, "reading_weight": weight}
    exact = without_subdivision(curve_of(readings, weight, **known), TABLE).curve
    truth = (over_turn(readings) * weight).sum(axis=1)
    assert np.abs(exact.error_arcsec - (truth - truth[0])).max() < 1e-3
    nominal = without_subdivision(curve_of(readings, weight), TABLE).curve
    assert np.abs(nominal.error_arcsec - (truth - truth[0])).max() > 0.05


def test_readings_that_are_missing_have_no_weight():
    readings = np.array([[0.0, 360.0], [15.0, np.nan], [30.0, 390.0], [200.0, np.nan]])
    curve = ErrorCurve(readings[:, 0], np.zeros(4), None, readings_deg=readings, reading_weight=np.array([0.5, 0.5]))
    part = without_subdivision(curve, TABLE).part_arcsec
    phase = np.mod((readings[:, 0] + HALF_COUNT_DEG) * 4096, 360)
    assert np.allclose(part, within(phase) - within(phase[0]), atol=1e-3)


def test_the_table_of_nothing_takes_nothing_off_and_uncertainties_add():
    readings = np.arange(24)[:, np.newaxis] * 15.0
    curve = curve_of(readings, np.ones(1))
    flat = SubdivisionCurve(LINE_DEG, np.zeros(512), {"inputs": []}, None)
    assert np.array_equal(without_subdivision(curve, flat).curve.error_arcsec, curve.error_arcsec)
    assert np.allclose(without_subdivision(curve, TABLE).curve.u_arcsec, 0.05)


@pytest.mark.parametrize(("stated", "largest"), [("yes", 0.0), ("no", None), ("perhaps", "error")])
def test_readings_corrected_already_are_left_alone(stated, largest):
    provenance = {"inputs": [{"provenance": {"inputs": [{"metadata": {"subdivision_corrected": stated}}]}}]}
    curve = curve_of(np.arange(24)[:, np.newaxis] * 15.0, np.ones(1), provenance=provenance)
    if largest == "error":
        with pytest.raises(InputError, match="yes or no was expected"):
            without_subdivision(curve, TABLE)
    elif largest == 0.0:
        assert without_subdivision(curve, TABLE).largest_arcsec == 0.0
    else:
        assert without_subdivision(curve, TABLE).largest_arcsec > 0.1


def test_a_polygon_calibration_keeps_the_angles_of_its_readings(tmp_path):
    rows = [
        f"{15 * face + 0.001 * turn + 360 * (face == 24):.6f},0.1,{turn + 1}" for turn in (0, 1) for face in range(24)
    ]
    text = "# faces: 24\n# autocollimator_sign: +1\nposition_deg,autocollimator_x_arcsec,round\n"
    (tmp_path / "run.csv").write_text(text + "\n".join(rows) + "\n")
    readings = polygon_result(reduce_polygon(read_polygon_run(tmp_path / "run.csv"))).results["readings"]
    assert readings["weight"] == [0.5, 0.5]
    assert readings["position_deg"][3] == [45.0, 45.001]
    assert readings == readings_json(np.array(readings["position_deg"]), readings["weight"])


def test_a_closure_calibration_is_freed_at_the_phases_of_all_its_settings(tmp_path):
    """Eight faces, eight settings, each stop 5 arcsec off: what is left is the calibration of an encoder without it."""
    curves = []
    for faulty in (False, True):
        rows = [
            (setting, face, position, x + (within(np.mod((position + HALF_COUNT_DEG) * 4096, 360)) if faulty else 0.0))
            for setting, face, position, x in closure_rows(noise_arcsec=0.0)
        ]
        run, cal = tmp_path / "run.csv", tmp_path / "cal.json"
        run.write_text(closure_text(rows))
        result = CliRunner().invoke(main, ["calibrate", "closure", str(run), "-o", str(cal)])
        assert cal.exists(), result.output
        curves.append(ErrorCurve.from_calibration_json(cal))
    clean, seen = (curve.error_arcsec for curve in curves)
    assert np.ptp(seen - clean) > 0.1
    freed = without_subdivision(curves[1], TABLE).curve.error_arcsec
    assert np.ptp(freed - clean) < 2e-3
