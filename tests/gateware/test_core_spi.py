"""The SPI port inside the core: the frame says what the ports say, and a clear clears what it names."""

from functools import cache

import numpy as np
from core_bench import CoreBench
from encoder_lines import GATE_STATE_NUMBER, lines_of_counts
from spi_lines import SpiLines, to_bytes

from arcref.angle import split_position
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref.position_frame import PositionFrame, encode_clear_flags
from arcref_gateware.golden.steps import NO_SPACING
from arcref_gateware.latency import LATENCY_CLOCKS

SAMPLES = 4


@cache
def bench() -> CoreBench:
    return CoreBench(CorrectionRom(np.zeros(4096, np.int16)), SAMPLES)


def run(lines: SpiLines, counts, z=False):
    """Rows of the core by clock, the bits read, and the rows of the SPI lines."""
    spi = lines.rows()
    counts = np.concatenate((counts, np.repeat(counts[-1:], max(0, SAMPLES * len(spi["sck"]) - len(counts)))))
    counts = counts[: len(counts) // SAMPLES * SAMPLES]
    z = np.resize(np.concatenate((np.asarray(z), np.zeros(len(counts), bool))), len(counts)) if np.ndim(z) else z
    rows = bench().run(lines_of_counts(counts, z), **{f"spi_{name}": row for name, row in spi.items()})
    # Row k of the outputs is what clock k + latency shows; the SPI lines and CIPO go by clocks.
    cipo = np.concatenate((np.zeros(LATENCY_CLOCKS, int), rows["spi_cipo"]))
    return rows, lines.received(cipo), spi


def faulty_start():
    """Counts that home, make one illegal step, which costs 2 counts, come back to the index and rest."""
    zero = GATE_STATE_NUMBER
    counts = np.concatenate((np.arange(zero - 10, zero + 40), np.arange(zero + 41, zero - 10, -1)))
    counts = np.repeat(counts, 3)
    return counts, counts == zero


def test_the_frame_is_the_position_and_flags_of_one_word():
    lines = SpiLines(start=LATENCY_CLOCKS + 8.5)
    for _ in range(4):
        lines.transfer(gap=5)
    zero = GATE_STATE_NUMBER
    moving = zero + 30 - np.arange(40 + 2 * SAMPLES * len(lines.rows()["sck"])) // 2
    rows, bits, _ = run(lines, moving, moving == zero)
    turns = set()
    for number, read in enumerate(bits):
        frame = PositionFrame.decode(to_bytes(read))
        clock = int(np.ceil(lines.selects[number]))
        shown = []
        for word in range(clock - LATENCY_CLOCKS - 1, clock - LATENCY_CLOCKS + 4):
            turn, angle = split_position(int(rows["position"][word]))
            flags, homed = Flag(int(rows["flags"][word])), bool(rows["homed"][word])
            shown.append(PositionFrame(angle, homed, flags, turn, number))
        assert frame in shown
        turns.add(frame.turns)
    assert turns == {-1}, "just below zero the turns are -1 and the angle is near its end"


def test_a_clear_takes_the_named_flags_and_leaves_the_others_and_the_counts():
    counts, z = faulty_start()
    lines = SpiLines(start=150)
    lines.transfer(encode_clear_flags(Flag.CLOSURE_ERROR), gap=30)
    lines.transfer(encode_clear_flags(Flag.EDGE_SPACING_LIMIT), gap=30)
    lines.transfer(encode_clear_flags(0xFF), gap=30)
    lines.transfer(gap=30)
    rows, bits, _ = run(lines, counts, z)
    flags = [PositionFrame.decode(to_bytes(read)).flags for read in bits]
    direction = Flag.LAST_DIRECTION_REVERSE
    both = Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR
    assert flags == [both | direction, Flag.ILLEGAL_STEP | direction, Flag.ILLEGAL_STEP | direction, direction]
    assert rows["closure_error"][-1] == -2
    assert rows["illegal_steps"][-1] == 1
    assert rows["index_count"][-1] == 2
    assert rows["largest_closure_error"][120] == -2
    assert rows["largest_closure_error"][-1] == 0
    assert rows["shortest_edge_spacing"][120] == 3
    assert rows["shortest_edge_spacing"][-1] == NO_SPACING


def test_a_clear_while_the_cause_goes_on_leaves_the_flag_up_or_brings_it_back_at_once():
    lines = SpiLines(start=60)
    lines.transfer(encode_clear_flags(0xFF), gap=40)
    lines.transfer(gap=20)
    counts = 2 * (np.arange(SAMPLES * len(lines.rows()["sck"])) // 3)  # an illegal step every third sample
    rows, bits, _ = run(lines, counts)
    assert PositionFrame.decode(to_bytes(bits[1])).flags & Flag.ILLEGAL_STEP
    assert np.all(np.diff(rows["illegal_steps"][3:500]) >= 1)


def test_a_cause_that_ended_before_the_clear_does_not_raise_its_flag_again():
    counts, z = faulty_start()
    lines = SpiLines(start=200)
    lines.transfer(encode_clear_flags(0xFF), gap=100)
    rows, _, _ = run(lines, counts, z)
    fault = rows["flags"] & Flag.ILLEGAL_STEP != 0
    assert np.count_nonzero(np.diff(fault.astype(int)) == 1) == 1
    assert not fault[-1]
