"""The simulated SPI controller, its frames decoded by the host and held against the core's own outputs."""

import numpy as np
import pytest

from arcref.flags import Flag
from arcref.position_frame import encode_clear_flags
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_sim import faults
from arcref_sim.core_log import SPI_FRAME
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.motion import Motion
from arcref_sim.spi_plan import SpiPlan, decode_frames, snapshot_words

RATE_HZ = 800e6
POWER_UP_S = (FIRST_CORRECTED_WORD + 100) / 200e6
MOTION = Motion(-500.5).standstill(POWER_UP_S).constant_speed(10, turns=1e-3).constant_speed(-10, turns=1.1e-3)


def shown_at(positions, words) -> np.ndarray:
    place = np.searchsorted(positions["word"], words, side="right") - 1
    return np.where(place < 0, 0, positions["position"][place])


@pytest.mark.parametrize("clock_ratio", [8, 8.5, 11.3, 40])
@pytest.mark.parametrize("gap", [4, 7])
def test_back_to_back_frames_hold_the_position_of_their_word(clock_ratio, gap, bench):
    checked = bench(4)
    number = 30 if clock_ratio < 20 else 15
    checked.core.plan_spi(SpiPlan.back_to_back(number, clock_ratio=clock_ratio, gap=gap))
    checked.run(piece.changes for piece in SyntheticEncoder(MOTION, RATE_HZ).pieces())
    records = checked.core.frames()
    frames = decode_frames(records)
    assert len(frames) == number
    assert [frame.frame_counter for frame in frames] == [(frames[0].frame_counter + i) & 0xFF for i in range(number)]
    expected = shown_at(checked.joined("positions"), snapshot_words(records, checked.core.latency_words))
    assert [frame.position for frame in frames] == expected.tolist()


def test_aborted_frames_leave_the_next_one_whole(bench):
    checked = bench(4)
    bits = np.array([64, 24, 64, 32, 64, 1, 64, 63, 64, 0, 64])
    checked.core.plan_spi(SpiPlan(np.zeros(len(bits), np.int64), bits=bits))
    checked.run(piece.changes for piece in SyntheticEncoder(MOTION, RATE_HZ).pieces())
    frames = decode_frames(checked.core.frames())
    assert len(frames) == 6
    assert None not in frames


def test_a_command_clears_a_flag(bench):
    """The flag falls where the command ends; the model is not told of it, so it is looked at alone."""
    checked = bench(4)
    start = int((POWER_UP_S + 2e-5) * RATE_HZ)
    encoder = SyntheticEncoder(MOTION, RATE_HZ, faults=tuple(faults.double_transition(start, 2)))
    sent = np.zeros((2, 8), np.uint8)
    sent[0] = np.frombuffer(encode_clear_flags(Flag.ILLEGAL_STEP), np.uint8)
    after = int((POWER_UP_S + 3e-5) * 200e6)
    checked.core.plan_spi(SpiPlan(np.array([after, after + 2000]), sent=sent))
    for piece in encoder.pieces():
        checked.core.run(piece.changes)
    before, later = decode_frames(checked.core.frames())
    assert before.flags & Flag.ILLEGAL_STEP
    assert not later.flags & Flag.ILLEGAL_STEP
    assert checked.core.output("illegal_steps") == 2


def test_a_damaged_frame_is_none():
    assert decode_frames(np.array([(0, 64, [1] * 8)], SPI_FRAME)) == [None]


def test_plans_must_fit():
    with pytest.raises(ValueError, match="each frame"):
        SpiPlan(np.zeros(2, np.int64), bits=np.array([64])).arrays()
