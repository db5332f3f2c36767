"""What can be typed at the twin's prompt."""

from collections.abc import Callable

from arcref.angle import COUNTS_PER_TURN, counts_to_deg, format_dms
from arcref.flags import describe_faults
from arcref.position_frame import FrameError, PositionFrame
from arcref_sim.spi_plan import SpiPlan
from arcref_sim.twin.live_faults import NAMED_FAULTS, add_fault
from arcref_sim.twin.twin import Twin, TwinStatus

FASTEST_RPS = 200.0


class Quit(Exception):
    """The line asks the twin to end."""


def obey(twin: Twin, line: str) -> str:
    """Carry out one line and give the answer. Raises ValueError, which says what was expected, and `Quit`."""
    words = line.split()
    if not words:
        return ""
    command = COMMANDS.get(words[0].lower())
    if command is None:
        raise ValueError(f"there is no {words[0]!r}; `help` lists what there is")
    return command[1](twin, words[1:])


def _speed(twin: Twin, words: list[str]) -> str:
    speed, acceleration = _numbers(words, "speed RPS [RPS_PER_S]", least=1, most=2)
    return _set_speed(twin, speed, acceleration)


def _reverse(twin: Twin, words: list[str]) -> str:
    (acceleration,) = _numbers(words, "reverse [RPS_PER_S]", least=0, most=1)
    return _set_speed(twin, -twin.encoder.motion.target_rps, acceleration)


def _set_speed(twin: Twin, speed: float, acceleration: float | None) -> str:
    if abs(speed) > FASTEST_RPS:
        raise ValueError(f"{speed:g} r/s: it must lie in {-FASTEST_RPS:g} .. {FASTEST_RPS:g}")
    if acceleration is not None and acceleration <= 0:
        raise ValueError(f"{acceleration:g} r/s2: the acceleration must be above 0")
    twin.set_speed(speed, acceleration)
    return f"speed {speed:g} r/s" + (f", at {acceleration:g} r/s2" if acceleration else "")


def _strobe(twin: Twin, words: list[str]) -> str:
    is_random = bool(words) and words[-1] == "random"
    (rate,) = _numbers(words[:-1] if is_random else words, "strobe HZ [random]", least=1, most=1)
    twin.set_strobe(rate, is_random=is_random)
    return f"{rate:g} strobes/s" + (", at random" if is_random else "") if rate else "no strobes"


def _burst(twin: Twin, words: list[str]) -> str:
    number, spacing = _numbers(words, "burst N [SAMPLES_APART]", least=1, most=2)
    twin.burst(int(number), None if spacing is None else int(spacing))
    return f"a burst of {number:g} strobes"


def _fault(twin: Twin, words: list[str]) -> str:
    if not words or len(words) > 2 or words[0] not in NAMED_FAULTS:
        lines = [f"  {name:14} {fault.meaning}; {fault.default} unless given" for name, fault in NAMED_FAULTS.items()]
        raise ValueError("\n".join(["fault NAME [N] expected:", *lines]))
    (number,) = _numbers(words[1:], "fault NAME [N]", least=0, most=1)
    if number is not None and number != int(number):
        raise ValueError(f"{number:g}: a whole number was expected")
    twin.call(add_fault, twin.encoder, words[0], None if number is None else int(number))
    return f"fault {words[0]}: {NAMED_FAULTS[words[0]].meaning}"


def _spi(twin: Twin, words: list[str]) -> str:
    data = twin.read_spi(SpiPlan.back_to_back(1))[0]["data"].tobytes()
    try:
        frame = PositionFrame.decode(data)
    except FrameError as error:
        return str(error)
    return f"{data.hex()}: angle {frame.angle}, turn {frame.turns}, homed {frame.homed}, flags {int(frame.flags):#04x}"


def _status(twin: Twin, words: list[str]) -> str:
    return describe_status(twin.status())


def describe_status(status: TwinStatus) -> str:
    """A status in a few lines."""
    true_deg = counts_to_deg(status.true_counts % COUNTS_PER_TURN)
    lines = [
        f"time       {status.time_s:.6f} s of the instrument, {describe_slowdown(status)}",
        f"shaft      {format_dms(true_deg)}, turn {int(status.true_counts // COUNTS_PER_TURN)}, "
        f"{status.speed_rps:g} r/s",
        f"position   {status.position} counts, raw {status.raw_position}{'' if status.homed else ', not homed'}",
        f"faults     {', '.join(describe_faults(status.flags)) or 'none'}",
        f"strobes    {status.strobes} so far, {status.strobe_rate_hz:g} a second",
        f"port       {status.bytes_from_host} bytes from the host, {status.bytes_to_host} to it",
    ]
    if status.dropped_bytes:
        lines.append(f"           {status.dropped_bytes} bytes dropped because nobody read them")
    return "\n".join(lines)


def describe_slowdown(status: TwinStatus) -> str:
    """How far behind real time it runs."""
    if status.sleeping:
        return "asleep until the port is used"
    if not status.slowdown > 0:
        return "just begun"
    return f"{status.slowdown:.3g} times slower than real time" if status.slowdown > 1.005 else "in real time"


def _help(twin: Twin, words: list[str]) -> str:
    return "\n".join(f"  {use:28} {meaning}" for use, (meaning, _) in zip(_USES, COMMANDS.values(), strict=True))


def _quit(twin: Twin, words: list[str]) -> str:
    raise Quit


def _numbers(words: list[str], use: str, *, least: int, most: int) -> list[float | None]:
    """`words` as `most` numbers, None for those left out."""
    if not least <= len(words) <= most:
        raise ValueError(f"`{use}` was expected")
    values: list[float | None] = []
    for word in words:
        try:
            values.append(float(word))
        except ValueError:
            raise ValueError(f"{word!r} is no number; `{use}` was expected") from None
        if values[-1] != values[-1] or abs(values[-1]) == float("inf"):
            raise ValueError(f"{word!r} is no number; `{use}` was expected")
    return values + [None] * (most - len(values))


COMMANDS: dict[str, tuple[str, Callable[[Twin, list[str]], str]]] = {
    "speed": ("turn at so many turns a second, negative in reverse; at once, or accelerating", _speed),
    "reverse": ("turn the other way", _reverse),
    "strobe": ("strobe the pin at a rate, 0 for none", _strobe),
    "burst": ("so many strobes right after one another, one a word unless told otherwise", _burst),
    "fault": ("put a fault between encoder and instrument; `fault` alone lists them", _fault),
    "spi": ("read one position frame at the SPI pins", _spi),
    "status": ("how it stands, and how far behind real time it runs", _status),
    "help": ("this", _help),
    "quit": ("end", _quit),
}
"""Every command: its meaning and what it does."""

_USES = (
    "speed RPS [RPS_PER_S]",
    "reverse [RPS_PER_S]",
    "strobe HZ [random]",
    "burst N [SAMPLES_APART]",
    "fault [NAME [N]]",
    "spi",
    "status",
    "help",
    "quit",
)
