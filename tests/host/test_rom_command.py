import hashlib
import json
import shutil

import numpy as np
import pytest

from arcref import __version__
from arcref.calibration.fits.fit_names import FIT_NAMES, fit_curve
from arcref.correction_rom import CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.radial_basis_network import RadialBasisNetwork
from arcref.rom_identity import decode_identity
from arcref.rom_image import load_rom
from arcref.rom_provenance import fit_from_provenance

ERRORS_ARCSEC = [2 * float(np.sin(np.radians(15 * i))) for i in range(24)]

CALIBRATION = {
    "format": "arcref-calibration",
    "version": 1,
    "kind": "polygon",
    "curve": {
        "angle_deg": [15 * i for i in range(24)],
        "error_arcsec": ERRORS_ARCSEC,
        "u_arcsec": [0.2] * 23 + [0.26],
    },
    "results": {},
    "provenance": {"encoder_serial": "AR-7", "date": "2024-05-17"},
}

SUBDIVISION = CALIBRATION | {
    "kind": "subdivision",
    "curve": {
        "line_deg": [5.625 * i for i in range(64)],
        "error_arcsec": [0.3 * float(np.sin(np.radians(4 * 5.625 * i))) for i in range(64)],
    },
}


@pytest.fixture
def polygon(tmp_path, examples):
    """The published run in a folder of its own."""
    return shutil.copy(examples / "polygon_before_correction.csv", tmp_path / "polygon.csv")


def write_json(path, content):
    path.write_text(json.dumps(content))
    return path


def test_published_run(tmp_path, arcref, polygon, table_1):
    result = arcref("rom", polygon, "-o", tmp_path / "x.rom.json", "--json", tmp_path / "figures.json")
    assert (result.exit_code, result.stderr) == (0, "")
    for text in (
        "24, 15 deg apart",
        "15 deg, condition number 17.6",
        "1.136 arcsec (no correction: 1.316 arcsec)",
        "-2.163 .. +3.302 arcsec",
        "No uncertainty was stated",
        "Resolution is not accuracy",
    ):
        assert text in result.stdout
    rom = load_rom(tmp_path / "x.rom.json")
    assert f"0x{rom.crc32:08X}" in result.stdout
    network = RadialBasisNetwork.fit(table_1)
    middle_deg = (np.arange(4096) + 0.5) * 360 / 4096
    fit_sixteenths = network.evaluate(middle_deg) * 2**23 / 1296000 * 16
    assert np.abs(rom.line_table - fit_sixteenths).max() < 1
    assert not rom.subdivision_table.any()
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert figures["rounding_max_counts"] < 0.6
    assert figures["residual_at_faces_max_arcsec"] < 1e-12
    assert figures["leave_one_out_rms_arcsec"] == pytest.approx(1.136, abs=5e-4)
    assert figures["crc32"] == rom.crc32


def test_provenance_of_the_published_run(tmp_path, arcref, polygon):
    arcref("rom", polygon, "-o", tmp_path / "x.rom.json")
    provenance = load_rom(tmp_path / "x.rom.json").provenance
    (record,) = provenance["inputs"]
    assert record["file"] == "polygon.csv"
    with open(polygon, "rb") as file:
        assert record["sha256"] == hashlib.sha256(file.read()).hexdigest()
    assert provenance["encoder_serial"] is None
    assert provenance["date"] is None
    assert provenance["expanded_uncertainty_arcsec"] is None
    assert provenance["expanded_uncertainty_reason"] == "the input is a reduced curve that states no uncertainty"
    assert provenance["arcref_version"] == __version__
    assert provenance["method"]["name"] == "wrapped RBF network"
    assert provenance["method"]["spread_deg"] == 15


def test_serial_and_date_come_from_the_metadata(tmp_path, arcref, polygon):
    with open(polygon, encoding="utf-8") as file:
        content = file.read()
    (tmp_path / "own.csv").write_text("# encoder_serial: AR-9\n# date: 2023-11-02\n" + content)
    arcref("rom", tmp_path / "own.csv", "-o", tmp_path / "x.rom.json")
    words = [int(line, 16) for line in (tmp_path / "x.identity.mem").read_text().split()]
    identity = decode_identity(np.array(words))
    assert identity.values["serial"] == "AR-9"
    assert identity.values["date"] == "2023-11-02"
    assert identity.values["expanded uncertainty"] == "not stated"
    assert identity.table_crc32 == load_rom(tmp_path / "x.rom.json").crc32


def test_same_input_same_bytes(tmp_path, arcref, polygon):
    def files(name):
        folder = tmp_path / name
        folder.mkdir()
        result = arcref("rom", polygon, "-o", folder / "x.rom.json", "--plot", folder / "x.svg", "--json", folder / "j")
        assert result.exit_code == 0
        return {path.name: path.read_bytes() for path in folder.iterdir()}

    first = files("a")
    assert first == files("b")
    assert set(first) == {"x.rom.json", "x.line.mem", "x.subdivision.mem", "x.identity.mem", "x.svg", "j"}
    assert first["x.svg"].startswith(b"<?xml")


def test_calibration_with_uncertainty_and_subdivision(tmp_path, arcref):
    # The faces see the error within the line, too: on 24 of them it looks like order 8.
    seen = [error + 0.3 * float(np.sin(2 * np.pi * 16384 * i / 24)) for i, error in enumerate(ERRORS_ARCSEC)]
    curve = CALIBRATION["curve"] | {"error_arcsec": seen}
    calibration = write_json(tmp_path / "cal.json", CALIBRATION | {"curve": curve})
    within_line = write_json(tmp_path / "within.json", SUBDIVISION)
    result = arcref("rom", calibration, "--subdivision", within_line, "-o", tmp_path / "x.rom.json")
    assert result.exit_code == 0, result.stderr
    assert "taken off" in result.stdout
    assert "Caution: the error within a line was taken off at the angles of the curve." in result.stdout
    assert "second table states none of its own" in " ".join(result.stdout.split())
    assert "0.528 arcsec (k=2)" in result.stdout  # 0.52 at the worst face, and rounding to a count
    rom = load_rom(tmp_path / "x.rom.json")
    assert rom.provenance["encoder_serial"] == "AR-7"
    assert rom.provenance["expanded_uncertainty_arcsec"] == 0.528
    assert [record["kind"] for record in rom.provenance["inputs"]] == ["polygon", "subdivision"]
    within = rom.subdivision_table / 16 * 1296000 / 2**23
    phase = np.radians((np.arange(512) + 0.5) * 360 / 512)
    assert np.abs(within - 0.3 * np.sin(4 * phase)).max() < 0.011
    position = np.arange(2**23)[::101]
    angle = position * 2 * np.pi / 2**23
    error = 2 * np.sin(angle) + 0.3 * np.sin(4 * 4096 * angle)
    left = error - rom.correction(position) * 1296000 / 2**23
    # Rounding, and the chords between the curve's 64 points.
    assert np.abs(left).max() < 0.65 * 1296000 / 2**23


def test_spread_and_ridge_are_used(tmp_path, arcref, polygon, table_1):
    result = arcref("rom", polygon, "-o", tmp_path / "x.rom.json", "--spread", "12.5", "--ridge", "0.2")
    assert result.exit_code == 0
    method = load_rom(tmp_path / "x.rom.json").provenance["method"]
    network = RadialBasisNetwork.fit(table_1, 12.5, 0.2)
    assert method["spread_deg"] == 12.5
    assert method["ridge"] == 0.2
    assert method["leave_one_out_rms_arcsec"] == round(network.leave_one_out_rms_arcsec, 3)


@pytest.mark.parametrize(("spread", "caution"), [("25", "foretold worse"), ("5", "falls back to zero between")])
def test_cautions(tmp_path, arcref, polygon, spread, caution):
    assert caution in arcref("rom", polygon, "-o", tmp_path / "x.rom.json", "--spread", spread).stdout


def test_a_part_of_the_turn_is_cautioned(tmp_path, arcref):
    (tmp_path / "part.csv").write_text("position_deg,error_arcsec\n0,1\n10,2\n20,1\n30,0\n")
    result = arcref("rom", tmp_path / "part.csv", "-o", tmp_path / "x.rom.json")
    assert "nothing was measured in the 330 deg behind 30 deg" in " ".join(result.stdout.split())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--spread", "60"], "a spread c of 60 deg is badly conditioned (condition number above 1e+16"),
        (["--spread", "45"], "a spread c of 45 deg is badly conditioned (condition number 4.1e+13, the limit"),
        (["--spread", "nan"], "the spread is nan deg, a positive number was expected"),
        (["--ridge", "-1"], "the ridge is -1, zero or a positive number was expected"),
        (["--plot", "x.gif"], "x.gif: a plot's name must end in .svg, .png, .pdf"),
    ],
)
def test_bad_options(tmp_path, arcref, polygon, options, message):
    result = arcref("rom", polygon, "-o", tmp_path / "x.rom.json", *options)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"arcref: {message}")
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["polygon.csv"]


def test_the_measured_data_are_never_overwritten(tmp_path, arcref, polygon):
    before = ErrorCurve.from_polygon_csv(polygon).provenance
    for options in (["-o", polygon], ["-o", tmp_path / "x.rom.json", "--json", polygon]):
        result = arcref("rom", polygon, *options)
        assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    calibration = write_json(tmp_path / "cal.json", CALIBRATION)
    result = arcref("rom", calibration, "-o", calibration)
    assert result.stderr == f"arcref: {calibration}: this name is given to two files of this run\n"
    assert json.loads(calibration.read_text()) == CALIBRATION
    assert ErrorCurve.from_polygon_csv(polygon).provenance == before


def test_output_in_a_missing_folder(tmp_path, arcref, polygon):
    output = tmp_path / "none" / "x.rom.json"
    result = arcref("rom", polygon, "-o", output)
    assert result.exit_code == 2
    assert result.stderr == f"arcref: {output}: its folder does not exist\n"


def test_a_file_name_with_brackets_is_shown_as_it_is(tmp_path, arcref, examples):
    path = shutil.copy(examples / "polygon_before_correction.csv", tmp_path / "[red]run.csv")
    assert "[red]run.csv" in arcref("rom", path, "-o", tmp_path / "x.rom.json").stdout.replace("\n", "")


@pytest.mark.parametrize("name", FIT_NAMES)
def test_every_fit_makes_a_rom_that_its_provenance_makes_again(tmp_path, arcref, polygon, table_1, name):
    result = arcref("rom", polygon, "--fit", name, "-o", tmp_path / "x.rom.json", "--plot", tmp_path / "x.svg")
    assert (result.exit_code, result.stderr) == (0, "")
    image = load_rom(tmp_path / "x.rom.json")
    method = image.provenance["method"]
    fit = fit_curve(table_1, name)
    assert method["fit"] == name
    assert method["name"] == fit.title
    assert fit.title in " ".join(result.stdout.split())
    assert {key: method[key] for key in fit.parameters} == fit.parameters
    again = CorrectionRom.from_fit(fit_from_provenance(table_1, image.provenance).evaluate)
    assert np.array_equal(again.line_table, image.line_table)


def test_a_provenance_before_there_were_several_fits_means_the_network(table_1):
    fit = fit_from_provenance(table_1, {"method": {"name": "wrapped RBF network", "spread_deg": 12.5, "ridge": 0.1}})
    assert (fit.name, fit.parameters) == ("rbf", {"spread_deg": 12.5, "ridge": 0.1})
    for method in (None, "text", {}, {"spread_deg": True, "ridge": "0"}):
        assert fit_from_provenance(table_1, {"method": method}).parameters == {"spread_deg": 15, "ridge": 0}


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--fit", "spline", "--spread", "15"], "--spread belongs to --fit rbf, --fit spline was chosen"),
        (["--order", "3"], "--order belongs to --fit fourier, --fit rbf was chosen"),
        (["--fit", "fourier", "--ridge", "0"], "--ridge belongs to --fit rbf, --fit fourier was chosen"),
        (["--fit", "fourier", "--order", "12"], "a Fourier series of order 12 was asked for, 24 faces carry order 0"),
        (["--fit", "fourier", "--order", "-1"], "a Fourier series of order -1 was asked for, 24 faces carry order 0"),
    ],
)
def test_options_of_another_fit(tmp_path, arcref, polygon, options, message):
    result = arcref("rom", polygon, "-o", tmp_path / "x.rom.json", *options)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"arcref: {message}")
    assert result.stderr.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["polygon.csv"]


@pytest.mark.parametrize(
    ("stated", "options", "expected", "basis"),
    [
        (0.7, [], 0.7, "the calibration's uncertainty budget of a corrected angle"),
        (0.1, [], 0.1, "the calibration's uncertainty budget of a corrected angle"),
        (0.7, ["--fit", "spline"], 0.7, "the calibration's uncertainty budget of a corrected angle, made for another"),
        (0.1, ["--spread", "14"], 0.528, "largest of all corrected angles"),
        (None, [], 0.528, "largest of all corrected angles"),
        ("0.7", [], 0.528, "largest of all corrected angles"),
    ],
)
def test_the_budget_states_the_uncertainty_of_its_own_fit(tmp_path, arcref, stated, options, expected, basis):
    results = {
        "expanded_uncertainty_arcsec": stated,
        "fit": {"name": "rbf", "parameters": {"spread_deg": 15, "ridge": 0}},
    }
    calibration = write_json(tmp_path / "cal.json", CALIBRATION | {"results": results})
    assert arcref("rom", calibration, *options, "-o", tmp_path / "x.rom.json").exit_code == 0
    provenance = load_rom(tmp_path / "x.rom.json").provenance
    assert provenance["expanded_uncertainty_arcsec"] == expected
    assert provenance["expanded_uncertainty_basis"].startswith(basis)


def theodolite(tmp_path, first_deg, last_deg):
    """A calibration over an arc, error 2 arcsec at its start and 4 at its end."""
    angle = np.arange(first_deg, last_deg + 1.0)
    curve = {
        "angle_deg": angle.tolist(),
        "error_arcsec": (2 + 2 * (angle - first_deg) / (last_deg - first_deg)).tolist(),
        "u_arcsec": [0.3] * angle.size,
        "arc_deg": [first_deg, last_deg],
    }
    return write_json(tmp_path / "arc.json", CALIBRATION | {"kind": "theodolite", "curve": curve})


@pytest.mark.parametrize("name", FIT_NAMES)
@pytest.mark.parametrize(("first_deg", "last_deg"), [(0.0, 40.0), (-20.0, 20.0), (340.0, 380.0)])
def test_outside_an_arc_the_table_is_0_and_the_edge_is_said(tmp_path, arcref, first_deg, last_deg, name):
    calibration = theodolite(tmp_path, first_deg, last_deg)
    result = arcref("rom", calibration, "--fit", name, "-o", tmp_path / "x.rom.json", "--json", tmp_path / "j")
    assert (result.exit_code, result.stderr) == (0, "")
    image = load_rom(tmp_path / "x.rom.json")
    middle_deg = (np.arange(4096) + 0.5) * 360 / 4096
    along = (middle_deg - first_deg) % 360
    inside = along <= last_deg - first_deg
    assert not image.line_table[~inside].any()
    error_counts = (2 + 2 * along / (last_deg - first_deg)) * 2**23 / 1296000
    assert np.abs(image.line_table[inside] / 16 - error_counts[inside]).max() < (3 if name == "gaussian-process" else 1)
    method = image.provenance["method"]
    assert method["arc_deg"] == [first_deg, last_deg]
    assert method["outside_the_arc"] == "not measured, the table is 0"
    first, last = method["corrected_lines"]
    lines = np.arange(first, last + 1 if last >= first else last + 4097) % 4096
    assert set(lines) == set(np.flatnonzero(inside))
    text = " ".join(result.stdout.split())
    assert f"{first_deg:g} .. {last_deg:g} deg, the table is 0 outside" in text
    assert f"grating lines {first} .. {last}" in text
    assert "at the edges the corrected angle steps" in text
    assert "nothing was measured in the" not in text
    figures = json.loads((tmp_path / "j").read_text())
    before, after = (image.correct(line * 2048 - 1) + 1 for line in (first, last + 1))
    assert figures["step_at_first_edge_arcsec"] == pytest.approx(
        (image.correct(first * 2048) - before) * 1296000 / 2**23, abs=0.1
    )
    assert figures["step_at_last_edge_arcsec"] == pytest.approx(
        (image.correct((last + 1) * 2048) - after) * 1296000 / 2**23, abs=0.1
    )


def test_an_arc_has_places_and_no_faces(tmp_path, arcref):
    angle = [2.0 * place for place in range(21)]
    curve = {
        "angle_deg": angle,
        "error_arcsec": [float(np.sin(np.radians(9 * deg))) for deg in angle],
        "u_arcsec": [0.2] * 21,
        "arc_deg": [0.0, 40.0],
    }
    (tmp_path / "arc.json").write_text(json.dumps(CALIBRATION | {"kind": "theodolite", "curve": curve}))
    result = arcref("rom", tmp_path / "arc.json", "-o", tmp_path / "x.rom.json")
    assert result.exit_code == 0, result.output
    assert "places" in result.stdout
    assert "residual at the places" in result.stdout
    assert "face" not in result.stdout
