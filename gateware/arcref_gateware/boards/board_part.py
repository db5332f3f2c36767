"""The FPGA part of a board and the names of its pins: from amaranth-boards, or stated in the file itself."""

from dataclasses import dataclass, field
from importlib import import_module

from amaranth.vendor import LatticeECP5Platform, LatticeICE40Platform

from arcref.input_error import InputError
from arcref_gateware.boards.pin_tables import Ball, package_balls

FAMILIES = {"ecp5": LatticeECP5Platform, "ice40": LatticeICE40Platform}
"""The families that arcref can be built for, and Amaranth's platform for each."""


@dataclass(frozen=True)
class Part:
    """An FPGA on a board, and the ways to name its balls.

    `balls` are those of the package, `connector_pins` maps "gpio_0:14+" to a ball, `oscillator` is (ball,
    frequency in hertz, I/O standard) where amaranth-boards states it.
    """

    family: str
    device: str
    package: str
    speed: str
    balls: dict[str, Ball]
    connector_pins: dict[str, str] = field(default_factory=dict)
    oscillator: tuple[str, float, str] | None = None


def platform_class(path: str):
    """The class at "module:class". Raises `InputError` when there is none or its family is not known here."""
    module, _, name = path.partition(":")
    try:
        found = getattr(import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(
            f"{path!r} is no platform of amaranth-boards (as amaranth_boards.ulx3s:...): {error}"
        ) from error
    if not (isinstance(found, type) and issubclass(found, tuple(FAMILIES.values()))):
        raise InputError(f"{path!r} is no platform of an ECP5 or iCE40 board")
    return found


def part_of_platform(path: str) -> Part:
    """The part, connectors and oscillator of a board of amaranth-boards."""
    platform = platform_class(path)
    family = next(name for name, base in FAMILIES.items() if issubclass(platform, base))
    if family == "ecp5" and not platform.device.startswith("LFE5"):
        raise InputError(f"{path!r} carries {platform.device}, which is no ECP5")
    balls = package_balls(platform.device, platform.package)
    connector_pins = {}
    for connector in platform.connectors:
        connector_pins.update(connector)
    return Part(
        family,
        platform.device,
        platform.package,
        getattr(platform, "speed", ""),
        balls,
        connector_pins,
        _oscillator(platform),
    )


def _oscillator(platform) -> tuple[str, float, str] | None:
    for resource in platform.resources:
        if resource.name == platform.default_clk and resource.number == 0 and resource.clock is not None:
            standard = resource.attrs.get("IO_TYPE") or resource.attrs.get("IO_STANDARD") or ""
            return resource.ios[0].names[0], resource.clock.frequency, standard
    return None


def own_part(family: str, device: str, package: str, speed: str) -> Part:
    """The part that one's own board names. Raises `InputError` for one that the tools do not know."""
    if family not in FAMILIES:
        raise InputError(f"the family {family!r} is not known; the families are {', '.join(FAMILIES)}")
    if device.startswith("LFE5") != (family == "ecp5"):
        raise InputError(f"{device!r} is no part of the family {family}")
    if family == "ecp5" and speed not in ("6", "7", "8"):
        raise InputError(f"the speed grade of an ECP5 is 6, 7 or 8, not {speed!r}")
    return Part(family, device, package, speed, package_balls(device, package))
