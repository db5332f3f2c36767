"""The tables are found in, read from and written into bitstreams of every part, and the public tools agree."""

import numpy as np
import pytest
from packed_tables import DEVICES, is_ice40, pack, small_contents, unpack

from arcref_gateware.boards.bitstream import BitstreamError, board_comment
from arcref_gateware.boards.bitstream_ecp5 import Ecp5Bitstream, crc16
from arcref_gateware.boards.bitstream_ice40 import Ice40Bitstream
from arcref_gateware.boards.block_ram_geometry import ECP5_BLOCK_RAM, ICE40_BLOCK_RAM
from arcref_gateware.boards.table_layout import TableLayout, TablesNotFound, find_tables, place_tables, read_tables
from arcref_gateware.table_contents import TableContents, placeholder_contents

SMALL_DEVICES = ["1k", "LFE5U-12F"]
"""Devices that are unpacked quickly, for the tests that need no larger one."""


def random_contents(rng, like: TableContents) -> TableContents:
    return TableContents(*(rng.integers(0, 65536, len(words)).astype(np.uint16) for words in like))


def same(one: TableContents, other: TableContents) -> bool:
    return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))


@pytest.mark.parametrize("device", DEVICES)
def test_other_tables_are_written_and_the_public_unpacker_reads_them(device, rng, tmp_path):
    placeholder = small_contents(device, placeholder_contents())
    content, bitstream_class, unpacked_class = pack(tmp_path, device, rng, placeholder, board_comment("a_board"))
    bitstream = bitstream_class(content)
    assert bitstream.board == "a_board"
    assert bitstream.with_bits(bitstream.bits) == content
    layout = find_tables(bitstream, placeholder)
    assert same(read_tables(bitstream, layout), placeholder)
    unpacked = unpacked_class(unpack(tmp_path, device, content))
    unpacked_layout = find_tables(unpacked, placeholder)

    # All zeros and all ones leave nothing to find: the layout alone says where the words go.
    extremes = [
        TableContents(*(np.full(len(words), value, np.uint16) for words in placeholder)) for value in (0, 65535)
    ]
    for contents in (random_contents(rng, placeholder), *(extremes if device in SMALL_DEVICES else [])):
        bits = place_tables(bitstream, layout, contents)
        again = unpacked_class(unpack(tmp_path, device, bitstream.with_bits(bits)))
        assert same(read_tables(again, unpacked_layout), contents)
        # Nothing but the tables has changed.
        tables = np.concatenate([unpacked.column(place).ravel() for place in places(unpacked_layout)])
        others = np.ones(len(again.bits), bool)
        others[tables] = False
        assert np.array_equal(again.bits[others], unpacked.bits[others])
    assert TableLayout.from_json(layout.to_json()) == layout


def places(layout: TableLayout):
    return [place for parts in layout.places.values() for part in parts for place in part]


@pytest.fixture(scope="module", params=["8k", "LFE5U-12F"])
def packed(request, tmp_path_factory):
    """A bitstream of each family with the placeholder in it."""
    rng = np.random.default_rng(9)
    folder = tmp_path_factory.mktemp("packed")
    return request.param, *pack(folder, request.param, rng, placeholder_contents(), "nothing")[:2]


def test_a_missing_table_is_told(packed):
    _, content, bitstream_class = packed
    bitstream = bitstream_class(content)
    place = find_tables(bitstream, placeholder_contents()).places["subdivision"][0][3]
    bitstream.bits = bitstream.bits.copy()
    bitstream.bits[bitstream.column(place)[17]] ^= 1
    with pytest.raises(TablesNotFound, match="1 of .* bit 3 of subdivision 0 .. "):
        find_tables(bitstream, placeholder_contents())


def test_a_table_that_is_there_twice_is_told(packed):
    _, content, bitstream_class = packed
    bitstream = bitstream_class(content)
    layout = find_tables(bitstream, placeholder_contents())
    taken = {place[:-2] for place in places(layout)}
    free = next(block for block in bitstream.blocks if block not in taken)
    original = layout.places["line"][0][0]
    bitstream.bits = bitstream.bits.copy()
    bitstream.bits[bitstream.blocks[free]] = bitstream.bits[bitstream.blocks[original[:-2]]]
    with pytest.raises(TablesNotFound, match="two places"):
        find_tables(bitstream, placeholder_contents())


def test_a_table_of_another_length_is_refused(packed):
    _, content, bitstream_class = packed
    bitstream = bitstream_class(content)
    layout = find_tables(bitstream, placeholder_contents())
    with pytest.raises(TablesNotFound, match="line table has 2048 words, there is room for 4096"):
        place_tables(bitstream, layout, placeholder_contents()._replace(line=np.zeros(2048, np.uint16)))


@pytest.mark.parametrize(
    "value",
    [None, {}, {"line": 5}, {"line": [], "subdivision": [[[1]]], "identity": []}, {"line": [["x"]]}],
)
def test_a_layout_that_is_none_is_refused(value):
    with pytest.raises(ValueError, match="table"):
        TableLayout.from_json(value)


def test_places_that_do_not_exist_are_told(packed):
    _, content, bitstream_class = packed
    bitstream = bitstream_class(content)
    layout = find_tables(bitstream, placeholder_contents()).to_json()
    layout["line"][0][0] = [99, *layout["line"][0][0][1:]]
    with pytest.raises(TablesNotFound, match="no block RAM"):
        read_tables(bitstream, TableLayout.from_json(layout))


def test_damage_is_told(packed, rng):
    device, content, bitstream_class = packed
    with pytest.raises(BitstreamError, match="preamble"):
        bitstream_class(b"\xff\0no bitstream at all\0\xff")
    for cut in rng.integers(40, len(content) - 12, 20):
        with pytest.raises(BitstreamError):
            bitstream_class(content[:cut])
    start = len(content) - 2000 if is_ice40(device) else len(content) - 40000
    for place in rng.integers(start, len(content) - 40, 20):
        damaged = bytearray(content)
        damaged[place] ^= 1 << rng.integers(8)
        with pytest.raises(BitstreamError):
            bitstream_class(bytes(damaged))


def test_the_other_family_is_refused(packed):
    device, content, _ = packed
    with pytest.raises(BitstreamError, match="preamble"):
        (Ecp5Bitstream if is_ice40(device) else Ice40Bitstream)(content)


def test_words_share_rows_as_the_data_sheets_say():
    # ECP5, four bits wide: two words in a 9-bit row, whose ninth bit stays unused.
    rows, bits = ECP5_BLOCK_RAM.column_bits(4, 1)
    assert (list(rows[:4]), list(bits[:4])) == ([0, 0, 1, 1], [1, 5, 1, 5])
    # 18 bits wide: two rows a word.
    rows, bits = ECP5_BLOCK_RAM.column_bits(18, 11)
    assert (list(rows[:3]), list(bits[:3])) == ([1, 3, 5], [2, 2, 2])
    # iCE40, two bits wide: eight words in a row; bit 0 is data bit 0 of all of them, interleaved.
    rows, bits = ICE40_BLOCK_RAM.column_bits(2, 1)
    assert list(rows[:9]) == [0] * 8 + [1]
    assert list(bits[:8]) == [8, 12, 10, 14, 9, 13, 11, 15]
    for geometry in (ECP5_BLOCK_RAM, ICE40_BLOCK_RAM):
        for width in geometry.port_widths:
            used = {
                (row, bit)
                for column in range(geometry.columns_of(width))
                for row, bit in zip(*geometry.column_bits(width, column), strict=True)
            }
            assert len(used) == geometry.columns_of(width) * geometry.column_words
        with pytest.raises(KeyError):
            geometry.column_bits(3, 0)


def test_the_crc_of_ecp5_is_the_catalogued_one():
    assert crc16(b"123456789") == 0xFEE8  # CRC-16/UMTS
