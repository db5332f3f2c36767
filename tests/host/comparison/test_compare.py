"""The dynamic comparison against an encoder under test whose error and delay are known."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

from arcref.angle import COUNTS_PER_TURN
from arcref.command import main
from arcref.comparison.dynamic_error import dynamic_error
from arcref.comparison.paired_readings import join_pairs, read_pairs
from arcref.flags import Flag
from arcref.input_error import InputError
from arcref.instrument.capture_file import open_capture_file
from arcref.instrument.captures import CAPTURE_DTYPE
from arcref.instrument.recorded_captures import read_capture_file

RATE_HZ = 800e6


def true_error_arcsec(angle_deg):
    return 4.0 * np.sin(np.radians(angle_deg + 30)) + 1.5 * np.cos(2 * np.radians(angle_deg))


def make_captures(speed_rps, number, first_deg=0.0, seed=0):
    """Captures at a constant speed, strobed at uneven times."""
    rng = np.random.default_rng(seed)
    time_s = np.cumsum(rng.uniform(0.5e-3, 1.5e-3, number)) / max(abs(speed_rps), 0.1)
    position = np.rint((first_deg / 360 + speed_rps * time_s) * COUNTS_PER_TURN).astype(np.int64)
    captures = np.zeros(number, CAPTURE_DTYPE)
    captures["time_s"], captures["time_samples"] = time_s, np.rint(time_s * RATE_HZ)
    captures["position_counts"] = captures["raw_position_counts"] = position
    captures["flags"] = int(Flag.CORRECTION_ACTIVE)
    captures["angle_deg"] = position % COUNTS_PER_TURN * 360 / COUNTS_PER_TURN
    return captures


def write_run(folder, name, captures, speed_rps, *, delay_s=3e-6, noise_arcsec=0.3, zero_deg=77.0, seed=1):
    rng = np.random.default_rng(seed)
    late_deg = captures["angle_deg"] - 360 * speed_rps * delay_s
    reading = late_deg + (true_error_arcsec(late_deg) + rng.normal(0, noise_arcsec, len(captures))) / 3600 + zero_deg
    capture_path = folder / f"{name}.csv"
    file = open_capture_file(
        capture_path, {"calibration_expanded_uncertainty": "0.4 arcsec (k=2)", "sample_rate_hz": "8e8"}
    )
    file.append(captures)
    file.close()
    rows = np.mod(reading, 360.0)
    lines = ["reading_deg", *(f"{row:.8f}" for row in rows)]
    readings_path = folder / f"{name}_dut.csv"
    readings_path.write_text("\n".join(lines) + "\n")
    return capture_path, readings_path


@pytest.fixture
def runs(tmp_path):
    return [
        write_run(tmp_path, f"run{n}", make_captures(speed, 3000, seed=n), speed, seed=n)
        for n, speed in enumerate((1.0, 10.0, 60.0, -10.0))
    ]


def test_delay_and_error_of_angle_are_told_apart_within_their_uncertainty(runs):
    result = dynamic_error(join_pairs([read_pairs(*run) for run in runs]))
    assert abs(result.delay_s - 3e-6) < 3 * result.u_delay_s
    assert result.u_delay_s < 1e-9
    angle = np.linspace(0, 360, 100)
    difference = result.angle_error_arcsec(angle) - true_error_arcsec(angle)
    assert np.all(np.abs(difference) < 0.15)
    assert result.noise_arcsec == pytest.approx(0.3, rel=0.05)
    assert [round(group.speed_rps) for group in result.groups] == [-10, 1, 10, 60]


def test_the_stated_uncertainty_of_the_delay_is_the_scatter_over_many_runs(tmp_path):
    found, stated = [], []
    for seed in range(40):
        pair = [
            read_pairs(*write_run(tmp_path, f"s{seed}_{n}", make_captures(v, 1200, seed=seed), v, seed=100 * n + seed))
            for n, v in enumerate((2.0, 20.0))
        ]
        result = dynamic_error(join_pairs(pair), 4)
        found.append(result.delay_s)
        stated.append(result.u_delay_s)
    assert np.std(found) == pytest.approx(np.mean(stated), rel=0.35)
    assert abs(np.mean(found) - 3e-6) < 4 * np.mean(stated) / np.sqrt(40)


def test_an_error_that_depends_on_speed_shows_at_its_speed(tmp_path):
    runs = []
    for n, speed in enumerate((2.0, 20.0, 50.0)):
        captures = make_captures(speed, 3000, seed=n)
        capture, readings = write_run(tmp_path, f"v{n}", captures, speed, seed=n)
        if speed == 50.0:
            wave = 2.0 * np.sin(np.radians(5 * captures["angle_deg"])) / 3600
            readings = rewritten(readings, lambda values, wave=wave: values + wave)
        runs.append(read_pairs(capture, readings))
    result = dynamic_error(join_pairs(runs))
    fast, others = result.groups[-1], result.groups[:-1]
    assert fast.apart_arcsec == pytest.approx(2 / 3 * 2.0 / np.sqrt(2), rel=0.1)
    assert all(group.apart_arcsec < 0.6 for group in others)
    angle = np.arange(360.0)
    own = result.angle_error_at_speed_arcsec(fast, angle)
    assert np.all(np.abs(own - true_error_arcsec(angle) - 2.0 * np.sin(np.radians(5 * angle))) < 0.15)


def test_one_speed_alone_tells_no_delay(runs):
    result = dynamic_error(join_pairs([read_pairs(*runs[1])]))
    assert result.delay_s is None


def test_lost_captures_keep_the_rows_beside_their_strobes(tmp_path):
    captures = make_captures(10.0, 2000)
    capture_path, readings_path = write_run(tmp_path, "all", captures, 10.0, noise_arcsec=0.0)
    kept = np.delete(captures, slice(500, 520))
    kept["lost_before"][500] = 20
    other = tmp_path / "lost.csv"
    file = open_capture_file(other, {})
    file.append(kept)
    file.close()
    pairs = read_pairs(other, readings_path)
    assert len(pairs) == 1980
    assert dynamic_error(join_pairs([pairs])).noise_arcsec < 0.1


@pytest.mark.parametrize("suffix", [".csv", ".h5"])
def test_captures_come_back_from_their_file_as_they_were(tmp_path, suffix):
    captures = make_captures(-3.0, 500)
    path = tmp_path / f"x{suffix}"
    file = open_capture_file(path, {"rom_crc32": "0x12345678", "operator": "Ada"})
    file.append(captures[:200])
    file.append(captures[200:])
    file.close()
    read = read_capture_file(path)
    back, provenance = read.captures, read.provenance
    assert np.array_equal(back["position_counts"], captures["position_counts"])
    assert np.allclose(back["time_s"], captures["time_s"], atol=1e-9, rtol=0)
    assert provenance["rom_crc32"] == "0x12345678"
    assert sorted(p.name for p in tmp_path.iterdir()) == [path.name]
    with pytest.raises(InputError, match="exists already"):
        open_capture_file(path, {})


def run_command(*arguments):
    return CliRunner().invoke(main, ["compare", *map(str, arguments)])


def test_the_command_writes_figures_plot_and_table(runs, tmp_path):
    files = [path for run in runs for path in run]
    outputs = [tmp_path / name for name in ("f.json", "p.svg", "t.csv")]
    result = run_command(*files, "--json", outputs[0], "--plot", outputs[1], "--csv", outputs[2])
    assert result.exit_code == 0, result.output
    figures = json.loads(outputs[0].read_text())
    assert figures["delay_us"] == pytest.approx(3.0, abs=0.01)
    assert figures["reference_expanded_uncertainty_arcsec"] == 0.4
    assert f"{figures['delay_us']:.4f} us" in result.output
    assert outputs[1].read_text().startswith("<?xml")
    assert len(outputs[2].read_text().splitlines()) == 361


BAD = {
    "one file": (lambda c, d: [c], "1 files were named"),
    "no such readings": (lambda c, d: [c, d.with_name("none.csv")], "none.csv: there is no such file"),
    "readings fall": (lambda c, d: [c, rewritten(d, lambda r: 360 - r)], "turn the sign of reading_deg"),
    "other strobes": (lambda c, d: [c, rewritten(d, lambda r: np.roll(r, 300))], "are these the strobes of"),
    "too few readings": (lambda c, d: [c, rewritten(d, lambda r: r[:10])], "10 strobes in common"),
    "swapped files": (lambda c, d: [d, c], "row 1: the columns are 'reading_deg', expected were 'time_s"),
    "another column": (
        lambda c, d: [c, retitled(d)],
        "row 1: the columns are 'reading_rad', expected were 'reading_deg'",
    ),
    "too many orders": (lambda c, d: [c, d, "--orders", "180"], "700 strobes carry a series up to order 174, not 180"),
    "an output twice": (lambda c, d: [c, d, "--json", c], "this name is given to two files"),
    "a plot of no kind": (lambda c, d: [c, d, "--plot", "x.doc"], "must end in .svg, .png, .pdf"),
}


def rewritten(path, change):
    values = np.array([float(line) for line in path.read_text().splitlines()[1:]])
    new = path.with_name("changed.csv")
    new.write_text("reading_deg\n" + "".join(f"{v:.8f}\n" for v in np.mod(change(values), 360)))
    return new


def retitled(path):
    new = path.with_name("changed.csv")
    new.write_text(path.read_text().replace("reading_deg", "reading_rad"))
    return new


@pytest.mark.parametrize("what", BAD)
def test_bad_input_gets_one_line_and_status_2(what, tmp_path):
    capture, readings = write_run(tmp_path, "run", make_captures(10.0, 700), 10.0)
    arguments, line = BAD[what]
    result = run_command(*arguments(capture, readings))
    assert result.exit_code == 2, result.output
    assert line in result.output
    assert result.output.count("\n") == 1
