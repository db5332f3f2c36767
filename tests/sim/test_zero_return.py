"""The zero-return test as a function: what it finds, where it fails, and its page."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from compiled_cores import BUILDS

from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref.zero_return.page import zero_return_page
from arcref.zero_return.record import zero_return_record
from arcref_sim.core_log import Difference
from arcref_sim.zero_return import run_zero_return


@pytest.fixture(scope="session")
def short_result(rom, network):
    """Across the zero mark and back, no whole turn."""
    return run_zero_return(rom, network.evaluate, revolutions=0, folder=BUILDS)


@pytest.mark.parametrize(("samples_per_word", "speed_rps"), [(1, 10), (2, 10), (4, 10), (4, 63.48)])
def test_across_the_mark_and_back(samples_per_word, speed_rps, rom, network):
    told = []
    result = run_zero_return(
        rom,
        network.evaluate,
        speed_rps=speed_rps,
        revolutions=0,
        samples_per_word=samples_per_word,
        folder=BUILDS,
        progress=told.append,
    )
    assert result.passed, [check for check in result.checks if not check.passed]
    assert [(index.turn, index.direction, index.homes) for index in result.index_passes] == [
        (0, 1, True),
        (0, -1, False),
    ]
    assert result.shortest_edge_spacing_samples == int(result.samples_per_count)
    assert bool(result.flags & Flag.EDGE_SPACING_LIMIT) == (result.shortest_edge_spacing_samples == 1)
    assert told[-1] == 1


def test_the_waveforms_show_the_same_count_both_ways(short_result):
    forward, reverse = short_result.waveforms
    for wave in (forward, reverse):
        latched = np.searchsorted(wave.time, 0, side="right") - 1
        assert wave.time[latched] == 0
        assert wave.state[latched] & 7 == 7
    assert (forward.direction, reverse.direction) == (1, -1)


def test_another_curve_than_the_roms_fails(network):
    other = CorrectionRom.from_fit(lambda deg: network.evaluate(deg) + 0.5)
    result = run_zero_return(other, network.evaluate, revolutions=0, folder=BUILDS)
    assert [check.sentence for check in result.checks if not check.passed] == ["corrected within 0.6 counts of the fit"]


def test_every_kind_of_failure_is_named(short_result):
    first, last = short_result.index_passes
    broken = {
        "every zero mark was seen": {"index_passes": (first,)},
        "every closure error is 0": {"index_passes": (first, replace(last, closure_error_counts=4))},
        "zero drift is 0": {"index_passes": (first, replace(last, closure_error_counts=-1))},
        "no count was lost": {"lost_counts": 3},
        "no illegal step": {"illegal_steps": 1},
        "no fault flag but edge spacing": {"flags": int(Flag.ROM_FAULT)},
        "every SPI frame is right": {"spi_frames_wrong": 1},
        "core and golden model agree at every word": {"difference": Difference(7, "positions", "1", "2")},
        "corrected within 0.6 counts of the fit": {"correction_deviation_counts": math.nan},
    }
    for sentence, change in broken.items():
        failed = [check.sentence for check in replace(short_result, **change).checks if not check.passed]
        assert sentence in failed
    assert short_result.passed
    limit = replace(short_result, flags=int(Flag.EDGE_SPACING_LIMIT))
    assert limit.passed
    assert limit.faults == ["edge spacing at the limit"]


def test_the_page_holds_everything_and_escapes_what_it_is_given(short_result):
    hostile = short_result.provenance | {
        "rom": {"encoder_serial": "<script>alert(1)</script>", "inputs": "none", "method": ["x"], "date": 3}
    }
    page = zero_return_page(replace(short_result, provenance=hostile))
    assert "<script>" not in page
    assert page.count("<svg") == 3
    assert "PASS" in page
    assert "src=" not in page
    assert "FAIL" in zero_return_page(replace(short_result, lost_counts=1))
    empty = replace(short_result, index_passes=(), waveforms=())
    assert "no zero mark came back" in zero_return_page(empty)


def test_the_figures_are_plain_json(short_result):
    text = json.dumps(zero_return_record(short_result), allow_nan=False)
    assert json.loads(text)["closure"][1]["closure_error_counts"] == 0
