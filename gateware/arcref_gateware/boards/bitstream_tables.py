"""The tables inside a bitstream file: located once after place and route, then read and replaced.

What is replaced is checked by the family's public unpacker, which shares nothing with the code that wrote it: every
word of all three tables is compared, and that no other bit of a block RAM has changed.
"""

import hashlib
import json
import tempfile
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.correction_rom import CorrectionRom
from arcref.rom_identity import RomIdentity, decode_identity
from arcref_gateware.boards.bitstream import Bitstream, BitstreamError, OtherFormatError
from arcref_gateware.boards.bitstream_ecp5 import Ecp5Bitstream
from arcref_gateware.boards.bitstream_ice40 import Ice40Bitstream
from arcref_gateware.boards.block_ram_image import BlockRamImage
from arcref_gateware.boards.table_layout import TableLayout, find_tables, place_tables, read_tables
from arcref_gateware.boards.unpacked_configuration import Ecp5Unpacked, Ice40Unpacked
from arcref_gateware.table_contents import TableContents, placeholder_contents
from arcref_gateware.toolchain import run_tool

BITSTREAMS = {"ice40": Ice40Bitstream, "ecp5": Ecp5Bitstream}
UNPACKED = {"ice40": Ice40Unpacked, "ecp5": Ecp5Unpacked}


class TablesDiffer(RuntimeError):
    """An unpacked bitstream does not hold what was written; the text says where."""


@dataclass(frozen=True)
class BitstreamLayout:
    """Where the tables of one placed design are, in its file and in what the public tool unpacks it into."""

    family: str
    in_file: TableLayout
    unpacked: TableLayout

    def to_json(self) -> dict:
        """For the build record."""
        return {"family": self.family, "in_file": self.in_file.to_json(), "unpacked": self.unpacked.to_json()}

    @classmethod
    def from_json(cls, value) -> "BitstreamLayout":
        """The layout that `to_json` gave. Raises `ValueError` for anything else."""
        if not isinstance(value, dict) or value.get("family") not in BITSTREAMS:
            raise ValueError("the places of the tables cannot be read: no known family")
        layouts = TableLayout.from_json(value.get("in_file")), TableLayout.from_json(value.get("unpacked"))
        return cls(value["family"], *layouts)

    def sha256(self, bitstream: Bitstream) -> str:
        """What tells this layout from every other: a hash of the places, and of the bitstream but for its tables.

        It is the same whatever ROM the bitstream carries.
        """
        blank = TableContents(*(np.zeros(len(words), np.uint16) for words in read_tables(bitstream, self.in_file)))
        content = bitstream.with_bits(place_tables(bitstream, self.in_file, blank))
        places = json.dumps(self.to_json(), sort_keys=True)
        return hashlib.sha256(content[bitstream.configuration_start :] + places.encode()).hexdigest()


def read_bitstream(content: bytes) -> Bitstream:
    """The bitstream of either family in `content`. Raises `BitstreamError` when it is none."""
    for bitstream_class in BITSTREAMS.values():
        with suppress(OtherFormatError):
            return bitstream_class(content)
    raise BitstreamError("no bitstream of an iCE40 or ECP5")


def locate_tables(bitstream: Bitstream, family: str) -> BitstreamLayout:
    """Where the placeholder contents lie. Raises `TablesNotFound`."""
    placeholder = placeholder_contents()
    in_file = find_tables(bitstream, placeholder)
    return BitstreamLayout(family, in_file, find_tables(unpack(bitstream.content, family), placeholder))


def replace_tables(bitstream: Bitstream, layout: BitstreamLayout, contents: TableContents) -> bytes:
    """The file with other tables, unpacked again and compared word by word.

    Raises `TablesNotFound` when they do not fit, `TablesDiffer` when what was unpacked is something else.
    """
    bits = place_tables(bitstream, layout.in_file, contents)
    result = BITSTREAMS[layout.family](bitstream.with_bits(bits))
    compare_tables(unpack(result.block_rams_only(), layout.family), layout.unpacked, contents)
    return result.content


def compare_tables(image: BlockRamImage, layout: TableLayout, contents: TableContents) -> None:
    """Compare every word. Raises `TablesDiffer` for the first that differs."""
    found = read_tables(image, layout)
    for memory, words in contents._asdict().items():
        there = getattr(found, memory)
        wrong = np.flatnonzero(there != words)
        if len(wrong):
            first = int(wrong[0])
            raise TablesDiffer(
                f"{len(wrong)} of {len(words)} words of the {memory} table came out wrong, the first at {first}: "
                f"0x{there[first]:04X} in place of 0x{int(words[first]):04X}"
            )


def unpack(content: bytes, family: str) -> BlockRamImage:
    """What the public tool makes of a bitstream. Raises `ToolError` when it refuses it."""
    with tempfile.TemporaryDirectory(prefix="arcref-") as folder:
        folder = Path(folder)
        (folder / "packed").write_bytes(content)
        if family == "ice40":
            run_tool("iceunpack", ["packed", "unpacked"], folder)
        else:
            run_tool("ecpunpack", ["--input", "packed", "--textcfg", "unpacked"], folder)
        return UNPACKED[family]((folder / "unpacked").read_text())


def rom_of(contents: TableContents) -> tuple[int, RomIdentity]:
    """CRC-32 of the tables, and what the identity says. Raises `ValueError` when they are no ROM that belongs together.

    The power-up check of the gateware comes to the same verdict.
    """
    identity = decode_identity(contents.identity)
    rom = CorrectionRom(contents.line.view(np.int16), contents.subdivision.view(np.int16))
    if identity.table_crc32 != rom.crc32:
        raise ValueError(f"the tables' CRC is 0x{rom.crc32:08X}, their identity says 0x{identity.table_crc32:08X}")
    return rom.crc32, identity


def is_placeholder(contents: TableContents) -> bool:
    """Whether these are the words that a design is placed and routed with."""
    return all(np.array_equal(one, other) for one, other in zip(contents, placeholder_contents(), strict=True))
