"""Lost counts are found wherever they hide."""

import numpy as np
import pytest

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_sim.core_log import SPI_FRAME, CoreLog
from arcref_sim.encoder import EncoderPiece
from arcref_sim.lost_counts import LostCounts


def piece_of(start, end, samples, counts) -> EncoderPiece:
    changes = SignalChanges(np.array([start]), np.zeros(1, np.uint8), end)
    return EncoderPiece(changes, np.array(samples), np.array(counts))


def log_of(words, raw, end_word) -> CoreLog:
    records = np.zeros(len(words), POSITION_CHANGE)
    records["word"], records["raw_position"] = words, raw
    return CoreLog(records, np.empty(0, STATUS_CHANGE), np.empty(0, CAPTURE), np.empty(0, SPI_FRAME), end_word)


@pytest.mark.parametrize(
    ("words", "raw", "largest"),
    [
        ([2, 5, 7], [1, 2, 3], 0),
        ([2, 5], [1, 2], 1),  # the core stood still
        ([2, 5, 7], [1, 2, 7], 4),
        ([2, 5, 6, 7], [1, 2, 5, 3], 3),  # wrong between two changes of the truth
        ([3, 5, 7], [1, 2, 3], 1),  # a word late
        ([1, 2, 5, 7], [-9, 1, 2, 3], 0),  # before it homed
    ],
)
def test_every_word_is_compared(words, raw, largest):
    lost = LostCounts(4)
    # Two edges in word 5: the count after its last sample is what the core shows.
    lost.add(piece_of(0, 40, [0, 9, 20, 22, 28], [0, 1, 5, 2, 3]), log_of(words, raw, 10), homed_word=2)
    assert lost.largest == largest


def test_pieces_and_lagging_logs_join():
    lost = LostCounts(4)
    lost.add(piece_of(0, 40, [0, 9, 36], [0, 1, 2]), log_of([2], [1], 8), homed_word=1)
    lost.add(piece_of(40, 80, [40, 44], [2, 3]), log_of([9, 11], [2, 3], 18), homed_word=1)
    lost.add(None, log_of([], [], 20), homed_word=1)
    assert lost.largest == 0
