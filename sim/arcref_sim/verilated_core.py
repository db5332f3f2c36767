"""The core, compiled with Verilator and run word by word in native code, with the same lists as the golden model."""

import ctypes
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_gateware.verilog_export import describe_core, export_verilog
from arcref_sim.core_log import SPI_FRAME, CoreLog, NativeLog
from arcref_sim.simulation_top import output_ports
from arcref_sim.spi_plan import SpiPlan
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER, build_core

_FAR_AWAY = np.iinfo(np.int64).max // 2
"""A sample that no run reaches."""

_SPARE_RECORDS = 4096
"""Records a log may hold beyond one for each input change."""


class _Run(ctypes.Structure):
    _fields_ = [
        ("change_time", ctypes.c_void_p),
        ("change_state", ctypes.c_void_p),
        ("words", ctypes.c_int64),
        ("positions", NativeLog),
        ("status", NativeLog),
        ("captures", NativeLog),
        ("frames", NativeLog),
    ]


@dataclass(frozen=True)
class CompiledCore:
    """A core ready to run: its shared library, and what `describe_core` says of it. Any number of cores run from it."""

    library: Path
    description: dict

    @classmethod
    def of(
        cls, design: ReferenceEncoder, folder: Path = DEFAULT_BUILD_FOLDER, *, plain: bool = False
    ) -> "CompiledCore":
        """Compiles a design unless that was done before; see `build_core` for `folder`, `plain` and what is raised."""
        description = describe_core(design, observed=True)
        return cls(build_core(export_verilog(design, observed=True), description, folder, plain=plain), description)


class LogOverflow(RuntimeError):
    """The core's outputs changed far more often than its inputs: something is badly wrong with it."""


class VerilatedCore:
    """One core from its power-up on. Give it pieces of input in order with `run`, and end with `finish`.

    The native code runs without Python's lock, so that another thread can check the piece before meanwhile.
    """

    def __init__(self, compiled: CompiledCore):
        self.description = compiled.description
        self.samples_per_word = self.description["samples_per_word"]
        self._library = _load(compiled.library)
        self._core = self._library.arcref_create()
        self._outputs = output_ports(self.description)
        self._plan = None
        self._end_word = 0
        self._frames: list[np.ndarray] = []
        self.set_input("strobe_delay", self.description["strobe_delay_samples"])

    def __del__(self):
        if getattr(self, "_core", None):
            self._library.arcref_destroy(self._core)
            self._core = None

    @property
    def latency_words(self) -> int:
        """Clocks from the one that takes a word to the one after which the outputs show it."""
        return self.description["latency_cycles"] - 1

    def output(self, name: str) -> int:
        """Present value of an output as an unsigned number. Raises ValueError for an unknown name."""
        return self._library.arcref_output(self._core, self._outputs.index(name))

    def set_input(self, name: str, value: int) -> None:
        """Sets an input that is not in the sample words, `strobe_delay` for instance. Raises ValueError for another."""
        if not self._library.arcref_set_input(self._core, name.encode(), value):
            raise ValueError(f"the core has no input {name} to set")

    def reset(self, clocks: int = 4) -> None:
        """Holds the reset and starts counting words anew. Raises ValueError unless the core was built `plain`."""
        if not self._library.arcref_reset(self._core, clocks):
            raise ValueError("this build starts at power-up and has no reset")

    def plan_spi(self, plan: SpiPlan) -> None:
        """Gives the SPI controller its frames; what was planned before and not yet begun is dropped.

        Raises ValueError while a frame is being read.
        """
        arrays = plan.arrays()
        if not self._library.arcref_plan_spi(self._core, ctypes.byref(arrays.structure)):
            raise ValueError("a frame is being read; plan the next ones when it is over")
        self._plan = arrays  # the native side reads these arrays until the last frame is done

    def run(self, piece: SignalChanges) -> CoreLog:
        """Clocks the core through a piece, which must be whole words and follow the one before.

        Returns what the outputs showed; the last words of the piece show only with the next piece, or with `finish`.
        """
        samples, word = self.samples_per_word, self._library.arcref_clock(self._core)
        if piece.start != word * samples or piece.end % samples:
            raise ValueError(f"samples {piece.start}..{piece.end} are not whole words from word {word} on")
        self._end_word = piece.end // samples
        time = np.append(piece.time, _FAR_AWAY)
        return self._clock(time, np.ascontiguousarray(piece.state), self._end_word - word)

    def finish(self) -> CoreLog:
        """Holds the inputs until the outputs have shown every word, and returns what they showed."""
        return self._clock(np.array([_FAR_AWAY]), np.zeros(1, np.uint8), self.latency_words)

    def frames(self) -> np.ndarray:
        """Every SPI frame read so far, an array of SPI_FRAME."""
        return np.concatenate([np.empty(0, SPI_FRAME), *self._frames])

    def _clock(self, time: np.ndarray, state: np.ndarray, words: int) -> CoreLog:
        room = min(len(time) + _SPARE_RECORDS, words)
        logs = {
            "positions": np.empty(room, POSITION_CHANGE),
            "status": np.empty(room, STATUS_CHANGE),
            "captures": np.empty(room, CAPTURE),
            "frames": np.empty(words // 32 + 1, SPI_FRAME),
        }
        run = _Run(time.ctypes.data, state.ctypes.data, words)
        for name, records in logs.items():
            setattr(run, name, NativeLog(records.ctypes.data, len(records), 0))
        self._library.arcref_run(self._core, ctypes.byref(run))
        for name, records in logs.items():
            used = getattr(run, name).used
            if used > len(records):
                raise LogOverflow(f"the core's {name} changed {used} times in {words} words")
            logs[name] = records[:used]
        for name in ("positions", "status", "captures"):
            logs[name]["word"] -= self.latency_words
        self._frames.append(logs["frames"])
        end_word = self._library.arcref_clock(self._core) - self.latency_words
        return CoreLog(**logs, end_word=end_word)


def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    core = ctypes.c_void_p
    signatures = {
        "arcref_create": (core, []),
        "arcref_destroy": (None, [core]),
        "arcref_plan_spi": (ctypes.c_int, [core, ctypes.c_void_p]),
        "arcref_run": (None, [core, ctypes.POINTER(_Run)]),
        "arcref_clock": (ctypes.c_int64, [core]),
        "arcref_output": (ctypes.c_uint64, [core, ctypes.c_int]),
        "arcref_set_input": (ctypes.c_int, [core, ctypes.c_char_p, ctypes.c_uint64]),
        "arcref_reset": (ctypes.c_int, [core, ctypes.c_int64]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
