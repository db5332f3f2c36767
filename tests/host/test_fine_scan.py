"""The error within a line from a scan of one face: recovery, uncertainty, and scans that cannot be used."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from made_counts import random_wave, scan, write

from arcref.command import main
from arcref.input_error import InputError
from arcref.run_file import read_run_file
from arcref.subdivision.fine_scan import fine_scan
from arcref.subdivision.fine_scan_run import FineScan, fine_scan_readings

COLUMNS = ("count", "autocollimator_x_arcsec")
READINGS = np.arange(2048) + 0.5
PHASES = READINGS * (2 * np.pi / 2048)


def read(folder, count, x, **metadata):
    run = read_run_file(write(folder / "run.csv", dict(zip(COLUMNS, (count, x), strict=True)), metadata), COLUMNS)
    return fine_scan_readings(run)


def deviation(found, wave):
    off = found.wave.error_arcsec(PHASES) - wave(READINGS)
    return off - off.mean()


@pytest.mark.parametrize("sign", [1, -1])
def test_without_noise_the_curve_is_found_but_for_the_counts_rounding(sign, tmp_path):
    rng = np.random.default_rng(1)
    wave = random_wave(rng)
    readings = scan(wave, rng, readings=3000, noise_arcsec=0.0, sign=sign, scale=1.003, bend_arcsec=0.4)
    found = fine_scan(read(tmp_path, *readings))
    assert found.scan.sign == sign
    assert np.abs(deviation(found, wave)).max() < 0.01
    # Rounding to a count is 0.1545 / sqrt(12) arcsec.
    assert found.noise_arcsec == pytest.approx(0.0446, rel=0.05)
    assert found.scale_error == pytest.approx(0.003, abs=1e-3)


@pytest.mark.parametrize(("lines", "noise_arcsec"), [(1.0, 0.05), (2.5, 0.1), (4.0, 0.2)])
def test_the_stated_uncertainty_covers_the_truth(lines, noise_arcsec, tmp_path):
    inside, scatter = [], []
    for seed in range(40):
        rng = np.random.default_rng([2, seed])
        wave = random_wave(rng)
        found = fine_scan(read(tmp_path, *scan(wave, rng, lines=lines, noise_arcsec=noise_arcsec)))
        inside.append(
            np.mean(np.abs(found.wave.error_arcsec(PHASES) - wave(READINGS)) <= 2 * found.wave.u_arcsec(PHASES))
        )
        scatter.append(found.noise_arcsec)
    assert 0.9 < np.mean(inside) < 0.985
    assert np.mean(scatter) == pytest.approx(np.hypot(noise_arcsec, 0.0446), rel=0.03)


def test_two_passages_have_a_drift_each(tmp_path):
    rng = np.random.default_rng(3)
    wave = random_wave(rng)
    (count, x), (again, x_again) = scan(wave, rng), scan(wave, rng)
    found = fine_scan(read(tmp_path, np.append(count, again), np.append(x, x_again + 7.0)))
    assert set(found.scan.passage) == {0, 1}
    assert np.abs(deviation(found, wave)).max() < 0.08


def test_the_command_writes_the_curve(tmp_path):
    rng = np.random.default_rng(4)
    wave = random_wave(rng)
    columns = dict(zip(COLUMNS, scan(wave, rng, noise_arcsec=0.05), strict=True))
    run = write(tmp_path / "run.csv", columns, {"u_autocollimator_arcsec": 0.03})
    words = ["calibrate", "subdivision", run, "-o", tmp_path / "cal.json", "--report", tmp_path / "r.html"]
    result = CliRunner().invoke(main, list(map(str, words)))
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "cal.json").read_text())
    curve = content["curve"]
    assert (content["kind"], len(curve["line_deg"])) == ("subdivision", 512)
    assert np.abs(np.array(curve["error_arcsec"]) - wave(np.array(curve["line_deg"]) * 2048 / 360)).max() < 0.06
    assert min(curve["u_arcsec"]) > 0.03
    assert "<svg" in (tmp_path / "r.html").read_text()


@pytest.fixture(scope="module")
def good():
    rng = np.random.default_rng(5)
    return scan(random_wave(rng), rng)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda c, x: (c[:20], x[:20]), "20 readings, at least 24"),
        (lambda c, x: (c[:90], x[:90]), "fewer than one grating line of 2048"),
        (lambda c, x: (c + 0.25, x), "no whole count"),
        (lambda c, x: (np.append(c, c[::-1]), np.append(x, x[::-1])), "the scan changes its direction here"),
        (lambda c, x: (np.delete(c, slice(20, 350)), np.delete(x, slice(20, 350))), "a gap: behind this reading"),
        (lambda c, x: (c, x / 60), "minutes of arc"),
        (lambda c, x: (c, 1.3 * x), "1 or -1 was expected"),
        (lambda c, x: (c, np.where(np.arange(c.size) == 7, 4000.0, x)), "row 9, column autocollimator_x_arcsec"),
    ],
)
def test_scans_that_cannot_be_used_get_one_line(change, expected, tmp_path, good):
    with pytest.raises(InputError) as caught:
        read(tmp_path, *change(*good))
    assert expected in str(caught.value)


def test_a_stated_sign_that_the_readings_deny_is_refused(tmp_path, good):
    assert read(tmp_path, *good, autocollimator_sign="+1").sign == 1
    with pytest.raises(InputError, match=r"metadata autocollimator_sign: -1, but x falls with the counts"):
        read(tmp_path, *good, autocollimator_sign="-1")


def test_orders_may_be_chosen():
    rng = np.random.default_rng(6)
    count, x = scan(random_wave(rng), rng)
    readings = FineScan(count.astype(float), x, np.zeros(count.size, int), 1, "")
    assert fine_scan(readings, orders=6).wave.orders == 6
