"""The golden model itself: cut anywhere it says the same, and a plain loop agrees with it."""

import numpy as np
import pytest
from core_bench import assert_same_output
from encoder_lines import lines_of_counts, random_walk

from arcref.flags import Flag
from arcref_gateware.golden.core import CoreModel, CoreOutput
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_gateware.quadrature import SAMPLES_PER_WORD

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)


def hostile_samples(rng, samples, illegal=0.003):
    counts = random_walk(rng, samples, illegal)
    z = (np.abs((counts + 50) % 400 - 50) <= 1) & (rng.random(samples) < 0.98)
    return counts, lines_of_counts(counts, z, rng.random(samples) < 0.05)


def pieces_of(piece, cuts):
    """`piece` in parts that end at `cuts` and at its end."""
    samples = piece.to_samples()
    for start, end in zip([0, *cuts], [*cuts, len(samples)], strict=True):
        yield SignalChanges.from_samples(samples[start:end], piece.start + start)


def joined(outputs) -> CoreOutput:
    return CoreOutput(*(np.concatenate([getattr(one, part) for one in outputs]) for part in CoreOutput.__annotations__))


@each_word_size
@pytest.mark.parametrize("delay", [0, 61])
def test_a_run_cut_into_pieces_says_what_the_whole_run_says(samples_per_word, delay, random_rom, rng):
    words = FIRST_CORRECTED_WORD + 1000
    _, whole = hostile_samples(rng, words * samples_per_word)
    cuts = np.unique(rng.integers(1, words, 25)) * samples_per_word
    first = FIRST_CORRECTED_WORD * samples_per_word
    cuts = sorted({*cuts.tolist(), first, first + samples_per_word, samples_per_word})
    in_one, in_pieces = (CoreModel(random_rom, samples_per_word, strobe_delay=delay) for _ in range(2))
    expected = in_one.run(whole)
    assert_same_output(joined([in_pieces.run(piece) for piece in pieces_of(whole, cuts)]), expected)
    assert in_pieces.shortest_edge_spacing == in_one.shortest_edge_spacing
    assert in_pieces.largest_closure_error == in_one.largest_closure_error


@each_word_size
def test_positions_and_captures_are_those_of_a_plain_loop(samples_per_word, random_rom, rng):
    """Without an index: the position is the sum of the steps, however the changes were packed."""
    samples = 600 * samples_per_word
    counts = np.cumsum(rng.choice([-1, 0, 1], samples))
    strobe = rng.random(samples) < 0.02
    out = CoreModel(random_rom, samples_per_word, strobe_delay=7).run(lines_of_counts(counts, strobe=strobe))
    shown = np.zeros(600, int)
    for word, raw, corrected in out.positions.tolist():
        assert raw == corrected, "not homed, not corrected"
        shown[word:] = raw
    assert shown.tolist() == (counts[samples_per_word - 1 :: samples_per_word] - counts[0]).tolist()
    time = out.captures["capture_time"]
    assert len(time) > 5
    assert out.captures["capture_raw"].tolist() == (counts[time] - counts[0]).tolist()
    assert out.captures["word"].tolist() == (time // samples_per_word).tolist()


@each_word_size
def test_a_clear_takes_the_named_faults_only(samples_per_word, random_rom, rng):
    model = CoreModel(random_rom, samples_per_word)
    words = 400
    _, whole = hostile_samples(rng, 2 * words * samples_per_word, illegal=0.2)
    first, second = pieces_of(whole, [words * samples_per_word])
    before = int(model.run(first).status[-1]["flags"])
    assert before & Flag.ILLEGAL_STEP
    assert before & Flag.EDGE_SPACING_LIMIT
    model.clear_flags(Flag.ILLEGAL_STEP | Flag.CORRECTION_ACTIVE | Flag.LAST_DIRECTION_REVERSE)
    rest = SignalChanges.from_samples(np.repeat(first.state[-1:], words * samples_per_word), first.end)
    after = model.run(rest).status
    assert after[0]["word"] == words
    assert after[-1]["flags"] == before & ~int(Flag.ILLEGAL_STEP)


def test_changes_and_samples_are_the_same_thing(rng):
    samples = (np.cumsum(rng.random((500, 4)) < 0.1, axis=0) & 1) @ [1, 2, 4, 8]
    piece = SignalChanges.from_samples(samples, 40)
    assert piece.start == 40
    assert piece.end == 540
    assert piece.to_samples().tolist() == samples.tolist()
    assert piece.to_words(4).ravel().tolist() == samples.tolist()
    assert np.all(np.diff(piece.state.astype(int)) != 0)


def test_a_piece_that_is_no_piece_is_refused(random_rom):
    with pytest.raises(ValueError, match="increase"):
        SignalChanges(np.array([0, 3, 3]), np.zeros(3, np.uint8), 5)
    with pytest.raises(ValueError, match="before the end"):
        SignalChanges(np.array([0, 5]), np.zeros(2, np.uint8), 5)
    with pytest.raises(ValueError, match="before the end"):
        SignalChanges(np.array([], int), np.array([], np.uint8), 5)
    part_of_a_word = SignalChanges(np.array([0]), np.zeros(1, np.uint8), 6)
    with pytest.raises(ValueError, match="whole"):
        part_of_a_word.to_words(4)
    with pytest.raises(ValueError, match="whole"):
        CoreModel(random_rom, 4).run(part_of_a_word)
