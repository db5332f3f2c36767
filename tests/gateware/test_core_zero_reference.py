"""The zero is one place: the same forward and reverse, at any width of Z and any sample of a word."""

from functools import cache

import numpy as np
import pytest
from core_bench import CoreBench
from encoder_lines import GATE_STATE_NUMBER, hold_to_word, lines_of_counts

from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref_gateware.quadrature import SAMPLES_PER_WORD

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)

ZERO = 40 + GATE_STATE_NUMBER
"""The count of the zero mark in these runs."""

COUNT_FAULTS = Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR | Flag.INDEX_FAULT

WINDOWS = [(first, first + width) for width in range(1, 5) for first in range(1 - width, 1)]
"""Z by its first and last+1 state beside the zero: every width of one to four states and every place of it."""


@cache
def bench(samples_per_word: int) -> CoreBench:
    return CoreBench(CorrectionRom(np.zeros(4096, np.int16)), samples_per_word)


def run(samples_per_word, counts, window, z_mask=True, **controls):
    """Rows of a core whose samples see `counts`; Z is high in the states of `window` around `ZERO`."""
    counts = hold_to_word(counts, samples_per_word)
    z = (counts >= ZERO + window[0]) & (counts < ZERO + window[1]) & z_mask
    rows = bench(samples_per_word).run(lines_of_counts(counts, z), **controls)
    return rows, counts[samples_per_word - 1 :: samples_per_word]


def assert_zeroed(rows, counts, home_word):
    """Before the home word positions count from the start; from then on they count from the zero mark."""
    start = counts[0] - rows["raw_position"][0] if home_word else None
    word = np.arange(len(counts))
    expected = np.where(word >= home_word, counts - ZERO, counts - (start or 0))
    assert rows["raw_position"].tolist() == expected.tolist()
    assert rows["position"].tolist() == expected.tolist()
    assert rows["homed"].tolist() == (word >= home_word).tolist()


@each_word_size
@pytest.mark.parametrize("window", WINDOWS)
@pytest.mark.parametrize("direction", [1, -1])
def test_the_zero_is_the_same_place_at_every_width_direction_and_sample(samples_per_word, window, direction):
    for place in range(samples_per_word):
        for samples_per_count in (1, 1.5, 3.25):
            way = np.arange(int(24 * samples_per_count)) / samples_per_count
            counts = ZERO + direction * (np.floor(way).astype(int) - 12)
            counts = np.concatenate((np.full(place, counts[0]), counts))
            rows, counts_of_words = run(samples_per_word, counts, window)
            assert_zeroed(rows, counts_of_words, int(np.argmax(counts == ZERO)) // samples_per_word)
            assert rows["index_count"][-1] == 1
            assert not np.any(rows["flags"] & COUNT_FAULTS)


@each_word_size
@pytest.mark.parametrize("window", WINDOWS)
def test_reversals_at_each_phase_inside_the_index_move_nothing(samples_per_word, window):
    legs = [-12, 0, -3, 1, -2, 2, -1, 0, -1, 3, 0, 3, -1, 2, 0, 1, 0, 4, -4, 9]
    for samples_per_count in (1, 2, 3):
        counts = [legs[0]]
        for turn in legs[1:]:
            counts += range(counts[-1], turn, 1 if turn > counts[-1] else -1)[1:]
            counts.append(turn)
        counts = ZERO + np.repeat(counts, samples_per_count)
        rows, counts_of_words = run(samples_per_word, counts, window)
        home_word = int(np.argmax(counts == ZERO)) // samples_per_word
        assert_zeroed(rows, counts_of_words, home_word)
        entries = np.flatnonzero(np.diff(counts == ZERO, prepend=0) == 1)
        assert rows["index_count"][-1] == len(set(entries // samples_per_word))
        assert not rows["closure_error"].any()
        assert not np.any(rows["flags"] & COUNT_FAULTS)


@each_word_size
def test_a_random_dither_around_the_index_keeps_every_closure_error_at_zero(samples_per_word, rng):
    for window in WINDOWS[::3]:
        counts = ZERO - 6 + np.abs(np.cumsum(rng.choice([-1, 0, 1], 600)) % 24 - 12)
        rows, counts_of_words = run(samples_per_word, counts, window)
        home_word = int(np.argmax(hold_to_word(counts, samples_per_word) == ZERO)) // samples_per_word
        assert rows["index_count"][-1] > 5
        assert rows["raw_position"][home_word:].tolist() == (counts_of_words[home_word:] - ZERO).tolist()
        assert not rows["closure_error"].any()
        assert not np.any(rows["flags"] & COUNT_FAULTS)


@each_word_size
def test_a_z_that_bounces_inside_the_gate_state_homes_on_the_same_count(samples_per_word, rng):
    for _ in range(6):
        counts = ZERO + np.repeat([-2, -1, 0, 1, 2, 1, 0, -1, -2], 7)
        z_mask = rng.random(len(hold_to_word(counts, samples_per_word))) < 0.5
        z_mask[14:21] |= np.arange(7) == rng.integers(7)
        rows, counts_of_words = run(samples_per_word, counts, (-1, 2), z_mask)
        home = np.flatnonzero((hold_to_word(counts, samples_per_word) == ZERO) & z_mask)[0] // samples_per_word
        assert_zeroed(rows, counts_of_words, home)
        assert not np.any(rows["flags"] & COUNT_FAULTS)


@each_word_size
@pytest.mark.parametrize("state", range(-2, 3))
def test_power_up_inside_a_wide_z_homes_only_on_the_gate_state(samples_per_word, state):
    way = {-2: [-2, -1, 0, 1], -1: [-1, 0, 1], 0: [0, 1], 1: [1, 0, -1], 2: [2, 1, 0]}[state]
    counts = ZERO + np.repeat(way, 9)
    rows, counts_of_words = run(samples_per_word, counts, (-2, 2) if state < 2 else (0, 3))
    home_word = int(np.argmax(counts == ZERO)) // samples_per_word
    assert_zeroed(rows, counts_of_words, home_word)
    assert not np.any(rows["flags"] & COUNT_FAULTS)


@each_word_size
def test_reset_in_the_middle_of_motion_leaves_a_core_as_from_power_up(samples_per_word, rng):
    """Whatever was in the pipeline, the words after a reset give what they give after power-up."""
    words = 60
    counts = ZERO - 10 + np.cumsum(rng.choice([-1, 0, 1, 1], words * samples_per_word))
    fresh, _ = run(samples_per_word, counts, (-1, 1))
    assert fresh["homed"][-1]
    before = ZERO + rng.integers(-3, 3, 40 * samples_per_word)  # illegal steps and indices in plenty
    again, _ = run(samples_per_word, [*before, *counts], (-1, 1), rst=[0] * 33 + [1] * 7 + [0])
    assert again["flags"][:40].any()
    for name, column in fresh.items():
        assert again[name][40:].tolist() == column.tolist(), name
