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
            # The word at which the corrected position passed a line, from the truth: so many words before the pulse.
            latest = twin.core.latency_words + COMPARE_CLOCKS + 4
            words = chosen[:, None] - np.arange(latest + 1)
            position = twin.rom.correct(twin.encoder.ideal_count_at(words * 4 + 3))
            line = (position - start) // period
            passed = line[:, :-1] != line[:, 1:]  # the line between a word and the one before it
            assert np.all(passed.sum(axis=1) >= 1)
            delays = [set(np.flatnonzero(row).tolist()) for row in passed]
            common = [delay for delay in range(latest) if all(delay in row or delay + 1 in row for row in delays)]
            assert common, "the pulses come at more than one word's difference from their lines"
            # One for each line: in order, none left out, none twice.
            numbers = np.array([row[min(d for d in delay if d in (common[0], common[0] + 1))]
                                for row, delay in zip(line, delays, strict=True)])  # fmt: skip
            assert np.all(np.diff(numbers) == (1 if forward else -1))
            if forward:
                assert numbers[0] == 0
