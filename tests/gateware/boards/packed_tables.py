"""Bitstreams with tables in them, made without place and route: the packers take a text of block RAM contents alone."""

import subprocess
import sysconfig
from pathlib import Path

import numpy as np

from arcref_gateware.boards.bitstream_ecp5 import Ecp5Bitstream
from arcref_gateware.boards.bitstream_ice40 import Ice40Bitstream
from arcref_gateware.boards.block_ram_geometry import ECP5_BLOCK_RAM, ICE40_BLOCK_RAM, BlockRamGeometry
from arcref_gateware.boards.unpacked_configuration import Ecp5Unpacked, Ice40Unpacked
from arcref_gateware.table_contents import TableContents

ICE40_DEVICES = {"1k": (3, 10), "5k": (6, 19), "8k": (8, 25)}
"""Device, and its columns of block RAM tiles."""

ECP5_DEVICES = ["LFE5U-12F", "LFE5U-25F", "LFE5U-45F", "LFE5U-85F"]

DEVICES = [*ICE40_DEVICES, *ECP5_DEVICES]

LARGEST_ICE40 = {"1k": 16, "5k": 30, "8k": 32}
"""Block RAMs of a device."""


BUILT_BOARDS = {"hx8k": ("8k", "ice40", "arcref.bin"), "ulx3s-12F": ("LFE5U-12F", "ecp5", "arcref.bit")}
"""Boards in the tests of built bitstreams: device as the packers name it, family, and name of the bitstream."""


def run(folder: Path, tool: str, *arguments: str) -> subprocess.CompletedProcess:
    """Run a tool in `folder`."""
    script = Path(sysconfig.get_path("scripts")) / f"yowasp-{tool}"
    return subprocess.run([script, *arguments], cwd=folder, capture_output=True, text=True)


def is_ice40(device: str) -> bool:
    """Whether a device of `DEVICES` is an iCE40."""
    return device in ICE40_DEVICES


def small_contents(device: str, contents: TableContents) -> TableContents:
    """`contents`, with a line table short enough for the smallest device."""
    return contents._replace(line=contents.line[:1024]) if device == "1k" else contents


def spread(rng, geometry: BlockRamGeometry, contents: TableContents, rams: int) -> np.ndarray:
    """Storage of `rams` block RAMs, uint8[rams, rows, bits of a row], with the tables in it at random places."""
    storage = rng.integers(0, 2, (rams, geometry.rows, geometry.row_bits), np.uint8)
    order = list(rng.permutation(rams))
    for words in contents:
        # As wide as the depth allows, as synthesis does it, and several deep where that is not enough.
        deep_enough = [width for width in geometry.port_widths if _depth(geometry, width) >= len(words)]
        width = max(deep_enough, default=min(geometry.port_widths))
        run_length = min(_depth(geometry, width), len(words))
        for start in range(0, len(words), run_length):
            free = []
            for bit in range(16):
                if not free:
                    ram = order.pop()
                    free = [(ram, int(column)) for column in rng.permutation(width)]
                ram, data_bit = free.pop()
                for part in range(run_length // geometry.column_words):
                    rows, bits = geometry.column_bits(width, part * width + data_bit)
                    first = start + part * geometry.column_words
                    storage[ram, rows, bits] = words[first : first + geometry.column_words] >> bit & 1
    return storage


def _depth(geometry: BlockRamGeometry, width: int) -> int:
    return geometry.columns_of(width) // width * geometry.column_words


def pack(folder: Path, device: str, rng, contents: TableContents, comment: str):
    """A bitstream with `contents`: its bytes, the class that reads it, and the class that reads it unpacked."""
    if is_ice40(device):
        rams = LARGEST_ICE40[device]
        tiles = [(x, y) for x in ICE40_DEVICES[device] for y in range(1, 2 * rams // 2 + 1, 2)][:rams]
        storage = spread(rng, ICE40_BLOCK_RAM, contents, len(tiles))
        text = f".comment\n{comment}\n.device {device}\n"
        for (x, y), rows in zip(tiles, storage, strict=True):
            text += f".ram_data {x} {y}\n"
            for line in rows.reshape(16, 256):
                text += f"{sum(int(bit) << place for place, bit in enumerate(line)):064x}\n"
        (folder / "in.asc").write_text(text)
        packed = run(folder, "icepack", "in.asc", "packed.bin")
        assert packed.returncode == 0, packed.stderr
        return (folder / "packed.bin").read_bytes(), Ice40Bitstream, Ice40Unpacked
    storage = spread(rng, ECP5_BLOCK_RAM, contents, 20)
    text = f".device {device}\n\n.comment {comment}\n\n"
    for number, rows in enumerate(storage):
        words = [f"{sum(int(bit) << place for place, bit in enumerate(row)):03x}" for row in rows]
        text += f".bram_init {number}\n" + "\n".join(" ".join(words[at : at + 8]) for at in range(0, 2048, 8)) + "\n\n"
    (folder / "in.config").write_text(text)
    packed = run(folder, "ecppack", "--input", "in.config", "--bit", "packed.bin")
    assert packed.returncode == 0, packed.stderr
    return (folder / "packed.bin").read_bytes(), Ecp5Bitstream, Ecp5Unpacked


def unpack(folder: Path, device: str, content: bytes) -> str:
    """What the public tool unpacks `content` into."""
    (folder / "again.bin").write_bytes(content)
    if is_ice40(device):
        done = run(folder, "iceunpack", "again.bin", "again.txt")
    else:
        done = run(folder, "ecpunpack", "--input", "again.bin", "--textcfg", "again.txt")
    assert done.returncode == 0, done.stderr
    return (folder / "again.txt").read_text()
