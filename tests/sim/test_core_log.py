"""The comparison finds what differs, and where."""

import numpy as np

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE, CoreOutput
from arcref_sim.core_log import SPI_FRAME, Comparison, CoreLog


def log_of(positions, end_word) -> CoreLog:
    records = np.array(positions, POSITION_CHANGE)
    return CoreLog(records, np.empty(0, STATUS_CHANGE), np.empty(0, CAPTURE), np.empty(0, SPI_FRAME), end_word)


def output_of(positions) -> CoreOutput:
    return CoreOutput(np.array(positions, POSITION_CHANGE), np.empty(0, STATUS_CHANGE), np.empty(0, CAPTURE))


def test_equal_lists_agree_whatever_the_lag():
    comparison = Comparison()
    comparison.add(log_of([(1, 5, 5)], 10), output_of([(1, 5, 5), (15, 6, 6)]))
    comparison.add(log_of([(15, 6, 6)], 20))
    assert comparison.difference is None
    assert comparison.words == 20


def test_the_first_difference_is_named():
    comparison = Comparison()
    comparison.add(log_of([(1, 5, 5), (4, 6, 6)], 10), output_of([(1, 5, 5), (3, 6, 6)]))
    comparison.add(log_of([(11, 9, 9)], 20), output_of([]))
    assert str(comparison.difference) == "word 3, positions: core (4, 6, 6), golden model (3, 6, 6)"


def test_a_change_too_many_and_one_too_few():
    too_many, too_few = Comparison(), Comparison()
    too_many.add(log_of([(2, 1, 1)], 10), output_of([]))
    too_few.add(log_of([], 10), output_of([(2, 1, 1)]))
    assert str(too_many.difference) == "word 2, positions: core (2, 1, 1), golden model none"
    assert str(too_few.difference) == "word 2, positions: core none, golden model (2, 1, 1)"
