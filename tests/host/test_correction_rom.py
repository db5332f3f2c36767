import time
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from arcref.angle import ARCSEC_PER_COUNT, COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.radial_basis_network import RadialBasisNetwork


def random_rom(seed=1) -> CorrectionRom:
    """Tables with every value int16 has, the ends among them."""
    random = np.random.default_rng(seed)
    line, within = random.integers(-32768, 32768, 4096), random.integers(-32768, 32768, 512)
    line[[0, 1, -1]] = within[[0, 1, -1]] = -32768, 32767, 32767
    return CorrectionRom(line, within)


ROM = random_rom()


def plain_formula(rom, position):
    """The design's formula with Python's own integers."""
    angle = position % COUNTS_PER_TURN
    entry = int(rom.line_table[angle >> 11]) + int(rom.subdivision_table[(angle & 2047) >> 2])
    return position - ((entry + 8) >> 4)


@given(st.lists(st.integers(-(1 << 47), (1 << 47) - 1), min_size=1, max_size=50))
def test_number_array_and_formula_agree(positions):
    expected = [plain_formula(ROM, position) for position in positions]
    assert [ROM.correct(position) for position in positions] == expected
    corrected = ROM.correct(np.array(positions))
    assert corrected.dtype == np.int64
    assert corrected.tolist() == expected
    assert (np.array(positions) - ROM.correction(np.array(positions))).tolist() == expected


def test_agree_at_every_edge_of_a_cell_and_over_the_seam():
    edges = np.arange(-4, 4097 * 512 + 4)[:, np.newaxis] * 4 + [0, 3]
    picked = np.concatenate([edges[:2000], edges[-2000:], edges[::977]]).ravel()
    assert ROM.correct(picked).tolist() == [plain_formula(ROM, int(position)) for position in picked]


def test_beyond_64_bits_a_number_is_still_exact():
    position = (1 << 100) + 12345
    assert ROM.correct(position) == plain_formula(ROM, position)


def test_shape_and_kind():
    assert ROM.correct(np.zeros((3, 2, 5), np.int32)).shape == (3, 2, 5)
    assert ROM.correct(np.zeros(0, np.int64)).shape == (0,)
    assert type(ROM.correct(np.int64(5))) is int
    assert ROM.correct([1, 2, 3]).tolist() == [plain_formula(ROM, position) for position in (1, 2, 3)]
    with pytest.raises(TypeError, match="float64"):
        ROM.correct(np.zeros(3))


def test_the_input_is_left_alone():
    positions = np.arange(100_000)
    ROM.correct(positions)
    assert np.array_equal(positions, np.arange(100_000))


def test_the_turn_borrows_and_carries():
    rom = CorrectionRom(np.full(4096, 16 * 5))
    assert [rom.correct(position) for position in (0, 4, 5, COUNTS_PER_TURN)] == [-5, -1, 0, COUNTS_PER_TURN - 5]
    rom = CorrectionRom(np.full(4096, -16 * 5))
    assert rom.correct(COUNTS_PER_TURN - 1) == COUNTS_PER_TURN + 4


@pytest.mark.parametrize(("entry", "counts"), [(7, 0), (8, 1), (-8, 0), (-9, -1), (24, 2), (32767, 2048)])
def test_sixteenths_are_rounded_half_up(entry, counts):
    assert CorrectionRom(np.full(4096, entry)).correction(123) == counts


def test_cells():
    line, within = np.zeros(4096, int), np.zeros(512, int)
    line[1], within[3] = 16 * 100, 16 * 7
    rom = CorrectionRom(line, within)
    assert [rom.correction(count) for count in (2047, 2048, 4095, 4096)] == [0, 100, 100, 0]
    assert [rom.correction(count) for count in (11, 12, 15, 16, 2048 + 12)] == [0, 7, 7, 0, 107]


def test_crc_is_over_the_line_table_then_the_other():
    raw = ROM.line_table.astype("<i2").tobytes() + ROM.subdivision_table.astype("<i2").tobytes()
    assert len(raw) == 2 * (4096 + 512)
    assert ROM.crc32 == zlib.crc32(raw)
    assert CorrectionRom(np.zeros(4096, int)).crc32 == zlib.crc32(bytes(9216))


def test_tables_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        ROM.line_table[0] = 1


@pytest.mark.parametrize(
    ("line", "message"),
    [
        (np.zeros(4095, int), "4096 entries"),
        (np.zeros(4096), "integers were expected"),
        (np.full(4096, 32768), "beyond -32768 .. 32767"),
    ],
)
def test_wrong_tables(line, message):
    with pytest.raises(ValueError, match=message):
        CorrectionRom(line)


def test_entries_are_the_error_at_the_middle_of_each_cell():
    rom = CorrectionRom.from_fit(lambda deg: deg / 10, lambda deg: deg / 100)
    middle_deg = (np.arange(4096) + 0.5) * 360 / 4096
    assert np.abs(rom.line_table / 16 * ARCSEC_PER_COUNT - middle_deg / 10).max() <= ARCSEC_PER_COUNT / 32 + 1e-12
    middle_deg = (np.arange(512) + 0.5) * 360 / 512
    within = rom.subdivision_table / 16 * ARCSEC_PER_COUNT
    assert np.abs(within - middle_deg / 100).max() <= ARCSEC_PER_COUNT / 32 + 1e-12


def test_without_subdivision_the_whole_count_is_the_nearest():
    sixteenths = np.linspace(-40, 40, 4096)
    rom = CorrectionRom.from_fit(lambda deg: sixteenths / 16 * ARCSEC_PER_COUNT)
    assert np.abs(rom.line_table - sixteenths).max() < 1
    assert np.abs(rom.correction(np.arange(4096) * 2048) - sixteenths / 16).max() <= 0.5


def test_published_run_is_corrected_within_0_6_counts_of_its_fit_everywhere(table_1):
    network = RadialBasisNetwork.fit(table_1)
    rom = CorrectionRom.from_fit(network.evaluate)
    # Every third count of the turn: each cell is met at its ends and hundreds of times between.
    position = np.arange(0, COUNTS_PER_TURN, 3)
    fit_counts = network.evaluate(position * 360 / COUNTS_PER_TURN) / ARCSEC_PER_COUNT
    assert np.abs(rom.correct(position) - (position - fit_counts)).max() < 0.6


@pytest.mark.parametrize("error_arcsec", [316.41, -316.5, np.nan, np.inf, 1e300])
def test_an_error_no_entry_can_hold(error_arcsec):
    def fit(deg):
        return np.where(np.arange(deg.size) == 7, error_arcsec, 0.0)

    with pytest.raises(InputError, match=r"^run\.csv: the error at 0\.659 deg of the turn is .* \+-316\.4 arcsec"):
        CorrectionRom.from_fit(fit, source="run.csv")


def test_the_largest_errors_an_entry_holds():
    rom = CorrectionRom.from_fit(lambda deg: np.where(deg < 180, 316.39, -316.39))
    assert rom.line_table.max() == 32766
    assert rom.line_table.min() == -32766


def test_correcting_ten_million_positions_is_quick():
    positions = np.arange(10_000_000)
    ROM.correct(positions[:10])
    best = min(_seconds(lambda: ROM.correct(positions)) for _ in range(3))
    # 6 ns each is usual; the bound leaves room for a busy machine.
    assert best / positions.size < 60e-9


def _seconds(work) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start
