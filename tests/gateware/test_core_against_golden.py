"""The whole core against its golden model, bit for bit at every word, through a hostile life."""

from functools import cache

import numpy as np
import pytest
from core_bench import CoreBench, as_output, assert_same_output
from encoder_lines import GATE_STATE_NUMBER, lines_of_counts, random_walk

import arcref_gateware.reference_encoder as reference_encoder
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref.rom_identity import identity_words
from arcref_gateware.golden.core import CoreModel
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_gateware.table_contents import rom_contents

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)


@cache
def rom() -> CorrectionRom:
    rng = np.random.default_rng(5)
    return CorrectionRom(rng.integers(-32768, 32768, 4096), rng.integers(-32768, 32768, 512))


@cache
def bench(samples_per_word: int) -> CoreBench:
    return CoreBench(rom(), samples_per_word)


def compare(samples_per_word, piece, delay=0, core=None, **parameters):
    """Run both; returns the rows of the core and the model."""
    rows = (core or bench(samples_per_word)).run(piece, strobe_delay=delay)
    model = CoreModel(rom(), samples_per_word, strobe_delay=delay, **parameters)
    assert_same_output(as_output(rows), model.run(piece))
    if rows["index_count"][-1] == rows["index_count"][-2]:  # the largest error shows a clock after the last one
        assert rows["largest_closure_error"][-1] == model.largest_closure_error
    return rows, model


@pytest.mark.parametrize(("samples_per_word", "delay"), [(4, 77), (2, 3), (1, 0)])
def test_a_hostile_life_with_the_correction_on(samples_per_word, delay, rng):
    """All of it at once: fast and slow, to and fro, illegal steps, indices right, wrong and missing, strobes."""
    samples = (FIRST_CORRECTED_WORD + 900) * samples_per_word
    counts = random_walk(rng, samples, illegal=0.003)
    period = 40 * samples_per_word
    from_mark = (counts - GATE_STATE_NUMBER + period // 2) % period - period // 2
    z = np.abs(from_mark) <= rng.integers(0, 3, samples // 500 + 1).repeat(500)[:samples]
    z &= rng.random(samples) < 0.98
    strobe = rng.random(samples) < 0.05
    rows, model = compare(samples_per_word, lines_of_counts(counts, z, strobe), delay)

    assert rows["shortest_edge_spacing"][-1] == model.shortest_edge_spacing
    seen = np.bitwise_or.reduce(rows["flags"])
    assert seen & Flag.ILLEGAL_STEP
    assert seen & Flag.CLOSURE_ERROR
    assert seen & Flag.CORRECTION_ACTIVE
    active = rows["flags"] & Flag.CORRECTION_ACTIVE != 0
    assert active.tolist() == (np.arange(len(active)) >= FIRST_CORRECTED_WORD).tolist()
    assert np.any(rows["raw_position"][active] != rows["position"][active])
    assert np.count_nonzero(rows["capture_valid"][active]) > 20


@each_word_size
def test_random_samples_are_no_encoder_and_agree_all_the_same(samples_per_word, rng):
    """Every sample of every line is a toss: the core and the model still say the same."""
    for density in (0.5, 0.05):
        toggles = rng.random((400 * samples_per_word, 4)) < density
        samples = (np.cumsum(toggles, axis=0) & 1) @ [1, 2, 4, 8]
        compare(samples_per_word, SignalChanges.from_samples(samples), delay=int(rng.integers(40)))


@pytest.mark.parametrize(("samples_per_word", "gate_state"), [(4, (0, 0)), (2, (1, 0)), (1, (0, 1))])
def test_the_other_gate_states(samples_per_word, gate_state, rng):
    core = CoreBench(rom(), samples_per_word, gate_state=gate_state)
    counts = random_walk(rng, 400 * samples_per_word)
    z = rng.random(len(counts)) < 0.3
    rows, _ = compare(samples_per_word, lines_of_counts(counts, z), core=core, gate_state=gate_state)
    assert rows["homed"][-1]


def test_the_first_illegal_step_keeps_its_place_and_time(rng):
    counts = np.cumsum(rng.choice([-1, 0, 1], 400))
    for sample in (121, 122, 123, 124):
        slipped = counts + 2 * (np.arange(400) >= sample) + 2 * (np.arange(400) >= 300)
        slipped[sample - 1], slipped[sample] = counts[sample - 2], counts[sample - 2] + 2
        rows = bench(4).run(lines_of_counts(slipped))
        word = sample // 4
        assert np.argmax(rows["illegal_steps"] > 0) == word
        assert rows["first_illegal_time"][-1] == 4 * word
        assert rows["first_illegal_position"][-1] == rows["raw_position"][word]


def test_a_rom_that_fails_its_check_raises_its_flag_and_corrects_nothing(monkeypatch, rng):
    of_another_rom = identity_words(CorrectionRom(np.zeros(4096, np.int16)))
    monkeypatch.setattr(
        reference_encoder, "rom_contents", lambda rom: rom_contents(rom)._replace(identity=of_another_rom)
    )
    core = CoreBench(rom(), 1)
    counts = random_walk(rng, FIRST_CORRECTED_WORD + 200)
    rows, _ = compare(1, lines_of_counts(counts, counts % 8 == 2), core=core, rom_good=False)
    assert rows["flags"][-1] & Flag.ROM_FAULT
    assert rows["homed"][-1]
    assert not np.any(rows["flags"] & Flag.CORRECTION_ACTIVE)
    assert rows["position"].tolist() == rows["raw_position"].tolist()
