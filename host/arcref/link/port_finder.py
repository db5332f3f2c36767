"""Opening the port an instrument is at, and finding it when none was named."""

import errno
import os
from pathlib import Path

import serial
from serial.tools import list_ports

from arcref.input_error import InputError
from arcref.instrument_error import InstrumentError
from arcref.link.link import Link, LinkLost
from arcref.link.packet import DEFAULT_BAUD
from arcref.link.registers import MAGIC, PROTOCOL_VERSION, REGISTERS

PORT_VARIABLE = "ARCREF_PORT"
"""Environment variable that names the port when no option does."""

READ_TIMEOUT_S = 0.02
"""How long the reading thread waits for bytes; it notices a closed port within this time."""

FTDI = 0x0403
BOARD_ADAPTERS = {
    (FTDI, 0x6010): "FT2232H (iCEBreaker, HX8K breakout)",
    (FTDI, 0x6015): "FT231X (ULX3S)",
}
"""USB adapters of the boards that arcref is built for, by vendor and product."""


def open_link(port: str | None = None, *, baud: int = DEFAULT_BAUD, on_record=None) -> Link:
    """Open the instrument at `port`; without one, at the port that `ARCREF_PORT` names, or the only one that fits.

    Raises `InputError` for a port that is missing, busy, without rights, not ours or of another protocol, and when
    several fit or none; `LinkLost` when the port goes away meanwhile.
    """
    name = port or os.environ.get(PORT_VARIABLE)
    if name:
        return _open_checked(name, baud, on_record)
    candidates = [info.device for info in list_ports.comports() if (info.vid, info.pid) in BOARD_ADAPTERS]
    problems = {device: _problem(device, baud) for device in candidates}
    fitting = [device for device, problem in problems.items() if problem is None]
    if len(fitting) == 1:
        return _open_checked(fitting[0], baud, on_record)
    if fitting:
        raise InputError(f"{len(fitting)} instruments are plugged in ({', '.join(fitting)}): name one with --port")
    tried = "".join(f"; {problem}" for problem in problems.values())
    raise InputError(f"no instrument was found{tried}: plug one in, name its port with --port, or start `arcref twin`")


def _problem(name: str, baud: int) -> str | None:
    """Why the port `name` does not serve, None when an instrument answers there."""
    try:
        _open_checked(name, baud, None).close()
    except (InputError, InstrumentError) as error:
        return str(error)
    return None


def _open_checked(name: str, baud: int, on_record) -> Link:
    """An open link whose other end is known to be an instrument of our protocol."""
    link = Link(_open(name, baud), name, on_record)
    try:
        magic, protocol = link.read_words(REGISTERS["magic"].address, 2, "first words")
    except LinkLost:
        link.close()
        raise
    except InstrumentError:
        link.close()
        raise InputError(
            f"{name}: nothing there answers as an arcref instrument does at {baud} baud; "
            "is it the right port, and is the bitstream loaded?"
        ) from None
    if magic != MAGIC:
        link.close()
        raise InputError(f"{name}: answers, but its first word is {magic:#06x}; {MAGIC:#06x} was expected of arcref")
    if protocol != PROTOCOL_VERSION:
        link.close()
        older = "older" if protocol < PROTOCOL_VERSION else "newer"
        raise InputError(
            f"{name}: the instrument speaks protocol {protocol}, {older} than this arcref's {PROTOCOL_VERSION}; "
            f"{'build and flash its bitstream anew' if older == 'older' else 'update arcref on this computer'}"
        )
    return link


def _open(name: str, baud: int) -> serial.Serial:
    if not Path(name).exists() and "://" not in name and os.name == "posix":
        raise InputError(f"{name}: there is no such port{_others()}")
    try:
        return serial.serial_for_url(name, baudrate=baud, timeout=READ_TIMEOUT_S, write_timeout=1.0, exclusive=True)
    except serial.SerialException as error:
        raise InputError(f"{name}: {_reason(error)}") from error
    except (OSError, ValueError, TypeError, OverflowError) as error:
        raise InputError(f"{name}: cannot be opened as a serial port ({error})") from error


def _reason(error: serial.SerialException) -> str:
    number = error.errno
    if number == errno.EACCES:
        return "no right to open it; on Linux join the group `dialout` and log in again"
    if number in (errno.EBUSY, errno.EAGAIN) or "lock" in str(error).lower():
        return "busy: another program has it open; close that first"
    if number == errno.EISDIR or "could not configure port" in str(error).lower():
        return "there is no serial port behind this name"
    if number == errno.ENOENT:
        return f"there is no such port{_others()}"
    return f"cannot be opened ({error})"


def _others() -> str:
    """The ports that there are, for a message."""
    names = [info.device for info in list_ports.comports()]
    return f"; there are {', '.join(names)}" if names else "; no serial port was found at all"
