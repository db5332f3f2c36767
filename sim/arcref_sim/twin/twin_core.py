"""The whole instrument, compiled with Verilator, run piece by piece in native code with bytes at its UART."""

import ctypes
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.golden.signal_changes import SignalChanges
from arcref_gateware.verilog_export import describe_core, export_verilog
from arcref_sim.core_log import SPI_FRAME, NativeLog
from arcref_sim.simulation_top import harness_ports, output_ports, simulation_top
from arcref_sim.spi_plan import SpiPlan
from arcref_sim.twin.twin_instrument import TwinInstrument
from arcref_sim.verilator_build import DEFAULT_BUILD_FOLDER, build_library

_FAR_AWAY = np.iinfo(np.int64).max // 2
"""A sample that no run reaches."""

SENT_AHEAD_BYTES = 1 << 12
"""Bytes of the host that one run is given at most."""


class _Run(ctypes.Structure):
    _fields_ = [
        ("change_time", ctypes.c_void_p),
        ("change_state", ctypes.c_void_p),
        ("words", ctypes.c_int64),
        ("sent", ctypes.c_char_p),
        ("sent_bytes", ctypes.c_int64),
        ("taken", ctypes.c_int64),
        ("received", NativeLog),
        ("compare", NativeLog),
        ("frames", NativeLog),
    ]


@dataclass(frozen=True)
class CompiledTwin:
    """A compiled instrument: its library, what `describe_core` says of it, and its word clock and UART."""

    library: Path
    description: dict
    word_clock_hz: float
    divisor: int

    @classmethod
    def of(cls, design: ConnectedEncoder | TwinInstrument, folder: Path = DEFAULT_BUILD_FOLDER) -> "CompiledTwin":
        """Compiles a design unless that was done before. Raises as `build_library` does."""
        description = describe_core(design)
        top = simulation_top(description, plain=False, resting=())
        ports = harness_ports(description, plain=False, resting=())
        library = build_library(export_verilog(design), top, ports, "twin/twin_harness.cpp", folder)
        return cls(library, description, design.word_clock_hz, design.divisor)


@dataclass(frozen=True)
class TwinLog:
    """What one run brought: how many bytes of the host were `taken`, the bytes `received` from the instrument, the
    clocks at which `compare` rose and fell (int64), and SPI frames (SPI_FRAME).
    """

    taken: int
    received: bytes
    compare: np.ndarray
    frames: np.ndarray


class TwinCore:
    """One instrument from its power-up on. The native code runs without Python's lock."""

    def __init__(self, compiled: CompiledTwin):
        self.description = compiled.description
        self.samples_per_word = self.description["samples_per_word"]
        self._divisor = compiled.divisor
        self._library = _load(compiled.library)
        self._instrument = self._library.twin_create(compiled.divisor)
        self._outputs = output_ports(self.description)
        self._plan = None

    def __del__(self):
        if getattr(self, "_instrument", None):
            self._library.twin_destroy(self._instrument)
            self._instrument = None

    @property
    def clock(self) -> int:
        """Word clocks since power-up."""
        return self._library.twin_clock(self._instrument)

    @property
    def latency_words(self) -> int:
        """Clocks from the one that takes a word to the one after which the outputs show it."""
        return self.description["latency_cycles"] - 1

    @property
    def busy(self) -> bool:
        """True while a byte is on the wire, either way."""
        return bool(self._library.twin_busy(self._instrument))

    def output(self, name: str) -> int:
        """Present value of an output as an unsigned number. Raises ValueError for an unknown name."""
        return self._library.twin_output(self._instrument, self._outputs.index(name))

    def plan_spi(self, plan: SpiPlan) -> None:
        """Gives the SPI controller its frames. Raises ValueError while a frame is being read."""
        arrays = plan.arrays()
        if not self._library.twin_plan_spi(self._instrument, ctypes.byref(arrays.structure)):
            raise ValueError("a frame is being read; plan the next ones when it is over")
        self._plan = arrays  # the native side reads these arrays until the last frame is done

    def run(self, piece: SignalChanges, sent: bytes = b"") -> TwinLog:
        """Clocks the instrument through a piece, which must be whole words and follow the one before, while the host
        sends `sent`.
        """
        samples, word = self.samples_per_word, self.clock
        if piece.start != word * samples or piece.end % samples:
            raise ValueError(f"samples {piece.start}..{piece.end} are not whole words from word {word} on")
        words = piece.end // samples - word
        time = np.append(piece.time, _FAR_AWAY)
        state = np.ascontiguousarray(piece.state)
        sent = sent[:SENT_AHEAD_BYTES]
        run = _Run(time.ctypes.data, state.ctypes.data, words, sent, len(sent), 0)
        logs = {
            "received": np.empty(words // (9 * self._divisor) + 2, np.uint8),
            "compare": np.empty(words + 1, np.int64),
            "frames": np.empty(words // 32 + 1, SPI_FRAME),
        }
        for name, records in logs.items():
            setattr(run, name, NativeLog(records.ctypes.data, len(records), 0))
        self._library.twin_run(self._instrument, ctypes.byref(run))
        kept = {name: records[: getattr(run, name).used] for name, records in logs.items()}
        return TwinLog(run.taken, kept["received"].tobytes(), kept["compare"].copy(), kept["frames"].copy())


def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    instrument = ctypes.c_void_p
    signatures = {
        "twin_create": (instrument, [ctypes.c_int64]),
        "twin_destroy": (None, [instrument]),
        "twin_plan_spi": (ctypes.c_int, [instrument, ctypes.c_void_p]),
        "twin_run": (None, [instrument, ctypes.POINTER(_Run)]),
        "twin_clock": (ctypes.c_int64, [instrument]),
        "twin_busy": (ctypes.c_int, [instrument]),
        "twin_output": (ctypes.c_uint64, [instrument, ctypes.c_int]),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
