"""Where strobes come from, sample by sample."""

import numpy as np
import pytest
from amaranth_bench import Bench, as_bits, as_samples

from arcref.link.registers import STROBE_EDGES, STROBE_SOURCES
from arcref_gateware.link.strobe_source import StrobeSource

PORTS = ["pin", "chip_select", "control", "period", "command"]


def strobes(samples_per_word, clocks, *, source, edge="rising", **values):
    """Samples at which a strobe begins."""
    control = STROBE_SOURCES.index(source) | STROBE_EDGES.index(edge) << 2
    rows = Bench(StrobeSource(samples_per_word), PORTS, ["strobe"]).run(clocks, control=control, **values)["strobe"]
    levels = as_samples(rows, samples_per_word).ravel()
    return np.flatnonzero(np.diff(levels, prepend=1) > 0)


def sparse_levels(seed, samples):
    """A line that keeps each level for two samples or more."""
    rng = np.random.default_rng(seed)
    return np.repeat(rng.integers(0, 2, samples), rng.integers(2, 9, samples))[:samples]


@pytest.mark.parametrize("samples_per_word", [1, 2, 4])
@pytest.mark.parametrize("edge", STROBE_EDGES)
def test_the_pin_gives_its_edges_at_their_own_sample(samples_per_word, edge):
    levels = sparse_levels(7, 400 * samples_per_word)
    words = as_bits(levels.reshape(-1, samples_per_word))
    got = strobes(samples_per_word, 400, source="pin", edge=edge, pin=words)
    change = np.diff(levels, prepend=0)
    wanted = {"rising": change > 0, "falling": change < 0, "both": change != 0}[edge]
    settled = 3 * samples_per_word  # the setting itself takes effect in the first words
    expected = np.flatnonzero(wanted)
    assert np.array_equal(got[got > settled], expected[expected > settled])


@pytest.mark.parametrize("period", [2, 3, 7, 100, 65535, 65536, 65537, 70000])
def test_the_timer_keeps_its_period_to_the_word(period):
    clocks = 3 * period + 20
    got = strobes(4, clocks, source="timer", period=period)
    assert len(got) >= 2
    assert np.array_equal(np.diff(got), [4 * period] * (len(got) - 1))
    assert not (got % 4).any()


@pytest.mark.parametrize("period", [0, 1])
def test_a_timer_without_a_period_is_silent(period):
    assert strobes(4, 300, source="timer", period=period).size == 0


@pytest.mark.parametrize(("edge", "expected"), [("rising", [20]), ("falling", [60]), ("both", [20, 60])])
def test_chip_select_gives_one_strobe_an_edge(edge, expected):
    level = np.zeros(100, int)
    level[20:60] = 1
    got = strobes(4, 100, source="chip select", edge=edge, chip_select=level)
    assert [word for word in got // 4 if word > 5] == [word + 2 for word in expected]


def test_a_command_gives_one_strobe_and_only_when_it_is_the_source():
    command = np.zeros(60, int)
    command[30] = 1
    assert (strobes(2, 60, source="command", command=command) // 2).tolist() == [31]
    assert strobes(2, 60, source="pin", command=command).size == 0
