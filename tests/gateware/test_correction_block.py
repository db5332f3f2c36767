"""Correction: every word and every event in a word gets what `CorrectionRom.correction` says for its position."""

import numpy as np
import pytest
from amaranth_bench import Bench, assert_rows

from arcref.angle import COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref_gateware.correction import CORRECTION_CLOCKS, Correction
from arcref_gateware.table_memory import TABLE_CLOCKS, TableMemory

SAMPLES = 4
"""The widest word, which moves furthest."""

INPUTS = ["angle", "homed", "event", "event_angle", "usable", "check_enable", "check_address"]
OUTPUTS = ["line_word", "subdivision_word", "word_complement", "event_complement", "active"]


@pytest.fixture(scope="module")
def random_bench(random_rom) -> Bench:
    return bench(random_rom)


def bench(rom) -> Bench:
    return Bench(Correction(rom.line_table, rom.subdivision_table), INPUTS, OUTPUTS)


def run(block: Bench, position, event_place=None, homed=1, usable=1, check_enable=0, check_address=0):
    """Corrections of words whose samples stand at `position`, one row a word, and at their events; and `active`.

    `event_place` names the sample of the event in each word, -1 for none.
    """
    words = len(position)
    place = np.full(words, -1) if event_place is None else np.asarray(event_place)
    event_angle = position[np.arange(words), place] % COUNTS_PER_TURN
    rows = block.run(
        words + CORRECTION_CLOCKS,
        angle=position[:, -1] % COUNTS_PER_TURN,
        homed=homed,
        event=np.append(place >= 0, 0),
        event_angle=np.insert(event_angle, 0, 0),
        usable=usable,
        check_enable=check_enable,
        check_address=check_address,
    )
    rows = {name: column[CORRECTION_CLOCKS:] for name, column in rows.items()}
    # The complement plus `active` is what the core adds to the position.
    word, event = -(rows["word_complement"] + rows["active"]), -(rows["event_complement"] + rows["active"])
    return word, event, rows["active"]


def walk(rng, words: int, start: int) -> np.ndarray:
    """Positions of the samples of a walk in fast and slow stretches, and dither in one place."""
    stretch = rng.integers(0, 4, words // 8 + 1).repeat(8 * SAMPLES)[: words * SAMPLES]
    dither = rng.integers(-1, 2, words * SAMPLES)
    step = np.select([stretch == 0, stretch == 1], [1, -1], dither)
    return start + np.cumsum(step).reshape(words, SAMPLES)


def assert_corrected(rom, position, place, word, event, first=0):
    assert_rows("correction of the word", word[first:], rom.correction(position[:, -1])[first:], first)
    has_event = np.flatnonzero(place >= 0)
    has_event = has_event[has_event >= first]
    at_event = position[has_event, place[has_event]]
    assert_rows("correction at the event", event[has_event], rom.correction(at_event))


STARTS = [0, COUNTS_PER_TURN // 2, COUNTS_PER_TURN - 30, 5 * 2048, 3 * 2048 - 10, -7 * COUNTS_PER_TURN + 2040]


@pytest.mark.parametrize("start", STARTS)
def test_every_word_and_event_of_a_walk(start, random_bench, random_rom, rng):
    """Around the turn's seam, line borders and inside a line; every other word has an event."""
    position = walk(rng, 500, start)
    place = np.where(rng.random(500) < 0.5, rng.integers(0, SAMPLES, 500), -1)
    word, event, active = run(random_bench, position, place)
    assert not active[0], "the first word only fetches what the next one may hold on to"
    assert active[1:].all()
    assert_corrected(random_rom, position, place, word, event, first=1)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("start", [0, 1, 2, 3])
def test_an_event_in_the_neighbouring_cell_of_its_words_end(direction, start, random_bench, random_rom):
    """At full speed the word's end is in a new cell each time, and each sample in turn is the event."""
    position = -200 + start + direction * np.arange(400).reshape(100, SAMPLES)
    for offset in range(SAMPLES):
        place = (np.arange(100) + offset) % SAMPLES
        word, event, _ = run(random_bench, position, place)
        assert_corrected(random_rom, position, place, word, event, first=1)


def test_a_word_that_goes_and_comes_back_holds_its_cell(random_bench, random_rom, rng):
    """The end stays in the cell of the word before, the event lies in the other one."""
    for direction in (1, -1):
        for cell in (0, 511, 512, (1 << 21) - 1, *rng.integers(0, 1 << 21, 10)):
            edge = 4 * int(cell) + (3 if direction > 0 else 0)
            position = edge + direction * np.array([[1, 2, 1, 0]] * 6)
            place = rng.integers(-1, 4, 6)
            word, event, _ = run(random_bench, position, place)
            assert_corrected(random_rom, position, place, word, event, first=1)


@pytest.mark.parametrize("line", [-32768, 32767])
@pytest.mark.parametrize("subdivision", [-32768, 32767])
def test_the_largest_entries_add_up_without_overflow(line, subdivision):
    rom = CorrectionRom(np.full(4096, line, np.int16), np.full(512, subdivision, np.int16))
    word, event, _ = run(bench(rom), np.zeros((8, SAMPLES), int), np.zeros(8, int))
    expected = (line + subdivision + 8) >> 4
    assert set(word[1:].tolist()) == set(event[1:].tolist()) == {expected}


def test_rounding_of_every_sixteenth():
    """Half a count rounds up, on both sides of zero."""
    line = np.arange(-2048, 2048)
    rom = CorrectionRom(line, np.zeros(512, np.int16))
    position = np.repeat(np.arange(4096) * 2048 + 2, 2)[:, np.newaxis].repeat(SAMPLES, axis=1)[3900:4300]
    # Neighbouring lines are no neighbouring cells: each line is held for two words, the second of them one cell on.
    position[1::2] += 4
    word, _, _ = run(bench(rom), position)
    expected = np.floor((line + 8) / 16).astype(int)[position[:, -1] // 2048]
    assert_rows("correction", word[1::2], expected[1::2])


@pytest.mark.parametrize("index_place", range(SAMPLES))
@pytest.mark.parametrize("event_place", range(-1, SAMPLES))
def test_the_homing_word_and_an_event_in_it_are_corrected(index_place, event_place, random_bench, random_rom, rng):
    """Up to the homing word the angle is that of an unhomed count, anywhere in the turn."""
    some_steps = [[1, 1, 1, 1], [-1, -1, -1, -1], [1, -1, -1, 1], [0, 1, -1, -1]]
    for steps in some_steps + rng.integers(-1, 2, (4, 4)).tolist():
        homing = np.cumsum(steps)
        homing -= homing[index_place]
        before = walk(rng, 20, int(rng.integers(0, COUNTS_PER_TURN)))
        after = walk(rng, 10, int(homing[-1]))
        position = np.concatenate((before, homing[np.newaxis], after))
        place = np.where(np.arange(31) == 20, event_place, rng.integers(-1, SAMPLES, 31))
        word, event, active = run(random_bench, position, place, homed=[0] * 20 + [1])
        assert active.tolist() == [0] * 20 + [1] * 11
        assert not word[:20].any()
        assert not event[:20].any()
        assert_corrected(random_rom, position, place, word, event, first=20)


def test_the_check_reads_the_tables_and_nothing_is_corrected_until_the_second_word_after_it(
    random_bench, random_rom, rng
):
    checked = 200
    address = rng.integers(0, 1 << 21, checked)
    position = walk(rng, checked + 50, COUNTS_PER_TURN - 40)
    place = rng.integers(-1, SAMPLES, len(position))
    busy = [1] * checked + [0]
    word, event, active = run(random_bench, position, place, check_enable=busy, check_address=address)
    assert active.tolist() == [0] * (checked + 1) + [1] * 49
    assert not word[: checked + 1].any()
    assert not event[: checked + 1].any()
    assert_corrected(random_rom, position, place, word, event, first=checked + 1)

    late = 2 + TABLE_CLOCKS
    rows = random_bench.run(checked + late, check_enable=1, check_address=address)
    assert_rows("line", rows["line_word"][late:], random_rom.line_table.astype(int)[address >> 9] & 0xFFFF)
    subdivision = random_rom.subdivision_table.astype(int)[address & 511] & 0xFFFF
    assert_rows("subdivision", rows["subdivision_word"][late:], subdivision)


def test_bad_tables_correct_nothing(random_bench, rng):
    word, event, active = run(random_bench, walk(rng, 60, 0), rng.integers(-1, SAMPLES, 60), usable=0)
    assert not word.any()
    assert not event.any()
    assert not active.any()


def test_a_table_gives_its_words_after_its_clocks(rng):
    words = rng.integers(-32768, 32768, 64)
    address = rng.integers(0, 64, 100)
    rows = Bench(TableMemory(words), ["address"], ["data"]).run(100 + TABLE_CLOCKS, address=address)
    assert_rows("word", rows["data"][TABLE_CLOCKS:], words[address] & 0xFFFF)
