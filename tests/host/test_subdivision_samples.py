"""`arcref calibrate subdivision` on samples of sine and cosine: from run file to CAL.json, report and ROM table."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from made_signals import UnevenSpeed, at_equal_angles, in_time, write_columns
from published_signals import published_signals

from arcref.correction_rom import CorrectionRom
from arcref.rom_image import load_rom
from arcref.subdivision.signal_model import SignalModel, line_phases_rad, wrapped_rad
from arcref.subdivision_curve import SubdivisionCurve

NAMES, TIME_NAMES = "sample,sine_v,cosine_v", "time_s,sine_v,cosine_v"

STATED = {"samples_per_period": 64, "line_count": 4096, "cosine_sign": -1, "count_zero_phase_deg": 0}
STATED |= {"u_count_zero_phase_deg": 0.5, "speed_change_percent": 0.05}


@pytest.fixture
def published(tmp_path):
    """One period of the published signals, as the paper samples it."""
    path = tmp_path / "published.csv"
    write_columns(path, NAMES, at_equal_angles(published_signals(), 1), {"samples_per_period": 64, "line_count": 16384})
    return path


def calibrated(arcref, run, *options) -> dict:
    output = run.with_suffix(".cal.json")
    done = arcref("calibrate", "subdivision", run, "-o", output, *options)
    assert done.exit_code == 0, done.output
    return json.loads(output.read_text()) | {"printed": done.output}


def test_the_published_signals(arcref, published):
    content = calibrated(arcref, published)
    assert (content["format"], content["version"], content["kind"]) == ("arcref-calibration", 1, "subdivision")
    curve = content["curve"]
    assert set(curve) == {"line_deg", "error_arcsec", "u_arcsec"}
    assert len({len(values) for values in curve.values()}) == 1
    assert max(curve["error_arcsec"]) == pytest.approx(0.511, abs=1e-3)
    assert min(curve["error_arcsec"]) == pytest.approx(-0.480, abs=1e-3)
    truth = published_signals()
    for name, channel in (("sine", truth.sine.canonical), ("cosine", truth.cosine.canonical)):
        found = content["results"][name]
        assert found["offset_v"] == pytest.approx(channel.offset_v, abs=1e-8)
        assert set(found["harmonics"]) == {"1", "3", "5"}
        for order, wave in channel.harmonics.items():
            assert found["harmonics"][str(order)]["amplitude_v"] == pytest.approx(wave.amplitude_v, abs=1e-8)
            turn = found["harmonics"][str(order)]["phase_rad"] - wave.phase_rad
            assert np.remainder(turn + 1, 2 * np.pi) - 1 == pytest.approx(0, abs=1e-6)
    assert "+0.510 / -0.479, 0.990 arcsec peak to peak" in re.sub(r"\s+", " ", content["printed"])


def test_the_curve_stands_where_the_count_is_a_multiple_of_a_line(arcref, tmp_path):
    signals = replace(published_signals(4096))
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(signals, 3), STATED | {"count_zero_phase_deg": 40})
    content = calibrated(arcref, run)
    curve = SubdivisionCurve.from_calibration_json(run.with_suffix(".cal.json"))
    theta = line_phases_rad(100)
    reading_deg = np.degrees(signals.reading_rad(*signals.signals_v(theta)))
    # The counter shows the interpolated phase less the phase of its zero.
    assert curve.evaluate(np.mod(reading_deg - 40, 360)) == pytest.approx(signals.error_arcsec(theta), abs=2e-3)
    assert content["results"]["count_zero_phase_deg"] == 40


def test_samples_in_time_at_an_uneven_speed(arcref, tmp_path):
    signals = published_signals(4096)
    run = tmp_path / "run.csv"
    write_columns(run, TIME_NAMES, in_time(signals, UnevenSpeed(80, 0.05), noise_v=0.003, seed=4), {"cosine_sign": -1})
    content = calibrated(arcref, run)
    curve = SubdivisionCurve.from_calibration_json(run.with_suffix(".cal.json"))
    theta = line_phases_rad(200)
    reading_deg = np.degrees(signals.reading_rad(*signals.signals_v(theta)))
    difference = curve.evaluate(reading_deg) - signals.error_arcsec(theta)
    assert np.ptp(signals.error_arcsec(theta)) > 3.9
    assert np.ptp(difference - difference.mean()) < 0.08
    assert content["provenance"]["method"]["resampled"] is True


def test_numbered_samples_that_are_off_their_angles_are_resampled(arcref, tmp_path):
    signals = published_signals(4096)
    theta = UnevenSpeed(60, 0.02).theta_rad(np.arange(60 * 64) / (60 * 64))
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, (np.arange(60 * 64), *signals.signals_v(theta)), STATED)
    content = calibrated(arcref, run)
    assert content["provenance"]["method"]["resampled"] is True
    assert "off their angles" in content["printed"]
    assert content["results"]["error_peak_to_peak_arcsec"] == pytest.approx(4 * 0.990, abs=0.03)


def test_the_curve_goes_into_the_second_table(arcref, tmp_path, examples):
    run, rom = tmp_path / "run.csv", tmp_path / "x.rom.json"
    signals = published_signals(4096)
    write_columns(run, NAMES, at_equal_angles(signals, 20, noise_v=0.002), STATED)
    calibrated(arcref, run)
    cal = run.with_suffix(".cal.json")
    polygon = examples / "polygon_before_correction.csv"
    done = arcref("rom", polygon, "--subdivision", cal, "-o", rom)
    assert done.exit_code == 0, done.output
    image: CorrectionRom = load_rom(rom)
    cells = (np.arange(512) + 0.5) * 360 / 512
    expected = signals.error_at_reading_arcsec(np.radians(cells)) / (1296000 / 2**23)
    assert image.subdivision_table / 16 == pytest.approx(expected, abs=0.25)
    assert np.ptp(image.subdivision_table) > 16 * 20


def test_the_table_of_another_disc_is_not_taken(arcref, tmp_path, published, examples):
    calibrated(arcref, published)
    cal, rom = published.with_suffix(".cal.json"), tmp_path / "x.rom.json"
    done = arcref("rom", examples / "polygon_before_correction.csv", "--subdivision", cal, "-o", rom)
    assert done.exit_code == 2
    assert "results.line_count: is 16384, 4096 lines were expected" in done.output
    assert not rom.exists()


def test_compare_shows_every_method(arcref, tmp_path):
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(published_signals(4096), 4, noise_v=0.002), STATED)
    content = calibrated(arcref, run, "--compare")
    rivals = {each["method"]: each for each in content["results"]["identifications"]}
    assert set(rivals) == {"least-squares", "swarm", "swarm-printed", "heydemann"}
    left = {name: each["error_after_peak_to_peak_arcsec"] for name, each in rivals.items()}
    assert left["swarm"] == pytest.approx(left["least-squares"], abs=1e-6)
    assert left["heydemann"] == pytest.approx(4 * 0.645, abs=0.1)
    assert left["least-squares"] < 0.2
    for name in ("linear least squares", "rule as printed", "Heydemann ellipse"):
        assert name in re.sub(r"\s+", " ", content["printed"])


@pytest.mark.parametrize("method", ["swarm", "heydemann"])
def test_another_method_makes_the_curve(arcref, tmp_path, method):
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(published_signals(4096), 1), STATED)
    content = calibrated(arcref, run, "--method", method)
    left = content["results"]["left_peak_to_peak_arcsec"]
    assert left == pytest.approx({"swarm": 0.0, "heydemann": 4 * 0.641}[method], abs=0.01)


def test_more_harmonics_when_they_are_asked_for(arcref, tmp_path):
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(published_signals(4096), 2), STATED)
    content = calibrated(arcref, run, "--orders", "1,2,3,5,7")
    waves = content["results"]["sine"]["harmonics"]
    assert set(waves) == {"1", "2", "3", "5", "7"}
    assert waves["2"]["amplitude_v"] == pytest.approx(0, abs=1e-9)
    assert content["results"]["error_peak_to_peak_arcsec"] == pytest.approx(3.959, abs=5e-3)
    less = calibrated(arcref, run, "--orders", "1")
    # What the model has not, the budget says.
    assert less["results"]["expanded_uncertainty_arcsec"] > 0.8


def test_parameters_that_change_over_the_run_are_seen(arcref, tmp_path):
    signals = published_signals(4096)
    number, sine, cosine = at_equal_angles(signals, 100, noise_v=0.002, seed=1)
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, (number, sine, cosine), STATED)
    steady = calibrated(arcref, run)
    assert steady["results"]["change_probability"] > 1e-3
    assert "change from line to line more" not in steady["printed"]
    wave = 0.02 * np.sin(2 * np.pi * number / number.size)
    write_columns(run, NAMES, (number, sine + wave, cosine), STATED)
    changing = calibrated(arcref, run)
    assert changing["results"]["change_probability"] < 1e-9
    assert "change from line to line more" in changing["printed"]
    more = (
        changing["results"]["expanded_uncertainty_arcsec"] ** 2 - steady["results"]["expanded_uncertainty_arcsec"] ** 2
    )
    # An offset of amplitude a shifts the angle by a / A cos theta: half of the mean square over lines, half over phase.
    expected = 2 * 0.02 / signals.sine.canonical.fundamental.amplitude_v * signals.arcsec_per_rad / 2
    assert np.sqrt(more) == pytest.approx(expected, rel=0.1)


def test_the_uncertainty_of_the_curve_holds(tmp_path):
    """Of 60 noisy runs the scatter of the curve is what each of them states."""
    from arcref.subdivision.samples_result import samples_result
    from arcref.subdivision.subdivision_run import SubdivisionOptions, read_subdivision_run

    signals = published_signals(4096)
    curves, stated = [], []
    metadata = STATED | {"speed_change_percent": 0}
    for seed in range(60):
        run = tmp_path / "run.csv"
        write_columns(run, NAMES, at_equal_angles(signals, 4, noise_v=0.01, seed=seed), metadata)
        result = samples_result(read_subdivision_run(run)[1], SubdivisionOptions())
        curves.append(result.curve.error_arcsec)
        stated.append(result.curve.u_arcsec)
    scatter = np.sqrt(np.mean(np.var(curves, axis=0, ddof=1)))
    assert np.sqrt(np.mean(np.square(stated))) == pytest.approx(scatter, rel=0.2)


def test_the_report(arcref, tmp_path):
    run, page, record, table = (tmp_path / name for name in ("run.csv", "r.html", "r.json", "r.csv"))
    metadata = STATED | {"encoder_serial": "<b>7</b>", "bench": "left & right"}
    write_columns(run, NAMES, at_equal_angles(published_signals(4096), 80, noise_v=0.003), metadata)
    calibrated(arcref, run, "--compare", "--report", page, "--json", record, "--csv", table)
    text, content = page.read_text(encoding="utf-8"), json.loads(record.read_text(encoding="utf-8"))
    for heading in (
        "Error over the line",
        "Signals",
        "Error by cause",
        "Harmonics of the error",
        "Identifications side by side",
        "Does the swarm find the optimum?",
        "Over the turn",
        "Knowledge of the phase",
        "Uncertainty budget",
        "What was not checked",
    ):
        assert f">{heading}<" in text
    assert text.count("<svg") == 7  # line, signals, Lissajous, causes, harmonics, map, budget
    assert "<b>7</b>" not in text
    assert "&lt;b&gt;7" in text
    assert not re.search(r'(?:src|href)="(?!#|data:image)', text)
    ids = re.findall(r' id="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    for path, value in re.findall(r'<data value="([^"]+)" data-path="([^"]+)"', text):
        own = content
        for part in value.split("."):
            own = own[int(part)] if isinstance(own, list) else own[part]
        assert own == float(path)
    rows = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    assert len(rows) == 513
    assert rows[0].startswith("line_deg,count,error_arcsec,")


def test_the_same_run_gives_the_same_calibration(arcref, tmp_path):
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(published_signals(4096), 2, noise_v=0.002), STATED)
    first = calibrated(arcref, run, "--compare")
    again = calibrated(arcref, run, "--compare")
    first.pop("printed"), again.pop("printed")  # times stand there
    assert first == again


def test_a_cosine_ahead_of_the_sine(arcref, tmp_path):
    signals = SignalModel.ideal(1.0)
    signals = SignalModel(signals.sine, replace(signals.cosine, offset_v=0.01))
    run = tmp_path / "run.csv"
    write_columns(run, NAMES, at_equal_angles(signals, 2), STATED | {"cosine_sign": 1})
    calibrated(arcref, run)
    curve = SubdivisionCurve.from_calibration_json(run.with_suffix(".cal.json"))
    # With u_c = cos + 0.01 the reading lags by 0.01 sin theta.
    expected = -0.01 * signals.arcsec_per_rad * np.sin(np.radians(curve.line_deg))
    assert curve.error_arcsec == pytest.approx(expected, abs=0.02)
    assert wrapped_rad(3 * np.pi) == pytest.approx(-np.pi)
