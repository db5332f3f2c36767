"""Quadrature: every step as two neighbouring samples say it, and nothing else."""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, as_samples, assert_rows

from arcref_gateware.golden.steps import steps_of
from arcref_gateware.quadrature import QUADRATURE_CLOCKS, SAMPLES_PER_WORD, Quadrature

FORWARD = [(0, 0), (1, 0), (1, 1), (0, 1)]
"""(A, B) in forward order."""

STEP = {(before, after): FORWARD.index(after) - FORWARD.index(before) for before in FORWARD for after in FORWARD}
STEP = {pair: {3: -1, -3: 1}.get(step, step) for pair, step in STEP.items()}
"""What a pair of states does: -1, 0, +1, and 2 or -2 for an illegal step."""

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)


@cache
def bench(samples_per_word: int, gate_state=(1, 1)) -> Bench:
    quadrature = Quadrature(samples_per_word, gate_state)
    return Bench(quadrature, ["a", "b", "z", "rst"], ["forward", "reverse", "illegal", "gate", "valid"])


def decode(samples_per_word, states, z=None, gate_state=(1, 1), **controls):
    """Step, illegal and gate of every sample of `states`, pairs (A, B) one a sample."""
    states = np.asarray(states, dtype=int).reshape(-1, samples_per_word, 2)
    z = np.zeros(states.shape[:2]) if z is None else np.asarray(z).reshape(states.shape[:2])
    lines = {"a": as_bits(states[:, :, 0]), "b": as_bits(states[:, :, 1]), "z": as_bits(z)}
    rows = bench(samples_per_word, gate_state).run(len(states) + QUADRATURE_CLOCKS, **lines, **controls)
    samples = {
        name: as_samples(rows[name][QUADRATURE_CLOCKS:], samples_per_word).ravel()
        for name in ("forward", "reverse", "illegal", "gate")
    }
    assert not rows["valid"][:QUADRATURE_CLOCKS].any()
    return samples["forward"] - samples["reverse"], samples["illegal"], samples["gate"]


@each_word_size
def test_every_pair_of_states_at_every_sample_of_a_word(samples_per_word, rng):
    states = rng.integers(0, 2, (800 * samples_per_word, 2))
    step, illegal, _ = decode(samples_per_word, states)

    pairs = list(zip(map(tuple, states[:-1].tolist()), map(tuple, states[1:].tolist()), strict=True))
    covered = {(pair, place % samples_per_word) for place, pair in enumerate(pairs, start=1)}
    assert len(covered) == 16 * samples_per_word
    truth = np.array([0, *(STEP[pair] for pair in pairs)])
    assert_rows("step", step, np.where(np.abs(truth) == 2, 0, truth))
    assert_rows("illegal", illegal, np.abs(truth) == 2)


def test_the_golden_model_knows_the_same_steps():
    for (before, after), truth in STEP.items():
        step, illegal = steps_of(np.array([after[0] | after[1] << 1]), before[0] | before[1] << 1)
        assert (int(step[0]), bool(illegal[0])) == ((0, True) if abs(truth) == 2 else (truth, False))


@each_word_size
def test_forward_is_a_before_b(samples_per_word):
    turn = np.array(FORWARD * 4)
    assert decode(samples_per_word, turn)[0].tolist() == [0] + [1] * 15
    assert decode(samples_per_word, turn[::-1])[0].tolist() == [0] + [-1] * 15
    assert decode(samples_per_word, turn[:, ::-1])[0].tolist() == [0] + [-1] * 15, "A and B exchanged"


@each_word_size
@pytest.mark.parametrize("state", range(4))
def test_no_step_and_no_fault_from_the_first_sample_after_reset(samples_per_word, state):
    counts = state + np.repeat(np.arange(3), 4)
    step, illegal, _ = decode(samples_per_word, np.array(FORWARD)[counts & 3])
    assert not illegal.any()
    assert_rows("step", step, np.diff(counts, prepend=state))


@each_word_size
@pytest.mark.parametrize("state", range(4))
def test_no_step_after_a_reset_in_the_middle_of_motion(samples_per_word, state, rng):
    reset_words = 3
    before = rng.integers(0, 2, (10 * samples_per_word, 2))
    after = np.array(FORWARD)[(state + np.arange(8 * samples_per_word) // 2) & 3]
    reset = [0] * 10 + [1] * reset_words + [0]
    during = rng.integers(0, 2, (reset_words * samples_per_word, 2))
    step, illegal, _ = decode(samples_per_word, [*before, *during, *after], rst=reset)

    place = len(before) + len(during)
    first = (10 + reset_words) * samples_per_word - QUADRATURE_CLOCKS * samples_per_word
    assert not step[first:place].any(), "a step during reset"
    assert not illegal[first:].any()
    assert_rows("step", step[place:], np.diff(np.arange(8 * samples_per_word) // 2, prepend=0))


@each_word_size
@pytest.mark.parametrize("phase", range(4))
@pytest.mark.parametrize("direction", [1, -1])
def test_a_reversal_counts_back_at_once_at_each_phase(samples_per_word, phase, direction):
    there = phase + direction * np.arange(8)
    counts = np.concatenate((there, there[-2::-1], [phase]))
    step, illegal, _ = decode(samples_per_word, np.array(FORWARD)[counts & 3])
    assert not illegal.any()
    assert_rows("step", step, np.diff(counts, prepend=phase))


@each_word_size
@pytest.mark.parametrize("dwell", [1, 2, 3])
def test_a_line_that_chatters_moves_to_and_fro_and_gains_nothing(samples_per_word, dwell):
    counts = np.repeat(np.tile([5, 6], 12), dwell)
    counts = counts[: len(counts) // samples_per_word * samples_per_word]
    step, illegal, _ = decode(samples_per_word, np.array(FORWARD)[counts & 3])
    assert not illegal.any()
    assert_rows("position", 5 + np.cumsum(step), counts)


@each_word_size
@pytest.mark.parametrize("before", FORWARD)
@pytest.mark.parametrize("direction", [1, -1])
def test_a_double_transition_is_called_illegal_whatever_the_direction_before_it(samples_per_word, before, direction):
    """No direction is remembered: after a run either way both lines changing counts nothing."""
    run_up = FORWARD.index(before) - direction * np.arange(8)[::-1]
    counts = np.append(run_up, [run_up[-1] + 2] * 4)
    step, illegal, _ = decode(samples_per_word, np.array(FORWARD)[counts & 3])
    assert step.sum() == 7 * direction
    assert np.flatnonzero(illegal).tolist() == [8]


@each_word_size
@pytest.mark.parametrize("gate_state", FORWARD)
def test_the_gate_is_z_high_in_the_gate_state_and_in_no_other(samples_per_word, gate_state, rng):
    states = rng.integers(0, 2, (100 * samples_per_word, 2))
    z = rng.integers(0, 2, len(states))
    _, _, gate = decode(samples_per_word, states, z, gate_state)
    assert_rows("gate", gate, (states == gate_state).all(axis=1) & (z == 1))
