"""The test generator, sample for sample what its golden model says, however it is driven."""

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, assert_rows

from arcref.angle import COUNTS_PER_TURN, LINES_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.link.registers import GENERATOR_FAULTS, GENERATOR_RATE_STEP, REGISTERS
from arcref_gateware.boards.square_wave_generator import GENERATOR_CLOCKS, RATE_BITS, START_COUNT, SquareWaveGenerator
from arcref_gateware.boards.square_wave_golden import square_wave_samples
from arcref_gateware.golden.core import CoreModel
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, Z_BIT, SignalChanges

LINES = ("a", "b", "z", "strobe")
FASTEST = (1 << RATE_BITS) - 1
INPUTS = ("rate", "run", "reverse", "fault")


def assert_same_lines(samples_per_word, asked, strobe_words=256):
    generator = SquareWaveGenerator(samples_per_word, strobe_words)
    words = len(asked["rate"])
    rows = Bench(generator, list(INPUTS), list(LINES)).run(words, **asked)
    expected = square_wave_samples(samples_per_word, strobe_words=strobe_words, **asked)
    for name in LINES:
        assert_rows(name, rows[name], as_bits(expected[name].reshape(-1, samples_per_word)))
    return expected


@pytest.mark.parametrize("samples_per_word", [1, 2, 4])
@pytest.mark.parametrize("rate", [1, 3, 12345, 0x7FFFFF, 0x800001, FASTEST])
def test_a_constant_speed_forward_and_back(samples_per_word, rate):
    words = 1200
    reverse = (np.arange(words) >= 700).astype(int)
    assert_same_lines(samples_per_word, {"rate": np.full(words, rate), "reverse": reverse, "run": 1, "fault": 0}, 64)


@pytest.mark.parametrize("samples_per_word", [1, 2, 4])
def test_every_input_changing_at_random_in_any_word(samples_per_word, rng):
    """Reversals about the zero mark and the fault's place, where every line matters."""
    approach = -START_COUNT // samples_per_word + 10
    words = approach + 6000
    changes = rng.random(words) < 0.2
    held = np.maximum.accumulate(np.where(changes, np.arange(words), 0))
    asked = {
        "rate": (rng.integers(0, FASTEST, words, endpoint=True) >> rng.integers(0, 6, words))[held],
        "run": (rng.random(words) < 0.9).astype(int)[held],
        "reverse": np.zeros(words, int),
        "fault": as_bits(rng.random((words, len(GENERATOR_FAULTS))) < 0.2),
    }
    for name, value in (("rate", FASTEST), ("run", 1)):
        asked[name][:approach] = value
    # To and fro between both places.
    ahead = np.concatenate(([0], np.cumsum(asked["rate"] * asked["run"] * samples_per_word))) >> RATE_BITS
    count = START_COUNT + ahead[approach]
    for word in range(approach, words):
        goal = rng.integers(0, 80) + 100 * (word // 600 % 2) - 50
        asked["reverse"][word] = reverse = int(count > goal)
        count += (1 - 2 * reverse) * (ahead[word + 1] - ahead[word])
    expected = assert_same_lines(samples_per_word, asked, 16)
    about = expected["count"][samples_per_word * (approach + 20) :]
    assert -100 < about.min() < -4
    assert 72 < about.max() < 200
    assert expected["z"].any()


@pytest.mark.parametrize("fault", GENERATOR_FAULTS)
@pytest.mark.parametrize("reverse", [0, 1])
def test_a_fault_is_what_the_registers_say_of_it(fault, reverse):
    bit = 1 << list(GENERATOR_FAULTS).index(fault)
    words = 12000
    turned = np.arange(words) >= 5000  # back over the zero mark
    asked = {"rate": np.full(words, FASTEST // 3), "run": 1, "fault": bit * (turned == reverse)}
    asked["reverse"] = turned.astype(int)
    expected = assert_same_lines(4, asked)
    states = expected["a"] << A_BIT | expected["b"] << B_BIT | expected["z"] << Z_BIT
    clean = square_wave_samples(4, asked["rate"], reverse=asked["reverse"])
    core = CoreModel(CorrectionRom(np.zeros(LINES_PER_TURN, np.int16)), 4)
    status = core.run(SignalChanges.from_samples(states.astype(np.uint8))).status[-1]
    assert status["illegal_steps"] == (1 if fault == "doubled_step" and not reverse else 0)
    wrong = {name: np.flatnonzero(expected[name] != clean[name]) for name in LINES}
    touched = {"dropped_edge": "a", "doubled_step": "a", "missing_index": "z", "wide_index": "z"}[fault]
    if reverse != (fault == "missing_index") and fault != "wide_index":
        assert not any(len(places) for places in wrong.values())
        return
    assert [name for name in LINES if len(wrong[name])] == [touched]
    places = set(expected["count"][wrong[touched]])
    if touched == "z":
        assert places == ({0, 1, 2, 3} if fault == "missing_index" else {4, 5, 6, 7})
    else:
        assert places == ({65, 66} if fault == "dropped_edge" else {65})


def test_it_turns_at_the_rate_and_comes_back():
    words, rate = 2048, 20000 << 8
    asked = {"rate": np.full(words, rate), "reverse": np.arange(words) >= words // 2}
    lines = square_wave_samples(4, **asked)
    count = lines["count"]
    assert set(np.abs(np.diff(count))) <= {0, 1}
    assert np.ptp(count) == pytest.approx(words / 2 * 4 * rate / (1 << RATE_BITS), abs=2)
    # Forward is A before B.
    states = np.array([0, 1, 3, 2])[count % 4]
    np.testing.assert_array_equal(lines["a"] + 2 * lines["b"], states)


def test_it_stands_while_it_does_not_run_and_goes_on_where_it_stood():
    words = 900
    run = (np.arange(words) // 100 % 2 == 0).astype(int)
    lines = assert_same_lines(2, {"rate": np.full(words, FASTEST // 2), "run": run, "reverse": 0, "fault": 0})
    count = lines["count"].reshape(words, 2)
    stood = count[112:208]
    assert np.ptp(stood) == 0
    assert count[-1, -1] - START_COUNT == pytest.approx(run[:-GENERATOR_CLOCKS].sum(), abs=2)


def test_the_registers_give_the_rate_its_whole_range():
    assert REGISTERS["generator_rate"].width - RATE_BITS == GENERATOR_RATE_STEP.bit_length() - 1
    slowest_rps = 800e6 / (1 << RATE_BITS) / COUNTS_PER_TURN
    assert slowest_rps < 1e-5
