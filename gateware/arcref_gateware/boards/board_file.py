"""Reading `constraints/BOARD.toml`: a board in one file, checked before anything is built.

A board of amaranth-boards names its platform; one's own board names family, part, package, speed and oscillator.
`constraints/ulx3s.toml` and `constraints/encoder_board.toml` show one each.
"""

import difflib
import tomllib
from pathlib import Path

from arcref.input_error import InputError
from arcref.input_file import read_input_file
from arcref.link.packet import DEFAULT_BAUD
from arcref_gateware.boards.board import UART_SIGNALS, Board
from arcref_gateware.boards.board_part import Part, own_part, part_of_platform
from arcref_gateware.boards.board_pins import read_pins
from arcref_gateware.boards.word_clock import word_clock_pll
from arcref_gateware.link.baud_rate import baud_divisor

BOARD_FOLDER = Path("constraints")
"""Where the boards' files are, seen from the folder in which arcref is used."""

_TABLES = {
    "board": {"title", "web", "amaranth_platform", "variants"},
    "fpga": {"family", "device", "package", "speed"},
    "clock": {"oscillator_hz", "oscillator_pin", "oscillator_io_standard", "word_clock_hz"},
    "samples": {"per_word"},
    "link": {"baud"},
    "pins": None,
    "flash": {"board", "cable"},
    "build": {"seeds", "synthesis_options"},
}

_SAMPLES = {"ecp5": (1, 2, 4), "ice40": (1, 2)}


def board_names(folder=BOARD_FOLDER) -> list[str]:
    """Names of the boards that have a file in `folder`, sorted."""
    return sorted(path.stem for path in Path(folder).glob("*.toml"))


def load_board(name_or_path, folder=BOARD_FOLDER) -> Board:
    """The board of this name ("ulx3s", or "ulx3s-25F" for a variant) or in this file ("my/board.toml").

    Raises `InputError`: file, key, what stands there and what was expected.
    """
    path, variant = _find(str(name_or_path), Path(folder))
    content = _read_toml(path)
    try:
        return _board(path, content, variant)
    except _Problem as problem:
        raise InputError.at(path, str(problem), column=problem.key) from problem


class _Problem(Exception):
    """What is wrong with one key of the file."""

    def __init__(self, key: str, text: str):
        super().__init__(text)
        self.key = key


def _find(name: str, folder: Path) -> tuple[Path, str | None]:
    path = Path(name)
    if path.suffix == ".toml":
        return path, None
    names = board_names(folder)
    if name in names:
        return folder / f"{name}.toml", None
    stem, _, variant = name.rpartition("-")
    if stem in names:
        return folder / f"{stem}.toml", variant
    near = difflib.get_close_matches(name, names, 1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise InputError(f"{folder}: no board {name!r} ({', '.join(names) or 'no *.toml at all'}){hint}")


def _read_toml(path: Path) -> dict:
    try:
        return tomllib.loads(read_input_file(path).text())
    except tomllib.TOMLDecodeError as error:
        raise InputError.at(path, f"is not TOML: {error}") from error


def _board(path: Path, content: dict, variant: str | None) -> Board:
    _check_keys(content)
    about, clock, samples = content.get("board", {}), content.get("clock", {}), content.get("samples", {})
    build = content.get("build", {})
    platform, suffix = _platform(about, variant)
    part = _part(content.get("fpga", {}), platform)
    per_word = _get(samples, "samples.per_word", int)
    if per_word not in _SAMPLES[part.family]:
        allowed = ", ".join(map(str, _SAMPLES[part.family]))
        raise _Problem("samples.per_word", f"is {per_word}, one of {allowed} was expected for {part.family}")
    ball, oscillator_hz, standard = _oscillator(clock, part)
    word_clock_hz = _frequency(clock, "clock.word_clock_hz")
    try:
        word_clock_pll(part.family, per_word, oscillator_hz, word_clock_hz)
    except InputError as error:
        raise _Problem("clock.word_clock_hz", str(error)) from error
    try:
        pins = read_pins(content.get("pins", {}), part, per_word, ball)
    except InputError as error:
        raise _Problem("pins", str(error)) from error
    baud = _baud(content.get("link", {}), pins, word_clock_hz)
    return Board(
        name=path.stem + suffix,
        title=_get(about, "board.title", str),
        web=_get(about, "board.web", str, ""),
        family=part.family,
        device=part.device,
        package=part.package,
        speed=part.speed,
        samples_per_word=per_word,
        oscillator_hz=oscillator_hz,
        oscillator_ball=ball,
        oscillator_io_standard=standard,
        word_clock_hz=word_clock_hz,
        pins=pins,
        amaranth_platform=platform,
        flash={key: _get(content["flash"], f"flash.{key}", str) for key in content.get("flash", {})},
        seeds=_seeds(build),
        synthesis_options=_strings(build, "build.synthesis_options"),
        baud=baud,
    )


def _check_keys(content: dict) -> None:
    for table, entries in content.items():
        if table not in _TABLES:
            raise _Problem(table, f"is not known{_near(table, _TABLES)}")
        if not isinstance(entries, dict):
            raise _Problem(table, f"is {entries!r}, a table [{table}] was expected")
        for key in entries:
            if _TABLES[table] is not None and key not in _TABLES[table]:
                raise _Problem(f"{table}.{key}", f"is not known{_near(key, _TABLES[table])}")


def _near(key: str, known) -> str:
    near = difflib.get_close_matches(key, known, 1)
    return f"; did you mean {near[0]!r}?" if near else f"; known are {', '.join(sorted(known))}"


def _get(table: dict, path: str, kind, default=None):
    key = path.rpartition(".")[2]
    value = table.get(key, default)
    names = {str: "a string", int: "a whole number", list: "a list"}
    if value is None:
        raise _Problem(path, f"is missing, {names[kind]} was expected")
    if type(value) is not kind:
        raise _Problem(path, f"is {value!r}, {names[kind]} was expected")
    return value


def _frequency(table: dict, path: str) -> float:
    value = table.get(path.rpartition(".")[2])
    if value is None:
        raise _Problem(path, "is missing, a frequency in hertz was expected")
    if type(value) not in (int, float) or not 0 < value < 1e12:
        raise _Problem(path, f"is {value!r}, a frequency in hertz was expected")
    return float(value)


def _platform(about: dict, variant: str | None) -> tuple[str | None, str]:
    """The platform's "module:class" and what the variant adds to the board's name."""
    variants = _strings(about, "board.variants")
    if "amaranth_platform" not in about:
        if variants or variant is not None:
            raise _Problem("board.variants", "has no meaning without board.amaranth_platform")
        return None, ""
    platform = _get(about, "board.amaranth_platform", str)
    if ("{variant}" in platform) != bool(variants):
        raise _Problem("board.variants", "and '{variant}' in board.amaranth_platform go together")
    if variant is not None and variant not in variants:
        expected = f"one of {', '.join(variants)} was expected" if variants else "this board has none"
        raise _Problem("board.variants", f"has no {variant!r}, {expected}")
    chosen = variant or (variants[0] if variants else "")
    suffix = f"-{chosen}" if variants and chosen != variants[0] else ""
    return platform.replace("{variant}", chosen), suffix


def _part(stated: dict, platform: str | None) -> Part:
    try:
        if platform is not None:
            part = part_of_platform(platform)
        else:
            speed = _get(stated, "fpga.speed", str, "") if stated.get("family") == "ice40" else None
            part = own_part(
                _get(stated, "fpga.family", str),
                _get(stated, "fpga.device", str),
                _get(stated, "fpga.package", str),
                _get(stated, "fpga.speed", str) if speed is None else speed,
            )
    except InputError as error:
        raise _Problem("fpga" if platform is None else "board.amaranth_platform", str(error)) from error
    for key, value in stated.items():
        if value != getattr(part, key):
            raise _Problem(f"fpga.{key}", f"is {value!r}, but {platform} carries {getattr(part, key)!r}")
    return part


def _oscillator(clock: dict, part: Part) -> tuple[str, float, str]:
    """Ball, frequency in hertz and I/O standard of the oscillator."""
    own = [key for key in ("oscillator_pin", "oscillator_hz", "oscillator_io_standard") if key in clock]
    if part.oscillator is not None:
        if own:
            raise _Problem(f"clock.{own[0]}", "is stated by amaranth-boards already; leave it out")
        return part.oscillator
    ball = _get(clock, "clock.oscillator_pin", str)
    if ball not in part.balls:
        raise _Problem("clock.oscillator_pin", f"is {ball!r}, which the package {part.package} lacks")
    return ball, _frequency(clock, "clock.oscillator_hz"), _get(clock, "clock.oscillator_io_standard", str)


def _baud(link: dict, pins, word_clock_hz: float) -> float:
    """Baud rate of the UART, which the word clock must give. What only a whole link has is refused without one."""
    wired = [signal for signal in UART_SIGNALS if signal in pins]
    if len(wired) == 1:
        missing = next(signal for signal in UART_SIGNALS if signal not in pins)
        raise _Problem("pins", f"{missing} missing: {wired[0]} is there, and the serial link needs both")
    if not wired:
        if "compare" in pins:
            raise _Problem("pins", "compare needs the serial link, by which it is set: wire uart_rx and uart_tx, too")
        if link:
            raise _Problem("link", "has no meaning without the pins uart_rx and uart_tx")
        return DEFAULT_BAUD
    baud = link.get("baud", DEFAULT_BAUD)
    if type(baud) not in (int, float) or not 0 < baud < 1e9:
        raise _Problem("link.baud", f"is {baud!r}, a baud rate was expected")
    try:
        baud_divisor(word_clock_hz, baud)
    except ValueError as error:
        raise _Problem("link.baud", str(error)) from error
    return float(baud)


def _strings(table: dict, path: str) -> tuple[str, ...]:
    values = _get(table, path, list, [])
    if any(type(value) is not str for value in values):
        raise _Problem(path, f"is {values!r}, a list of strings was expected")
    return tuple(values)


def _seeds(build: dict) -> tuple[int, ...]:
    seeds = _get(build, "build.seeds", list, list(range(1, 9)))
    if not seeds or any(type(seed) is not int or seed < 1 for seed in seeds):
        raise _Problem("build.seeds", f"is {seeds!r}, a list of whole numbers from 1 was expected")
    return tuple(seeds)
