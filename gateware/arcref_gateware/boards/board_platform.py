"""Amaranth's platform for a board: its part and connectors, and one resource for each signal of the instrument."""

from amaranth.build import Attrs, Clock, DiffPairs, DiffPairsN, Pins, PinsN, Resource

from arcref_gateware.boards.board import Board, BoardPin
from arcref_gateware.boards.board_part import FAMILIES, platform_class

RESOURCE_PREFIX = "arcref_"
"""Before the name of a signal stands this in the names of resources and ports."""


def board_platform(board: Board):
    """A new platform for `board`, with a resource `arcref_SIGNAL` for every signal it wires."""
    if board.amaranth_platform is not None:
        platform = platform_class(board.amaranth_platform)()
    else:
        platform = _own_platform(board)()
    platform.add_resources([_resource(pin, board.family) for pin in board.pins.values()])
    return platform


def port(platform, signal: str):
    """The port of a signal, without a buffer. Each can be had once."""
    return platform.request(RESOURCE_PREFIX + signal, 0, dir="-")


def _own_platform(board: Board):
    oscillator = Resource(
        "oscillator",
        0,
        Pins(board.oscillator_ball, dir="i"),
        Clock(board.oscillator_hz),
        Attrs(**{_STANDARD_KEY[board.family]: board.oscillator_io_standard}),
    )
    return type(
        "OwnPlatform",
        (FAMILIES[board.family],),
        {
            "device": board.device,
            "package": board.package,
            "speed": board.speed,
            "default_clk": "oscillator",
            "resources": [oscillator],
            "connectors": [],
        },
    )


_STANDARD_KEY = {"ecp5": "IO_TYPE", "ice40": "IO_STANDARD"}


def _resource(pin: BoardPin, family: str) -> Resource:
    direction = pin.direction
    if pin.differential:
        pins = (DiffPairsN if pin.inverted else DiffPairs)(*pin.balls, dir=direction)
    else:
        pins = (PinsN if pin.inverted else Pins)(pin.balls[0], dir=direction)
    return Resource(RESOURCE_PREFIX + pin.signal, 0, pins, Attrs(**_attributes(pin, family)))


def _attributes(pin: BoardPin, family: str) -> dict:
    attributes = {_STANDARD_KEY[family]: pin.io_standard}
    if family == "ecp5":
        attributes["PULLMODE"] = pin.pull.upper()
        if pin.termination_ohm is not None:
            attributes["DIFFRESISTOR"] = str(pin.termination_ohm)
    elif pin.pull == "up":
        attributes["PULLUP"] = 1
    return attributes
