"""The Verilated core against the golden model, at every word, for all kinds of motion and faults."""

import numpy as np
import pytest

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.latency import FIRST_CORRECTED_WORD
from arcref_sim import faults
from arcref_sim.encoder import SyntheticEncoder
from arcref_sim.graduation import GraduationError
from arcref_sim.motion import Motion
from arcref_sim.spi_plan import SpiPlan
from arcref_sim.square_waves import SquareWaves, ZeroMark

WORD_CLOCK_HZ = 200e6
POWER_UP_S = (FIRST_CORRECTED_WORD + 100) / WORD_CLOCK_HZ

each_word_size = pytest.mark.parametrize("samples_per_word", [1, 2, 4])


def motions(samples_per_word: int) -> dict[str, Motion]:
    """Motions that an input of so many samples can follow, all across the zero mark."""
    top_rps = 20 * samples_per_word
    start = Motion(-400.5).standstill(POWER_UP_S)
    return {
        "there and back": start.constant_speed(10, turns=1e-4).constant_speed(-10, turns=1e-4),
        "ramp up": start.ramp(top_rps, 2e-4).constant_speed(top_rps, duration_s=2e-5),
        "through zero speed": start.ramp(10, 5e-5).ramp(-10, 1e-4).ramp(10, 1e-4),
        "swing": Motion(10.5).standstill(POWER_UP_S).swing(37.3, 40_000, cycles=12),
        "homed before the tables are checked": Motion(-100.5).constant_speed(10, turns=4e-4),
        "seam backwards": Motion(60.5).constant_speed(-3, duration_s=2e-4),
    }


@each_word_size
@pytest.mark.parametrize("motion", motions(1))
@pytest.mark.parametrize("width", [1, 4])
def test_motions(samples_per_word, motion, width, bench, network):
    encoder = SyntheticEncoder(
        motions(samples_per_word)[motion],
        WORD_CLOCK_HZ * samples_per_word,
        GraduationError.from_curve(network.evaluate),
        zero_mark=ZeroMark(width),
    )
    checked = bench(samples_per_word)
    checked.run(piece.changes for piece in encoder.pieces(50_000))
    status = checked.joined("status")
    assert status["homed"][-1] == 1
    assert not Flag(int(status["flags"][-1])) & (Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR | Flag.INDEX_FAULT)
    # The model is compared with the core, and here with the truth.
    piece, positions = encoder.whole(), checked.joined("positions")
    homed = positions[positions["word"] >= status["word"][status["homed"] == 1][0]]
    truth = piece.count_at(homed["word"] * samples_per_word + samples_per_word - 1)
    np.testing.assert_array_equal(homed["raw_position"], truth)


SQUARE_WAVES = {
    "duty and phase": SquareWaves(a_duty=0.58, b_duty=0.46, phase_error_deg=15),
    "jitter": SquareWaves(jitter_ns=4, shortest_edge_spacing_ns=5.2),
    "converter": SquareWaves(conversion_interval_ns=2000, shortest_edge_spacing_ns=5.2),
    "delay": SquareWaves(delay_ns=5000),
}


@each_word_size
@pytest.mark.parametrize("waves", SQUARE_WAVES)
def test_imperfect_square_waves_lose_nothing(samples_per_word, waves, bench):
    motion = Motion(-900.5).standstill(POWER_UP_S).constant_speed(8, turns=3e-4).constant_speed(-8, turns=3e-4)
    encoder = SyntheticEncoder(
        motion.standstill(1e-5),
        WORD_CLOCK_HZ * samples_per_word,
        waves=SQUARE_WAVES[waves],
        zero_mark=ZeroMark(3),
        seed=8,
    )
    checked = bench(samples_per_word)
    checked.run(piece.changes for piece in encoder.pieces())
    status = checked.joined("status")[-1]
    assert status["illegal_steps"] == status["closure_error"] == 0
    assert checked.joined("positions")["raw_position"][-1] == encoder.whole().count[-1]


def fault_lists(samples_per_word: int) -> dict[str, list]:
    """Faults after the zero mark was met, at samples spread over the places in a word."""
    start = int((POWER_UP_S + 2.5e-5) * WORD_CLOCK_HZ) * samples_per_word
    edge = 8 * samples_per_word
    return {
        "slip of 4": faults.slip(start + 1, 4),
        "slip of 1": faults.slip(start + 2, 1),
        "slip back of 1": faults.slip(start + 3, -1),
        "extra pulses": faults.extra_pulses(start, samples_per_word, periods=3),
        "dropped pulses": faults.dropped_pulses(start, start + 20 * edge),
        # Where no edge is: beside one the two would make a step that is legal.
        "double transition": faults.double_transition(start + 2 - samples_per_word // 4),
        "double transition there and back": faults.double_transition(start + 3, 1),
        "noise": faults.noise_glitches(start, start + 200 * edge, 60, seed=1),
        "noise on Z": faults.noise_glitches(start, start + 200 * edge, 60, line=4, seed=2),
    }


@each_word_size
@pytest.mark.parametrize("fault", fault_lists(1))
def test_faults(samples_per_word, fault, bench):
    motion = Motion(-300.5).standstill(POWER_UP_S).constant_speed(8, turns=3e-4).constant_speed(-8, turns=3.5e-4)
    encoder = SyntheticEncoder(
        motion,
        WORD_CLOCK_HZ * samples_per_word,
        faults=tuple(fault_lists(samples_per_word)[fault]),
        zero_mark=ZeroMark(2),
    )
    checked = bench(samples_per_word)
    checked.run(piece.changes for piece in encoder.pieces())
    flags = Flag(int(checked.joined("status")["flags"][-1]))
    if fault == "slip of 4":
        # Whole periods of A and B against the shaft leave every line as it was: no edge was lost, and none is missed.
        assert not flags & (Flag.CLOSURE_ERROR | Flag.ILLEGAL_STEP | Flag.INDEX_FAULT)
    if fault == "extra pulses":
        assert flags & Flag.CLOSURE_ERROR
    if fault.startswith("double"):
        assert flags & Flag.ILLEGAL_STEP


@each_word_size
def test_missing_and_second_zero_marks(samples_per_word, bench):
    """A second mark three lines away, and the right one gone on the way back: one turn at 60 r/s."""
    start = Motion(COUNTS_PER_TURN - 20_000.5).standstill(POWER_UP_S)
    motion = start.constant_speed(18, turns=0.005).constant_speed(-18, turns=0.005)
    mark = ZeroMark(2, extra_counts=(COUNTS_PER_TURN - 3 * 2048,))
    encoder = SyntheticEncoder(motion, WORD_CLOCK_HZ * samples_per_word, zero_mark=mark)
    checked = bench(samples_per_word)
    checked.run(piece.changes for piece in encoder.pieces())
    assert Flag(int(checked.joined("status")["flags"][-1])) & Flag.INDEX_FAULT


@each_word_size
@pytest.mark.parametrize("top_rps_a_sample", [30, 75, 120])
def test_too_fast_is_flagged_before_a_count_is_lost(samples_per_word, top_rps_a_sample, bench):
    """Up through one, two and beyond three counts a sample; 23.8 r/s are one count a sample at 200 M samples/s."""
    top_rps = top_rps_a_sample * samples_per_word
    motion = Motion(-300.5).standstill(POWER_UP_S).ramp(top_rps, 5e-4)
    encoder = SyntheticEncoder(motion, WORD_CLOCK_HZ * samples_per_word)
    checked = bench(samples_per_word)
    checked.run(piece.changes for piece in encoder.pieces())
    positions, status, whole = checked.joined("positions"), checked.joined("status"), encoder.whole()
    homed = positions[positions["word"] >= status["word"][status["homed"] == 1][0]]
    truth = whole.count_at(homed["word"] * samples_per_word + samples_per_word - 1)
    lost = homed["word"][homed["raw_position"] != truth]
    at_limit = status["word"][(status["flags"] & Flag.EDGE_SPACING_LIMIT) != 0]
    assert len(lost)
    assert at_limit[0] <= lost[0]
    assert Flag(int(status["flags"][-1])) & Flag.ILLEGAL_STEP


@each_word_size
@pytest.mark.parametrize("liveliness", [0.05, 0.5, 1.0])
def test_any_samples_at_all(samples_per_word, liveliness, bench, random):
    """Random lines, legal or not: counting, indices, faults and strobes agree whatever comes."""
    number = 48_000
    samples = random.integers(0, 16, number)
    keep = random.random(number) > liveliness
    keep[0] = False
    samples = samples[np.maximum.accumulate(np.where(keep, 0, np.arange(number)))]
    cuts = [0, 4, 1000, 20_000, number]
    pieces = [SignalChanges.from_samples(samples[a:b], a) for a, b in zip(cuts, cuts[1:], strict=False)]
    bench(samples_per_word, strobe_delay=37).run(pieces)


@each_word_size
@pytest.mark.parametrize("delay", [0, 1, 7, 1000, 65535])
@pytest.mark.parametrize("speed_rps", [0.0, 10.0, -63.0])
def test_strobes_capture_the_true_position(samples_per_word, delay, speed_rps, bench, random):
    top = 23 * samples_per_word
    speed_rps = float(np.clip(speed_rps, -top, top))
    rate_hz = WORD_CLOCK_HZ * samples_per_word
    motion = Motion(-20.5 if speed_rps >= 0 else 20.5).standstill(POWER_UP_S).swing(40, 2e4, 1)
    start = int(motion.duration_s * rate_hz)
    motion = motion.constant_speed(speed_rps or 1e-9, duration_s=4e-4)
    strobes = np.unique(
        start + random.integers(0, int(2e-5 * rate_hz), 12) // (2 * samples_per_word) * 2 * samples_per_word
    )
    strobes += random.integers(0, samples_per_word, len(strobes))
    encoder = SyntheticEncoder(motion, rate_hz, faults=tuple(faults.strobe_pulses(strobes)))
    checked = bench(samples_per_word, strobe_delay=delay)
    checked.run(piece.changes for piece in encoder.pieces(100_000))
    captures = checked.joined("captures")
    due = strobes + delay
    due = due[due < encoder.number_of_samples]
    np.testing.assert_array_equal(captures["capture_time"], due)
    np.testing.assert_array_equal(captures["capture_raw"], encoder.whole().count_at(due))
    assert not np.any(checked.joined("status")["flags"] & Flag.CAPTURE_OVERRUN)


def test_the_quick_build_is_the_plain_one(rom, bench, random):
    """Blocks that rest, one evaluation a clock and power-up without reset: all the same as the core clocked plainly."""
    motion = Motion(-100.5).standstill(POWER_UP_S).swing(500, 4000, 1).standstill(1e-4)
    strobes = np.sort(random.choice(120_000, 50, replace=False)) * 2
    encoder = SyntheticEncoder(motion, 4 * WORD_CLOCK_HZ, faults=tuple(faults.strobe_pulses(strobes)))
    quick, plain = bench(4, 500), bench(4, 500, plain=True)
    plain.core.reset(3)
    frames = []
    for checked in (quick, plain):
        checked.core.plan_spi(SpiPlan(np.array([0, 0, 3000, 40_000, 40_100]), clock_ratio=9.5))
        checked.run(piece.changes for piece in encoder.pieces(30_000))
        frames.append(checked.core.frames())
    np.testing.assert_array_equal(*frames)
    assert len(frames[0]) == 5


def test_pieces_must_follow_each_other(bench):
    core = bench(4).core
    core.run(SignalChanges(np.array([0]), np.zeros(1, np.uint8), 400))
    with pytest.raises(ValueError, match="not whole words from word 100 on"):
        core.run(SignalChanges(np.array([404]), np.zeros(1, np.uint8), 800))
    with pytest.raises(ValueError, match="no input sparkle"):
        core.set_input("sparkle", 1)
    with pytest.raises(ValueError, match="has no reset"):
        core.reset()
