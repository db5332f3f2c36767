"""The identity memory: 512 words of 16 bits by which a board can say which calibration it carries.

| words    | content                                                                                           |
|----------|---------------------------------------------------------------------------------------------------|
| 0, 1     | magic, 0x4152 0x4346 ("AR", "CF")                                                                  |
| 2        | version of this layout, 1                                                                          |
| 3        | reserved, 0                                                                                        |
| 4, 5     | CRC-32 of the correction tables, low half first; the power-up check compares with it               |
| 6        | length of the text in bytes                                                                        |
| 7..509   | the text: UTF-8, `key: value` lines, two bytes a word, first byte in the low half, zeros behind it |
| 510, 511 | CRC-32 (zlib's) of words 0..509 as little-endian bytes, low half first                             |
"""

import zlib
from dataclasses import dataclass

import numpy as np

from arcref.correction_rom import CorrectionRom

IDENTITY_WORDS = 512
MAGIC = (0x4152, 0x4346)
LAYOUT_VERSION = 1
MAGIC_WORDS = (0, 1)
VERSION_WORD = 2
TABLE_CRC_WORDS = (4, 5)
TEXT_LENGTH_WORD = 6
TEXT_FIRST_WORD = 7
IDENTITY_CRC_WORDS = (510, 511)
TEXT_BYTES = 2 * (IDENTITY_CRC_WORDS[0] - TEXT_FIRST_WORD)
"""Bytes of text that the memory holds: 1006."""

_UNKNOWN = "unknown"

# Most bytes of each line's value, in the order of the lines. The method is last and takes what is left, so that
# a long one costs neither the serial number nor the date.
_VALUE_BYTES = {"serial": 256, "date": 64, "arcref": 64, "expanded uncertainty": 256, "method": TEXT_BYTES}


@dataclass(frozen=True)
class RomIdentity:
    """What an identity memory says: the CRC-32 of the tables it belongs to, and the main provenance as text."""

    table_crc32: int
    text: str

    @property
    def values(self) -> dict[str, str]:
        """The text's `key: value` lines."""
        return dict(line.split(": ", 1) for line in self.text.splitlines() if ": " in line)

    @property
    def serial(self) -> str | None:
        """Serial number of the encoder, None when it is not known."""
        serial = self.values.get("serial", _UNKNOWN)
        return None if serial == _UNKNOWN else serial


def identity_words(rom: CorrectionRom) -> np.ndarray:
    """The identity memory of `rom`, uint16[512]. Text that is too long is cut, and ends in "..." where it was."""
    text = identity_text(rom.provenance).encode()
    words = np.zeros(IDENTITY_WORDS, np.uint16)
    words[list(MAGIC_WORDS)] = MAGIC
    words[VERSION_WORD] = LAYOUT_VERSION
    words[list(TABLE_CRC_WORDS)] = _halves(rom.crc32)
    words[TEXT_LENGTH_WORD] = len(text)
    words[TEXT_FIRST_WORD : IDENTITY_CRC_WORDS[0]] = np.frombuffer(text.ljust(TEXT_BYTES, b"\0"), "<u2")
    words[list(IDENTITY_CRC_WORDS)] = _halves(_identity_crc32(words))
    return words


def decode_identity(words) -> RomIdentity:
    """Read 512 words back. Raises `ValueError`, which says what was found, unless magic, version and CRC are right."""
    words = np.asarray(words)
    if words.shape != (IDENTITY_WORDS,) or words.dtype.kind not in "iu":
        raise ValueError(f"an identity is {IDENTITY_WORDS} integers, {words.dtype} of shape {words.shape} was given")
    if words.min() < 0 or words.max() > 0xFFFF:
        raise ValueError("an identity word is not in 0 .. 65535")
    words = words.astype(np.uint16)
    found = tuple(int(word) for word in words[list(MAGIC_WORDS)])
    if found != MAGIC:
        raise ValueError(f"no identity: magic 0x{found[0]:04X} 0x{found[1]:04X}, 0x4152 0x4346 was expected")
    stored, computed = _join(words[list(IDENTITY_CRC_WORDS)]), _identity_crc32(words)
    if stored != computed:
        raise ValueError(f"the identity's CRC is 0x{stored:08X}, its words give 0x{computed:08X}")
    if words[VERSION_WORD] != LAYOUT_VERSION:
        raise ValueError(f"the identity has layout version {words[VERSION_WORD]}, {LAYOUT_VERSION} was expected")
    length = int(words[TEXT_LENGTH_WORD])
    if length > TEXT_BYTES:
        raise ValueError(f"the identity's text has {length} bytes, at most {TEXT_BYTES} fit")
    text = words[TEXT_FIRST_WORD : IDENTITY_CRC_WORDS[0]].astype("<u2").tobytes()[:length]
    try:
        return RomIdentity(_join(words[list(TABLE_CRC_WORDS)]), text.decode())
    except UnicodeDecodeError as error:
        raise ValueError(f"the identity's text is not UTF-8 at byte {error.start}") from None


def identity_text(provenance: dict) -> str:
    """The main provenance in lines: serial, date, arcref version, expanded uncertainty, method; 1006 bytes at most."""
    method = provenance.get("method")
    if isinstance(method, dict):
        method = ", ".join(f"{key} {value}" for key, value in method.items())
    expanded = provenance.get("expanded_uncertainty_arcsec")
    uncertainty = f"{expanded} arcsec (k=2)" if expanded is not None else "not stated"
    values = {
        "serial": provenance.get("encoder_serial"),
        "date": provenance.get("date"),
        "arcref": provenance.get("arcref_version"),
        "expanded uncertainty": uncertainty,
        "method": method,
    }
    text = ""
    for key, value in values.items():
        value = _UNKNOWN if value is None else " ".join(str(value).split())
        space = TEXT_BYTES - len(f"{text}{key}: \n".encode())
        text += f"{key}: {_cut(value, min(space, _VALUE_BYTES[key]))}\n"
    return text


def _cut(text: str, most_bytes: int) -> str:
    """`text` in at most `most_bytes` bytes of UTF-8, cut between characters."""
    # Half of a surrogate pair, which JSON can carry, is no UTF-8: a question mark stands for it.
    raw = text.encode(errors="replace")
    if len(raw) <= most_bytes:
        return raw.decode()
    return raw[: most_bytes - 3].decode(errors="ignore") + "..."


def _identity_crc32(words: np.ndarray) -> int:
    return zlib.crc32(words[: IDENTITY_CRC_WORDS[0]].astype("<u2").tobytes())


def _halves(value: int) -> tuple[int, int]:
    return value & 0xFFFF, value >> 16


def _join(halves) -> int:
    return int(halves[0]) | int(halves[1]) << 16
