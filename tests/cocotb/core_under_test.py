"""The core that every bench drives: random correction tables over an entry's whole range, and one build per word size.

A build is kept under `build/cocotb`, named by a hash of all that went into it, so that it is made once.
"""

import hashlib
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import cocotb
import cocotb_tools.config
import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.correction_rom import ENTRY_MAX, ENTRY_MIN, SUBDIVISION_ENTRIES, CorrectionRom
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.core_ports import MODULE_NAME
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_gateware.verilog_export import export_verilog, port_names
from arcref_sim.verilator_build import verilator_command, verilator_environment

BUILDS = Path(__file__).parents[2] / "build" / "cocotb"

SAMPLES_VARIABLE = "ARCREF_SAMPLES_PER_WORD"
"""Environment variable that tells a bench the word size of its core."""


LINKED_CLOCK_HZ = 125e6
LINKED_BAUD = LINKED_CLOCK_HZ / 8
"""Of the core with its wire: the highest baud rate at the benches' clock."""


def bench_rom() -> CorrectionRom:
    """The tables of the core, the same in every process."""
    random = np.random.default_rng(23)
    line = random.integers(ENTRY_MIN, ENTRY_MAX, LINES_PER_TURN, endpoint=True)
    return CorrectionRom(line, random.integers(ENTRY_MIN, ENTRY_MAX, SUBDIVISION_ENTRIES, endpoint=True))


def build_core(samples_per_word: int, *, linked: bool = False) -> Path:
    """Folder of the simulator of the core with words of `samples_per_word`; compiles it when there is none yet.

    `linked`: the core with its wire, which users get, in place of the core alone with what only the benches look at.
    """
    if linked:
        core = ConnectedEncoder(bench_rom(), samples_per_word, word_clock_hz=LINKED_CLOCK_HZ, baud=LINKED_BAUD)
    else:
        core = ReferenceEncoder(bench_rom(), samples_per_word)
    text = export_verilog(core, observed=not linked)
    # Only the ports are visible to the bench. With every signal visible, as cocotb's own runner makes it, the model
    # runs at a third of the speed.
    names = ["clk", "rst", *port_names(core, observed=not linked)]
    visible = [f'public_flat_rw -module "{MODULE_NAME}" -var "{name}"' for name in names]
    control = "\n".join(["`verilator_config", *visible, ""])
    libraries, interface = cocotb_tools.config.libs_dir, cocotb_tools.config.share_dir / "lib/verilator/verilator.cpp"
    options = ["--cc", "--exe", "--build", "-j", "2", "--vpi", "--timescale", "1ns/1ps", "-Wno-fatal"]
    options += ["--top-module", MODULE_NAME, "--prefix", "Vtop", "-o", MODULE_NAME]
    options += ["-LDFLAGS", f"-Wl,-rpath,{libraries} -L{libraries} -lcocotbvpi_verilator", str(interface)]
    verilator, root = verilator_command()
    environment = verilator_environment(root)
    version = subprocess.run([*verilator, "--version"], env=environment, capture_output=True, text=True, check=True)
    made_of = "\n".join([text, control, *options, cocotb.__version__, version.stdout])
    kind = f"{'linked' if linked else 'core'}{samples_per_word}"
    folder = BUILDS / f"{kind}-{hashlib.sha256(made_of.encode()).hexdigest()[:16]}"
    if (folder / MODULE_NAME).exists():
        return folder

    BUILDS.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=BUILDS) as unfinished:
        place = Path(unfinished) / folder.name
        place.mkdir()
        (place / f"{MODULE_NAME}.v").write_text(text)
        (place / "visible.vlt").write_text(control)
        command = [*verilator, *options, "--Mdir", ".", "visible.vlt", f"{MODULE_NAME}.v"]
        done = subprocess.run(command, cwd=place, env=environment, capture_output=True, text=True)
        if done.returncode:
            raise RuntimeError(f"Verilator could not build the core:\n{done.stdout[-2000:]}\n{done.stderr[-2000:]}")
        if not (folder / MODULE_NAME).exists():
            os.rename(place, folder)
    for other in BUILDS.glob(f"{kind}-*"):
        if other != folder:
            shutil.rmtree(other, ignore_errors=True)
    return folder
