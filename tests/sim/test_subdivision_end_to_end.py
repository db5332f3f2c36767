"""An encoder of known optics, calibrated by simulated runs and corrected by the Verilated core, from file to angle."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from compiled_cores import BUILDS

from arcref.angle import ARCSEC_PER_COUNT
from arcref.command import main
from arcref.rom_image import load_rom
from arcref_sim.corrected_angle import CorePositions, corrected_angle, run_core
from arcref_sim.optics.optics_options import OPTION_NAMES, optical_encoder
from arcref_sim.simulate_corrected_command import corrected

SEED = 4


def arcref(*words):
    result = CliRunner().invoke(main, [str(word) for word in words])
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture(scope="module")
def encoder():
    """What the options make when none is given: 1 arcsec within the line, 5 over the turn."""
    given = corrected.make_context("corrected", ["--rom", "any.rom.json"]).params
    return optical_encoder(SEED, **{name: given[name] for name in OPTION_NAMES})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Runs of 24 faces, 4 rounds and 0.1 arcsec, of edge times at 1 r/s with 0.1 % of ripple, and of a scan; ROMs."""
    folder = tmp_path_factory.mktemp("end_to_end")
    for kind in ("polygon", "edges", "scan"):
        run, cal = folder / f"{kind}.csv", folder / f"{kind}.cal.json"
        arcref("simulate", "subdivision", "--run", kind, "--seed", SEED, "-o", run)
        arcref("calibrate", "polygon" if kind == "polygon" else "subdivision", run, "-o", cal)
    for name, table in (("line", None), ("both", "edges"), ("scanned", "scan")):
        more = ("--subdivision", folder / f"{table}.cal.json") if table else ()
        arcref("rom", folder / "polygon.cal.json", *more, "-o", folder / f"{name}.rom.json")
    return folder


@pytest.fixture(scope="module")
def positions(encoder, folder) -> CorePositions:
    """One turn in the Verilated core with both tables."""
    return run_core(encoder, load_rom(folder / "both.rom.json"), speed_rps=30.0, folder=BUILDS)


def with_rom(positions, rom) -> CorePositions:
    """The same turn with another ROM, by the golden model that the gateware equals bit for bit."""
    return CorePositions(positions.raw, rom.correct(positions.raw), positions.true)


def test_the_encoder_is_the_one_asked_for(encoder):
    assert np.ptp(encoder.within_line_arcsec(np.arange(512) * (360 / 512))) == pytest.approx(1.0, abs=0.05)
    assert np.ptp(encoder.turn_arcsec(np.arange(3600) / 10)) == pytest.approx(5.0, abs=0.4)


def test_edge_timing_recovers_the_line_within_a_twentieth_of_an_arcsec(encoder, folder):
    for kind, limit in (("edges", 0.05), ("scan", 0.1)):
        curve = json.loads((folder / f"{kind}.cal.json").read_text())["curve"]
        off = np.array(curve["error_arcsec"]) - encoder.within_line_arcsec(np.array(curve["line_deg"]))
        assert np.abs(off).max() < limit, kind


def test_both_tables_in_the_verilated_core_leave_less_than_a_count(positions, folder):
    assert np.array_equal(positions.corrected, load_rom(folder / "both.rom.json").correct(positions.raw))
    left = corrected_angle(positions)
    assert left.rms_arcsec < 0.15
    assert left.within_line_arcsec < 0.1  # mean over the turn's lines: rounding to a count is averaged away
    assert np.ptp(left.turn_arcsec) < 0.6
    assert left.raw_rms_arcsec > 1.0


def test_the_line_table_alone_leaves_the_error_within_the_line(positions, folder):
    left = corrected_angle(with_rom(positions, load_rom(folder / "line.rom.json")))
    assert left.within_line_arcsec == pytest.approx(1.0, abs=0.1)
    assert left.rms_arcsec > 0.25


def order_8_arcsec(rom) -> float:
    """Amplitude of order 8 of the turn in the first table."""
    return float(2 * np.abs(np.fft.rfft(rom.line_table)[8]) / 4096 / 16 * ARCSEC_PER_COUNT)


def test_without_the_second_table_a_false_order_8_goes_into_the_rom(encoder, folder):
    true = 2 * np.abs(np.fft.rfft(encoder.turn_arcsec(np.arange(4096) * (360 / 4096)))[8]) / 4096
    assert true < 0.001
    assert order_8_arcsec(load_rom(folder / "line.rom.json")) > 0.12
    # 24 faces, 4 readings of 0.1 arcsec each: noise alone puts 0.014 arcsec there.
    assert order_8_arcsec(load_rom(folder / "both.rom.json")) < 0.04
    assert order_8_arcsec(load_rom(folder / "scanned.rom.json")) < 0.06


def test_a_fine_scan_serves_as_well(positions, folder):
    left = corrected_angle(with_rom(positions, load_rom(folder / "scanned.rom.json")))
    assert left.rms_arcsec < 0.15
    assert left.within_line_arcsec < 0.15


def test_samples_of_the_signals_serve_as_well(positions, encoder, folder):
    arcref("simulate", "subdivision", "--run", "samples", "--seed", SEED, "-o", folder / "samples.csv")
    arcref("calibrate", "subdivision", folder / "samples.csv", "-o", folder / "samples.cal.json")
    sub = folder / "samples.cal.json"
    arcref("rom", folder / "polygon.cal.json", "--subdivision", sub, "-o", folder / "sampled.rom.json")
    left = corrected_angle(with_rom(positions, load_rom(folder / "sampled.rom.json")))
    assert left.within_line_arcsec < 0.1


def test_the_command_shows_it(folder):
    words = ("--rom", folder / "both.rom.json", "--seed", SEED, "--speed", 30, "--build-folder", BUILDS)
    shown = arcref("simulate", "corrected", *words, "--plot", folder / "plot.svg", "--json", folder / "left.json")
    left = json.loads((folder / "left.json").read_text())["both"]
    assert f"{left['rms_arcsec']:.3f}" in shown
    assert left["within_line_arcsec"] < 0.1
    assert "phase of the reading within a grating line" in (folder / "plot.svg").read_text()


def test_the_zero_return_test_takes_a_rom_of_two_tables_with_both_calibrations(folder):
    rom, curve = folder / "both.rom.json", folder / "polygon.cal.json"
    words = ("--rom", rom, "--curve", curve, "--revolutions", 0, "--build-folder", BUILDS)
    assert "PASS" in arcref("simulate", "zero-return", *words, "--subdivision", folder / "edges.cal.json")
    refused = CliRunner().invoke(main, [str(word) for word in ("simulate", "zero-return", *words)])
    assert refused.exit_code == 2
    assert "has a second table: --subdivision CAL.json was expected" in refused.output
