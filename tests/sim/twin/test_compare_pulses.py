"""The compare output of the true gateware: a pulse every K counts of corrected position, to the word."""

import numpy as np
import pytest
from twin_truth import wait_until, wait_until_homed

from arcref import Encoder
from arcref.angle import COUNTS_PER_TURN
from arcref_gateware.link.compare_output import COMPARE_CLOCKS

WIDTH = 3
PULSES = 150


@pytest.mark.parametrize(("speed_rps", "period"), [(10.0, 64), (10.0, 1000), (60.0, 64), (60.0, 777)])
def test_every_k_counts_there_is_one_pulse_in_both_directions(make_twin, speed_rps, period):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        start = encoder.position + 2000
        encoder.registers.compare_width = WIDTH
        encoder.registers.compare_start = start % COUNTS_PER_TURN
        encoder.registers.compare_period = period
        twin.set_speed(speed_rps)
        wait_until(lambda: len(twin.compare_edges()) >= 2 * PULSES)
        twin.set_speed(-speed_rps)
        turned_s = twin.call(lambda: twin.encoder.motion._starts_s[-1])
        wait_until(lambda: len(twin.compare_edges()) >= 5 * PULSES)
        edges = twin.compare_edges()
        edges = edges[: len(edges) // 2 * 2]
        rises, falls = edges[::2], edges[1::2]
        assert np.array_equal(falls - rises, np.full(len(rises), WIDTH))
        assert encoder.registers.compare_count >= len(rises)

        turned_word = turned_s * 200e6
        for forward in (True, False):
            chosen = rises[(rises < turned_word) == forward]
            # The word with which the corrected position passed a line, as the truth has it: always as long before.
            word = chosen - twin.core.latency_words - COMPARE_CLOCKS
            before, at = (line_below(twin, word + shift, start, period) for shift in (-1, 0))
            assert np.all(at != before), "a pulse came with another word than its line"
            # In order, none left out, none twice, from the start on.
            assert np.all(np.diff(at) == (1 if forward else -1))
            assert not forward or at[0] == 0


def line_below(twin, word, start: int, period: int) -> np.ndarray:
    """Number of the grid line at or below the corrected position after a word."""
    return (twin.rom.correct(twin.encoder.ideal_count_at(word * 4 + 3)) - start) // period
