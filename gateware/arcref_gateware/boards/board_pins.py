"""The pins of a board: names to balls, and everything that cannot work said before it is built."""

import difflib

from arcref.input_error import InputError
from arcref_gateware.boards.board import (
    ALIGNMENT,
    OPTIONAL_SIGNALS,
    SAMPLED_SIGNALS,
    SIGNAL_DIRECTIONS,
    BoardPin,
)
from arcref_gateware.boards.board_part import Part
from arcref_gateware.boards.pin_tables import Ball

IO_STANDARDS = {
    "ecp5": {"LVCMOS33", "LVCMOS25", "LVCMOS18", "LVCMOS15", "LVCMOS12", "LVTTL33"},
    "ice40": {"SB_LVCMOS", "SB_LVTTL"},
}
PAIR_IO_STANDARDS = {
    "ecp5": {"LVDS", "LVCMOS33D", "LVCMOS25D", "LVPECL33"},
    "ice40": {"SB_LVDS_INPUT"},
}
PULLS = {"ecp5": ("none", "up", "down"), "ice40": ("none", "up")}

GEARING_SIDES = ({2, 3}, {6, 7})
"""Banks of the ECP5's right and left side. Only these have gearing and edge clocks (FPGA-TN-02035, chapter 3)."""

_KEYS = {"pin", "pair", "io_standard", "pull", "inverted", "termination_ohm", "label"}


def read_pins(table: dict, part: Part, samples_per_word: int, oscillator_ball: str) -> dict[str, BoardPin]:
    """The pins of `[pins]`, in the order of `SIGNAL_DIRECTIONS`. Raises `InputError` without the file's name."""
    for signal in table:
        if signal not in SIGNAL_DIRECTIONS:
            near = difflib.get_close_matches(signal, SIGNAL_DIRECTIONS, 1)
            hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(SIGNAL_DIRECTIONS)}"
            raise InputError(f"{signal} is no signal of the instrument; {hint}")
    needless = OPTIONAL_SIGNALS | ({ALIGNMENT} if samples_per_word == 1 else set())
    missing = [signal for signal in SIGNAL_DIRECTIONS if signal not in table and signal not in needless]
    if missing:
        why = " (a ball with nothing wired to it, for the check of the sample order)" if missing == [ALIGNMENT] else ""
        raise InputError(f"{', '.join(missing)} missing{why}")
    pins = {signal: _pin(signal, table[signal], part) for signal in SIGNAL_DIRECTIONS if signal in table}
    _check_balls_once(pins, oscillator_ball)
    if samples_per_word == 4:
        _check_gearing(pins, part.balls)
    return pins


def _pin(signal: str, entry, part: Part) -> BoardPin:
    if not isinstance(entry, dict):
        raise InputError(f'{signal} is {entry!r}, a table like {{ pin = "U18", io_standard = "..." }} was expected')
    for key in entry:
        if key not in _KEYS:
            near = difflib.get_close_matches(key, _KEYS, 1)
            raise InputError(f"{signal}.{key} is not known; did you mean {near[0] if near else sorted(_KEYS)}?")
    names = _names(signal, entry)
    balls = tuple(_ball(signal, name, part) for name in names)
    pair = len(names) == 2
    standards = (PAIR_IO_STANDARDS if pair else IO_STANDARDS)[part.family]
    standard = entry.get("io_standard")
    if standard not in standards:
        of = "a pair" if pair else "one ball"
        raise InputError(
            f"{signal}.io_standard is {standard!r}, one of {', '.join(sorted(standards))} was expected for {of}"
        )
    pull = entry.get("pull", "none")
    if pull not in PULLS[part.family]:
        raise InputError(
            f"{signal}.pull is {pull!r}, one of {', '.join(PULLS[part.family])} was expected for {part.family}"
        )
    inverted, label = entry.get("inverted", False), entry.get("label", "")
    if type(inverted) is not bool:
        raise InputError(f"{signal}.inverted is {inverted!r}, true or false was expected")
    if type(label) is not str:
        raise InputError(f"{signal}.label is {label!r}, a string was expected")
    if pair:
        _check_pair(signal, balls, part)
    pin = BoardPin(signal, names, balls, standard, pull, inverted, _termination(signal, entry, part, pair), label)
    if pair and pin.direction != "i":
        raise InputError(f"{signal} is an output; a pair is for inputs only")
    return pin


def _names(signal: str, entry: dict) -> tuple[str, ...]:
    if ("pin" in entry) == ("pair" in entry):
        raise InputError(f"{signal} needs either pin (one ball) or pair (two balls, the positive one first)")
    names = (entry["pin"],) if "pin" in entry else entry["pair"]
    if not isinstance(names, (list, tuple)) or any(type(name) is not str for name in names):
        raise InputError(f"{signal} is {entry!r}, names of pins in quotation marks were expected")
    if "pair" in entry and len(names) != 2:
        raise InputError(f"{signal}.pair has {len(names)} names, two were expected, the positive one first")
    return tuple(names)


def _ball(signal: str, name: str, part: Part) -> str:
    """The ball of a pin, through as many connectors as it is wired."""
    ball = name
    while ball in part.connector_pins:
        ball = part.connector_pins[ball]
    if ball in part.balls:
        return ball
    if ":" not in name:
        raise InputError(f"{signal} is on {name!r}, which the package {part.package} of {part.device} lacks")
    near = difflib.get_close_matches(name, part.connector_pins, 3)
    hint = f"; did you mean {' or '.join(near)}?" if near else ""
    raise InputError(f"{signal} is on {name!r}, which the board lacks{hint}")


def _termination(signal: str, entry: dict, part: Part, pair: bool) -> int | None:
    ohm = entry.get("termination_ohm")
    if ohm is None:
        return None
    if part.family != "ecp5" or not pair or ohm != 100:
        raise InputError(f"{signal}.termination_ohm is {ohm!r}; only a pair of an ECP5 has one, and it is 100")
    return ohm


def _check_pair(signal: str, balls: tuple[str, ...], part: Part) -> None:
    positive, negative = (part.balls[ball] for ball in balls)
    same_place = (positive.column, positive.row) == (negative.column, negative.row)
    if part.family == "ecp5":
        good = same_place and positive.site + negative.site in ("AB", "CD")
        partners = {"A": "B", "C": "D"}
        partner = partners.get(positive.site)
    else:
        # SB_IO takes a pair through site 0; on LP and HX parts only the left side (bank 3) has the comparators.
        good = same_place and positive.site + negative.site == "01"
        if good and not part.device.startswith("iCE40UP") and positive.column != 0:
            raise InputError(f"{signal} is a pair outside of bank 3, the only one of {part.device} with such inputs")
        partner = "1" if positive.site == "0" else None
    if not good:
        fits = [ball.name for ball in part.balls.values() if _partners(positive, ball, partner)]
        hint = (
            f"; the other ball of {positive.name} is {fits[0]}" if fits else f"; {positive.name} can be no positive one"
        )
        raise InputError(f"{signal}: {balls[0]} and {balls[1]} are no pair{hint}")


def _partners(positive: Ball, ball: Ball, site: str | None) -> bool:
    return (ball.column, ball.row, ball.site) == (positive.column, positive.row, site)


def _check_balls_once(pins: dict[str, BoardPin], oscillator_ball: str) -> None:
    owner = {oscillator_ball: "the oscillator"}
    for signal, pin in pins.items():
        for ball, name in zip(pin.balls, pin.names, strict=True):
            if ball in owner:
                raise InputError(f"{signal} is on {name!r} (ball {ball}), which {owner[ball]} has already")
            owner[ball] = signal


def _check_gearing(pins: dict[str, BoardPin], balls: dict[str, Ball]) -> None:
    sides = {}
    for signal in (*SAMPLED_SIGNALS, ALIGNMENT):
        pin = pins[signal]
        ball = balls[pin.balls[0]]
        side = next((number for number, banks in enumerate(GEARING_SIDES) if ball.bank in banks), None)
        if side is None:
            raise InputError(
                f"{signal} is on {pin.names[0]!r}, in bank {ball.bank}: "
                "four samples a word need bank 2 or 3 (right side) or 6 or 7 (left side)"
            )
        sides.setdefault(side, signal)
    if len(sides) > 1:
        raise InputError(
            f"{' and '.join(sides.values())} are on different sides: all sampled lines must share one edge clock, "
            "so put them all in banks 2 and 3 or all in banks 6 and 7"
        )
