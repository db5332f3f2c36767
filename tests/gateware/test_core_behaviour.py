"""What the core promises a user, from lines whose truth is known: speed, slips and captures."""

from functools import cache

import numpy as np
import pytest
from core_bench import CoreBench
from encoder_lines import GATE_STATE_NUMBER, lines_of_counts

from arcref.correction_rom import CorrectionRom
from arcref.flags import FAULT_FLAGS, Flag
from arcref_gateware.latency import LATENCY_CLOCKS
from arcref_gateware.quadrature import SAMPLES_PER_WORD

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)
COUNT_FAULTS = Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR | Flag.INDEX_FAULT


@cache
def bench(samples_per_word: int) -> CoreBench:
    return CoreBench(CorrectionRom(np.zeros(4096, np.int16)), samples_per_word)


def faults(rows) -> Flag:
    """The faults that were up at any word, the edge-spacing limit left out."""
    return Flag(int(np.bitwise_or.reduce(rows["flags"]))) & FAULT_FLAGS & ~Flag.EDGE_SPACING_LIMIT


def test_the_latency_is_twenty_four_clocks_or_fewer():
    """That it is the true one, and the same always, every comparison of a core with its words says."""
    assert LATENCY_CLOCKS <= 24


@each_word_size
@pytest.mark.parametrize("state", range(4))
@pytest.mark.parametrize("z", [False, True])
def test_power_up_at_rest_in_any_state_shows_no_step_and_no_fault(samples_per_word, state, z):
    rows = bench(samples_per_word).run(lines_of_counts(np.full(40 * samples_per_word, state), z))
    homes = z and state == GATE_STATE_NUMBER
    assert not rows["raw_position"].any()
    assert faults(rows) == 0
    assert rows["homed"].all() if homes else not rows["homed"].any()
    assert rows["index_count"][-1] == homes


@each_word_size
@pytest.mark.parametrize("direction", [1, -1])
def test_a_speed_ramp_is_flagged_before_the_first_count_is_lost_and_the_loss_too(samples_per_word, direction):
    """From rest to 3.5 counts a sample."""
    speed = np.linspace(0.0, 3.5, 400 * samples_per_word)
    counts = direction * np.floor(np.cumsum(speed)).astype(int)
    rows = bench(samples_per_word).run(lines_of_counts(counts))
    truth = counts[samples_per_word - 1 :: samples_per_word] - counts[0]
    lost = int(np.argmax(rows["raw_position"] != truth))
    assert lost > 0
    limit = rows["flags"] & Flag.EDGE_SPACING_LIMIT != 0
    illegal = rows["flags"] & Flag.ILLEGAL_STEP != 0
    assert limit[lost - 1], "the limit is told before a count is lost"
    assert illegal[lost], "the loss is told in the word it happens in"
    assert limit[-1]
    assert illegal[-1]


def there_and_back(far: int) -> tuple[np.ndarray, np.ndarray]:
    """Counts that pass the zero mark, go `far` counts on and come back to it; and Z, one state wide."""
    zero = GATE_STATE_NUMBER
    counts = np.concatenate((np.arange(zero - 8, zero + far), np.arange(zero + far, zero - 20, -1)))
    return counts, counts == zero


@pytest.mark.parametrize("slip", [4, -4, 8, -400])
def test_a_slip_of_whole_periods_is_a_closure_error_and_nothing_else(slip):
    """The disc is where it was: only the pulses of A and B are too many or too few, so Z keeps its place."""
    counts, z = there_and_back(200)
    pulses = counts[250] + np.sign(slip) * np.arange(1, abs(slip) + 1)
    seen = np.concatenate((counts[:251], pulses, counts[251:] + slip))
    z = np.concatenate((z[:251], np.zeros(len(pulses), bool), z[251:]))
    assert np.all(np.abs(np.diff(seen)) == 1)
    rows = bench(1).run(lines_of_counts(seen, z))
    assert faults(rows) == Flag.CLOSURE_ERROR
    assert rows["closure_error"][-1] == rows["largest_closure_error"][-1] == slip
    assert rows["index_count"][-1] == 2
    assert rows["illegal_steps"][-1] == 0


@each_word_size
def test_a_double_transition_is_an_illegal_step_and_the_next_index_shows_what_it_cost(samples_per_word):
    counts, z = there_and_back(200)
    kept = np.arange(len(counts)) != 100
    seen, z = (column[kept][:424] for column in (counts, z))
    before_index = 380 // samples_per_word
    rows = bench(samples_per_word).run(lines_of_counts(seen, z))
    until = {name: column[:before_index] for name, column in rows.items()}
    assert faults(until) == Flag.ILLEGAL_STEP
    assert until["illegal_steps"][-1] == 1
    assert not until["closure_error"].any()
    assert rows["closure_error"][-1] == -2


def test_a_second_index_inside_the_line_is_a_closure_error_and_one_beyond_it_is_unexpected():
    zero = GATE_STATE_NUMBER
    counts = np.arange(zero - 8, zero + 2200)
    for second, fault in ((2048, Flag.CLOSURE_ERROR), (2052, Flag.INDEX_FAULT)):
        z = (counts == zero) | (counts == zero + second)
        rows = bench(4).run(lines_of_counts(counts, z))
        assert faults(rows) == fault
        assert rows["closure_error"][-1] == (second if fault == Flag.CLOSURE_ERROR else 0)


@pytest.mark.parametrize("direction", [1, -1])
def test_passing_the_zero_from_side_to_side_without_an_index_is_a_missing_index(direction):
    zero = GATE_STATE_NUMBER
    out, back = np.arange(-8, 2100), np.arange(2100, -2100, -1)
    counts = zero + direction * np.concatenate((out, back))
    z = (counts == zero) & (np.arange(len(counts)) < 100)
    rows = bench(4).run(lines_of_counts(counts, z))
    assert faults(rows) == Flag.INDEX_FAULT
    beyond = direction * (counts[3::4] - zero) < -2048
    assert np.argmax(rows["flags"] & Flag.INDEX_FAULT != 0) == np.argmax(beyond)
    assert not rows["closure_error"].any()
    assert rows["index_count"][-1] == 1


@each_word_size
@pytest.mark.parametrize("samples_per_count", [1.5, -9.5, 1e9])
def test_a_capture_is_the_true_position_at_the_due_sample(samples_per_word, samples_per_count, rng):
    """At every speed from rest to the interpolator's limit, both directions, any sample of a word and any delay."""
    samples = 260 * samples_per_word
    counts = np.floor(np.arange(samples) / samples_per_count).astype(int)
    for delay in (0, 1, 3, 7 * samples_per_word + 1, 83):
        rises = np.cumsum(rng.integers(2 * samples_per_word, 20 * samples_per_word, 100))
        rises = rises[rises < samples - delay]
        strobe = np.isin(np.arange(samples), rises)
        rows = bench(samples_per_word).run(lines_of_counts(counts, strobe=strobe), strobe_delay=delay)
        captured = rows["capture_valid"] == 1
        refused = rows["flags"][-1] & Flag.CAPTURE_OVERRUN != 0
        time = rows["capture_time"][captured]
        assert time.tolist() == (rises + delay).tolist() or refused
        assert set(time.tolist()) <= set((rises + delay).tolist())
        assert rows["capture_raw"][captured].tolist() == (counts[time] - counts[0]).tolist()


@each_word_size
def test_the_last_direction_is_that_of_the_last_step(samples_per_word, rng):
    counts = np.cumsum(rng.choice([-1, 0, 0, 0, 1], 300 * samples_per_word))
    rows = bench(samples_per_word).run(lines_of_counts(counts))
    step, last, expected = np.diff(counts, prepend=counts[0]), 0, []
    for word in step.reshape(-1, samples_per_word):
        moves = word[word != 0]
        last = int(moves[-1] < 0) if len(moves) else last
        expected.append(last)
    assert (rows["flags"] & Flag.LAST_DIRECTION_REVERSE).tolist() == expected
