"""An interpolator's delay, and the strobe delay that takes it away, on the true gateware."""

from pathlib import Path

import numpy as np
import pytest
from twin_truth import assert_captures, wait_until_homed

from arcref import Encoder
from arcref.angle import ARCSEC_PER_COUNT
from arcref_sim.square_waves import SquareWaves
from arcref_sim.twin.strobe_delay_plot import PLOT, delay_plot
from arcref_sim.twin.strobe_delay_study import DELAY_NS, SPEEDS_RPS, delay_study, formula_arcsec

PROJECT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def studies(rom):
    return delay_study(rom, PROJECT / "build" / "verilated")


def test_with_the_delay_set_every_capture_is_within_a_count_of_the_truth(studies):
    matched = [study for study in studies if study.strobe_delay_samples]
    assert sorted(study.speed_rps for study in matched) == sorted(SPEEDS_RPS)
    for study in matched:
        assert study.strobe_delay_samples == 4000
        assert np.abs(study.error_counts).max() <= 0.5 + 1e-6
        assert len(study.error_counts) >= 50


def test_without_it_the_error_is_delay_times_speed(studies):
    without = [study for study in studies if not study.strobe_delay_samples]
    assert {abs(study.speed_rps) for study in without} == {1.0, 10.0, 60.0}
    for study in without:
        expected = formula_arcsec(study.speed_rps)
        assert np.abs(study.error_counts * ARCSEC_PER_COUNT - expected).max() <= 0.51 * ARCSEC_PER_COUNT
        if abs(study.speed_rps) == 10:
            assert abs(study.mean_arcsec) == pytest.approx(64.8, abs=0.02)


def test_the_plot_in_the_manual_is_that_of_today(studies):
    assert (PROJECT / PLOT).read_bytes() == delay_plot(studies), f"run python -m {delay_plot.__module__} ROM"


def test_a_host_sets_the_delay_and_captures_corrected_angles_of_the_strobes_instant(make_twin):
    with make_twin(speed_rps=10.0, waves=SquareWaves(delay_ns=DELAY_NS)) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        encoder.registers.strobe_delay = 4000
        twin.set_strobe(80_000)
        captures = encoder.capture(500)
        assert_captures(twin, captures)
        strobe = captures["time_samples"] - 4000
        assert np.isin(strobe, twin.call(lambda: list(twin.strobe_samples))).all()
        # Half a count of the square waves, half of the correction's rounding, and the table's steps from line to line.
        error = captures["position_counts"] + 0.5 - twin.encoder.true_counts_at(strobe)
        assert np.abs(error).max() < 1.3
        assert np.abs(error.mean()) < 0.3
