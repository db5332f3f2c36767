"""Strobe: every rising edge falls due exactly its delay later, or is refused and told."""

from functools import cache

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

from arcref_gateware.golden.strobes import StrobeModel
from arcref_gateware.pending_strobes import PENDING_STROBES
from arcref_gateware.quadrature import SAMPLES_PER_WORD
from arcref_gateware.strobe_delay import STROBE_CLOCKS, STROBE_REFUSED_CLOCKS, StrobeDelay

each_word_size = pytest.mark.parametrize("samples_per_word", SAMPLES_PER_WORD)


@cache
def bench(samples_per_word: int) -> Bench:
    return Bench(StrobeDelay(samples_per_word), ["strobe", "delay", "rst"], ["due_sample", "due", "refused"])


def run(samples_per_word, strobe, delay, **controls):
    """Due sample (one-hot) and refusal of each word, for a list of samples, until the last strobe is due."""
    strobe = np.asarray(strobe, bool).reshape(-1, samples_per_word)
    words = len(strobe) + delay // samples_per_word + 2
    late = max(STROBE_CLOCKS, STROBE_REFUSED_CLOCKS)
    strobe = np.append(as_bits(strobe), 0)
    rows = bench(samples_per_word).run(words + late, strobe=strobe, delay=delay, **controls)
    due_sample = rows["due_sample"][STROBE_CLOCKS:][:words]
    assert_rows("due", rows["due"][STROBE_CLOCKS:][:words], due_sample != 0)
    return due_sample, rows["refused"][STROBE_REFUSED_CLOCKS:][:words]


def samples_of(due_sample) -> list[int]:
    """The due samples, counted from the first one."""
    samples = []
    for word, bits in enumerate(due_sample):
        samples += [(word, place) for place in range(4) if bits >> place & 1]
    return samples


def rises_of(strobe) -> np.ndarray:
    """Samples of rising edges; the line counts as high before the first one."""
    return np.flatnonzero(np.diff(np.asarray(strobe, int), prepend=1) == 1)


def assert_as_model(samples_per_word, strobe, delay):
    due_sample, refused = run(samples_per_word, strobe, delay)
    due, refused_words = StrobeModel(samples_per_word, delay).run(rises_of(strobe).tolist())
    expected_due, expected_refused = np.zeros_like(due_sample), np.zeros_like(refused)
    for sample in due:
        expected_due[sample // samples_per_word] |= 1 << sample % samples_per_word
    expected_refused[refused_words] = 1
    assert_rows(f"due sample at delay {delay}", due_sample, expected_due)
    assert_rows(f"refused at delay {delay}", refused, expected_refused)
    return len(due), len(refused_words)


def pulses(samples, rises) -> np.ndarray:
    """Samples of a strobe that is high for one sample at each of `rises`."""
    strobe = np.zeros(samples, bool)
    strobe[list(rises)] = True
    return strobe


@each_word_size
def test_a_strobe_is_due_its_delay_later_at_every_delay_and_sample(samples_per_word):
    """By arithmetic alone, at every delay around the change from the chain to the slots."""
    for delay in range(41):
        rises = [0, *(9 * samples_per_word * k + k % samples_per_word for k in range(1, 6))]
        strobe = pulses(60 * samples_per_word, rises[1:])
        due_sample, refused = run(samples_per_word, strobe, delay)
        expected = [divmod(rise + delay, samples_per_word) for rise in rises[1:]]
        assert samples_of(due_sample) == expected, f"delay {delay}"
        assert not refused.any()


@each_word_size
@pytest.mark.parametrize("density", [0.05, 0.5])
def test_random_strobes_agree_with_the_golden_model_at_every_delay(samples_per_word, density, rng):
    total = 0
    for delay in [*range(0, 41, 3), 64, 65, 66, 67, 100, 127, 200]:
        strobe = rng.random(80 * samples_per_word) < density
        captured, refused = assert_as_model(samples_per_word, strobe, delay)
        total += captured
    assert total > 30


@each_word_size
@pytest.mark.parametrize("delay", [200, 203, 1021])
def test_sixteen_strobes_wait_and_the_seventeenth_is_refused_until_one_has_left(samples_per_word, delay):
    spacing = 2 * samples_per_word + 1
    first = 10
    rises = [first + spacing * k for k in range(17)]
    # The word in which the first strobe is due still counts it as waiting; the next word has room again.
    word_after = (first + delay) // samples_per_word + 1
    room = word_after * samples_per_word - delay % samples_per_word
    strobe = pulses(-(-(room + 8) // samples_per_word) * samples_per_word, [*rises, room, room + samples_per_word + 1])
    due_sample, refused = run(samples_per_word, strobe, delay)

    accepted = [*rises[:PENDING_STROBES], room]
    got = samples_of(due_sample)
    assert got[: len(accepted)] == [divmod(rise + delay, samples_per_word) for rise in accepted]
    refused_words = np.flatnonzero(refused).tolist()
    assert refused_words[0] == (rises[-1] + delay % samples_per_word) // samples_per_word
    assert len(got) + len(refused_words) == 19


@each_word_size
def test_a_strobe_refused_for_want_of_a_slot_spoils_none_that_waits(samples_per_word, rng):
    """Bursts at one strobe a word, or every other one at one sample a word, into a ring that is full."""
    every = 2 if samples_per_word == 1 else samples_per_word
    strobe = np.zeros(240 * samples_per_word, bool)
    for start in (16, 100 * samples_per_word):
        strobe[start : start + 70 * every : every] = True
    for delay in (37 * samples_per_word, 60 * samples_per_word + 1):
        captured, refused = assert_as_model(samples_per_word, strobe, delay)
        assert captured >= 2 * PENDING_STROBES
        assert refused >= PENDING_STROBES


@each_word_size
def test_a_strobe_at_any_word_after_power_up_waits_its_whole_delay(samples_per_word):
    """Also at the word whose number matches what the empty slots hold."""
    for coarse in (5, 6, 9, 16):
        delay = coarse * samples_per_word
        for word in range(1, coarse + 6):
            strobe = pulses(24 * samples_per_word, [word * samples_per_word])
            due_sample, _ = run(samples_per_word, strobe, delay)
            assert samples_of(due_sample) == [(word + coarse, 0)], f"strobe in word {word}, delay of {coarse} words"


def test_a_strobe_one_lap_of_the_word_counter_later_waits_its_whole_delay():
    """Each slot still holds the word of the strobe that left it; sixteen slots try sixteen distances from it."""
    delay, lap = 4 * 60, 65536 // 4
    first = 8 + 7 * np.arange(16)
    second = first + lap + 60 - 9 + np.arange(16)
    strobe = pulses(4 * (lap + 400), 4 * np.concatenate((first, second)))
    due_sample, refused = run(4, strobe, delay)
    assert not refused.any()
    assert samples_of(due_sample) == [(int(word) + 60, 0) for word in (*first, *second)]


@pytest.mark.parametrize("delay", [65532, 65533, 65534, 65535])
def test_the_longest_delays(delay, rng):
    """At four samples a word, where they are 16384 words; shorter words only make them longer."""
    strobe = np.zeros(400, bool)
    strobe[rng.choice(np.arange(8, 400), 14, replace=False) // 3 * 3] = True
    captured, _ = assert_as_model(4, strobe, delay)
    assert captured >= 10


@each_word_size
@pytest.mark.parametrize("delay", range(9))
def test_two_strobes_due_in_one_word_give_the_first_and_a_refusal(samples_per_word, delay):
    if samples_per_word < 4:
        strobe = np.tile([False, True], 30)[:48]
        captured, refused = assert_as_model(samples_per_word, strobe, delay)
        assert (captured, refused) == (24, 0), "one rise a word at most fits in here"
        return
    for second in (2, 3):
        for place in range(4):
            strobe = pulses(48, [20 + place, 20 + place + second])
            first_word, second_word = ((20 + place + gap + delay) // 4 for gap in (0, second))
            due_sample, refused = run(4, strobe, delay)
            crowded = first_word == second_word
            assert len(samples_of(due_sample)) == 2 - crowded
            assert samples_of(due_sample)[0] == divmod(20 + place + delay, 4)
            assert refused.sum() == crowded


@each_word_size
@pytest.mark.parametrize("delay", [0, 1, 3, 30])
def test_a_strobe_that_is_high_from_power_up_captures_nothing_until_it_falls(samples_per_word, delay):
    strobe = np.ones(40 * samples_per_word, bool)
    due_sample, refused = run(samples_per_word, strobe, delay)
    assert not due_sample.any()
    assert not refused.any()
    strobe[20 * samples_per_word : 21 * samples_per_word] = False
    due_sample, _ = run(samples_per_word, strobe, delay)
    assert samples_of(due_sample) == [divmod(21 * samples_per_word + delay, samples_per_word)]


@each_word_size
@pytest.mark.parametrize("delay", [0, 3, 37])
def test_a_long_strobe_is_one_strobe(samples_per_word, delay):
    strobe = np.zeros(60 * samples_per_word, bool)
    strobe[11:53] = True
    assert samples_of(run(samples_per_word, strobe, delay)[0]) == [divmod(11 + delay, samples_per_word)]


@each_word_size
def test_reset_forgets_the_strobes_that_wait(samples_per_word):
    delay = 30 * samples_per_word
    strobe = pulses(80 * samples_per_word, [k * samples_per_word for k in (8, 9, 12, 60)])
    due_sample, refused = run(samples_per_word, strobe, delay, rst=[0] * 20 + [1, 1, 0])
    assert samples_of(due_sample) == [(90, 0)]
    assert not refused.any()
