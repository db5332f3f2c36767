import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from arcref.correction_rom import CorrectionRom
from arcref.rom_identity import TABLE_CRC_WORDS, TEXT_BYTES, decode_identity, identity_words

TABLE = np.arange(-2048, 2048)

PROVENANCE = {
    "encoder_serial": "AR-0007 Prüfling",
    "date": "2024-05-17",
    "method": {"name": "wrapped RBF network", "faces": 24},
    "expanded_uncertainty_arcsec": 0.52,
    "arcref_version": "0.1.0",
}


def rom_of(provenance) -> CorrectionRom:
    return CorrectionRom(TABLE, provenance=provenance)


def resealed(words, index, value):
    """The words with one changed and the CRC made right again."""
    words = words.copy()
    words[index] = value
    crc = zlib.crc32(words[:510].astype("<u2").tobytes())
    words[510:] = crc & 0xFFFF, crc >> 16
    return words


def test_layout():
    rom = rom_of(PROVENANCE)
    words = identity_words(rom)
    assert words.dtype == np.uint16
    assert words.shape == (512,)
    assert words[:4].tolist() == [0x4152, 0x4346, 1, 0]
    assert TABLE_CRC_WORDS == (4, 5)
    assert int(words[4]) | int(words[5]) << 16 == rom.crc32
    raw = words.astype("<u2").tobytes()
    text = raw[14 : 14 + int(words[6])].decode()
    assert text.splitlines()[0] == "serial: AR-0007 Prüfling"
    assert not any(raw[14 + int(words[6]) : 1020])
    assert int(words[510]) | int(words[511]) << 16 == zlib.crc32(raw[:1020])


def test_round_trip():
    rom = rom_of(PROVENANCE)
    identity = decode_identity(identity_words(rom))
    assert identity.table_crc32 == rom.crc32
    assert identity.values == {
        "serial": "AR-0007 Prüfling",
        "date": "2024-05-17",
        "arcref": "0.1.0",
        "expanded uncertainty": "0.52 arcsec (k=2)",
        "method": "name wrapped RBF network, faces 24",
    }


def test_what_is_not_known_is_said_to_be_so():
    values = decode_identity(identity_words(rom_of({}))).values
    assert values["serial"] == values["date"] == "unknown"
    assert values["expanded uncertainty"] == "not stated"


long_text = st.text(max_size=40).map(lambda text: text * 40)
anything = st.none() | long_text | st.integers() | st.floats() | st.lists(st.text(max_size=20), max_size=4)


@given(st.fixed_dictionaries({}, optional=dict.fromkeys(PROVENANCE, anything)))
def test_any_provenance_fits_and_comes_back(provenance):
    words = identity_words(rom_of(provenance))
    identity = decode_identity(words)
    assert len(identity.text.encode()) <= TEXT_BYTES
    assert list(identity.values) == ["serial", "date", "arcref", "expanded uncertainty", "method"]


def test_a_long_method_costs_neither_serial_nor_date():
    values = decode_identity(identity_words(rom_of(PROVENANCE | {"method": "ü" * 5000}))).values
    assert values["serial"] == "AR-0007 Prüfling"
    assert values["date"] == "2024-05-17"
    assert values["method"].endswith("ü...")


def test_a_long_serial_is_cut_between_characters_and_keeps_the_date():
    values = decode_identity(identity_words(rom_of(PROVENANCE | {"encoder_serial": "漢" * 3000}))).values
    assert values["serial"].strip("漢") == "..."
    assert values["date"] == "2024-05-17"


@pytest.mark.parametrize("index", [0, 2, 4, 6, 100, 509, 510, 511])
def test_a_changed_word_is_found(index):
    words = identity_words(rom_of(PROVENANCE))
    words[index] ^= 0x0100
    with pytest.raises(ValueError, match="magic" if index == 0 else "CRC"):
        decode_identity(words)


@pytest.mark.parametrize(
    ("index", "value", "message"),
    [(2, 2, "layout version 2, 1 was expected"), (6, 1007, "1007 bytes, at most 1006"), (7, 0xFFFF, "UTF-8 at byte 0")],
)
def test_wrong_content_under_a_right_crc(index, value, message):
    with pytest.raises(ValueError, match=message):
        decode_identity(resealed(identity_words(rom_of(PROVENANCE)), index, value))


@pytest.mark.parametrize("words", [np.zeros(511, int), np.zeros(512), np.full(512, 65536), np.zeros((2, 256), int)])
def test_no_identity_at_all(words):
    with pytest.raises(ValueError, match="identity"):
        decode_identity(words)


def test_an_empty_memory():
    with pytest.raises(ValueError, match="magic 0x0000 0x0000, 0x4152 0x4346 was expected"):
        decode_identity(np.zeros(512, int))
