"""Drives the core word by word, records what it shows, and compares that with the golden model at every word."""

import os

import numpy as np
from cocotb.clock import Clock
from cocotb.simtime import get_sim_time
from cocotb.triggers import FallingEdge
from core_under_test import SAMPLES_VARIABLE, bench_rom

from arcref_gateware.golden.core import CAPTURE, POSITION_CHANGE, STATUS_CHANGE, CoreModel
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, STROBE_BIT, Z_BIT, SignalChanges
from arcref_gateware.golden.steps import steps_of
from arcref_gateware.latency import LATENCY_CLOCKS

CLOCK_PERIOD_PS = 8000

ROM = bench_rom()

LINE_BITS = {"a": A_BIT, "b": B_BIT, "z": Z_BIT, "strobe": STROBE_BIT}
STATUS_PORTS = STATUS_CHANGE.names[1:]
SIGNED_PORTS = {"raw_position", "position", "closure_error", "largest_closure_error", "capture_position", "capture_raw"}
SIGNED_PORTS |= {"first_illegal_position"}


class CoreDriver:
    """One core in the simulator. Inputs change, and outputs are read, at the falling edge of the clock.

    Everything that is played since the last reset is kept, so that `check` can compare it whole.
    """

    def __init__(self, dut):
        self.dut = dut
        self.samples_per_word = int(os.environ[SAMPLES_VARIABLE])
        # Looked up once: a word is played in microseconds, and a look-up by name takes one of them.
        self._inputs = [dut[name] for name in LINE_BITS]
        self._positions = [dut.raw_position, dut.position]
        self._status = [(dut[name], name in SIGNED_PORTS) for name in STATUS_PORTS]
        self._capture_valid = dut.capture_valid
        self._edge = FallingEdge(dut.clk)
        self._clock = None

    async def reset(self, state: int = 0, *, strobe_delay: int = 0, clocks: int = 2, noise=None) -> None:
        """Hold the reset for `clocks` with the lines at `state`, or at the words of `noise`. Then play at once."""
        dut = self.dut
        if self._clock is None:
            self._clock = Clock(dut.clk, CLOCK_PERIOD_PS, "ps", period_high=CLOCK_PERIOD_PS // 2)
            self._clock.start()
            dut.spi_sck.value, dut.spi_cs_n.value, dut.spi_copi.value = 0, 1, 0
            await self._edge
        dut.rst.value = 1
        dut.strobe_delay.value = strobe_delay
        self._lines = [None] * 4
        for clock in range(clocks):
            whole = np.full(self.samples_per_word, state) if noise is None else noise[clock]
            self._drive(next(self._words_of(whole)))
            await self._edge
        dut.rst.value = 0
        self.model = CoreModel(ROM, self.samples_per_word, strobe_delay=strobe_delay)
        self.words, self._started_ps = 0, round(get_sim_time("ps"))
        self.samples = np.zeros(0, np.uint8)
        self.positions, self.status, self.captures = [], [], []
        self._expected = {"positions": [], "status": [], "captures": []}
        self._modelled = 0
        self._last_position, self._last_status = (0, 0), (0,) * len(STATUS_PORTS)

    def read(self, name: str) -> int:
        """The value that a port shows now."""
        value = self.dut[name].value
        return value.to_signed() if name in SIGNED_PORTS else int(value)

    async def play(self, samples) -> None:
        """Give the core `samples`, one state (bits A, B, Z, strobe) each; the last state fills the last word."""
        samples = np.asarray(samples, dtype=np.uint8)
        missing = -len(samples) % self.samples_per_word
        samples = np.append(samples, np.full(missing, samples[-1:], np.uint8))
        self.samples = np.append(self.samples, samples)
        for word in self._words_of(samples):
            self._drive(word)
            await self._edge
            self._look()

    async def check(self, *, flags: bool = True) -> None:
        """Hold the last state until all is shown, and compare all that was shown with the golden model.

        Without `flags` only positions and captures are compared: after a command to clear flags.
        """
        await self.play(np.full(LATENCY_CLOCKS * self.samples_per_word, self.samples[-1]))
        output = self.model.run(SignalChanges.from_samples(self.samples[self._modelled :], self._modelled))
        self._modelled = len(self.samples)
        for name, dtype in (("positions", POSITION_CHANGE), ("captures", CAPTURE), ("status", STATUS_CHANGE)):
            self._expected[name] += getattr(output, name).tolist()
            expected = [entry for entry in self._expected[name] if entry[0] < self.shown_words]
            if flags or name != "status":
                _same(name, dtype, getattr(self, name), expected)
        if flags:
            assert self.read("shortest_edge_spacing") == self.model.shortest_edge_spacing
            assert self.read("largest_closure_error") == self.model.largest_closure_error
        self._check_first_illegal_step()

    @property
    def shown_words(self) -> int:
        """Words whose outcome the outputs have shown."""
        return max(self.words - LATENCY_CLOCKS + 1, 0)

    def per_word(self, name: str) -> np.ndarray:
        """What the output `name`, a position or a part of the status, showed for each word so far."""
        entries, dtype = (self.status, STATUS_CHANGE) if name in STATUS_PORTS else (self.positions, POSITION_CHANGE)
        changes = np.array(entries, dtype=dtype)
        values = np.append(np.zeros(1, changes[name].dtype), changes[name])
        return values[np.searchsorted(changes["word"], np.arange(self.shown_words), side="right")]

    def words_shown_after(self, time_ps: int) -> list[int]:
        """The words that the outputs show at the two falling edges of the clock that follow an instant."""
        clock = (time_ps - self._started_ps) // CLOCK_PERIOD_PS + 2
        return [clock - LATENCY_CLOCKS, clock + 1 - LATENCY_CLOCKS]

    def captured(self) -> np.ndarray:
        """The captures so far."""
        return np.array(self.captures, dtype=CAPTURE)

    def _words_of(self, samples):
        """Values of the four line ports for each word of `samples`, which are whole words."""
        rows = np.reshape(samples, (-1, self.samples_per_word)).astype(np.int64)
        place = 1 << np.arange(self.samples_per_word)
        return zip(*(((rows >> bit & 1) @ place).tolist() for bit in LINE_BITS.values()), strict=True)

    def _drive(self, word) -> None:
        for place, value in enumerate(word):
            if value != self._lines[place]:
                self._inputs[place].value = self._lines[place] = value

    def _look(self) -> None:
        """Record what changed in the outputs, which show the word that went in `LATENCY_CLOCKS` clocks ago."""
        self.words += 1
        word = self.words - LATENCY_CLOCKS
        position = tuple(port.value.to_signed() for port in self._positions)
        if position != self._last_position:
            self.positions.append((word, *position))
            self._last_position = position
        status = tuple(port.value.to_signed() if signed else int(port.value) for port, signed in self._status)
        if status != self._last_status:
            self.status.append((word, *status))
            self._last_status = status
        if self._capture_valid.value:
            self.captures.append((word, *(self.read(name) for name in CAPTURE.names[1:])))

    def _check_first_illegal_step(self) -> None:
        _, illegal = steps_of(self.samples, int(self.samples[0]))
        word = int(np.argmax(illegal)) // self.samples_per_word
        if not illegal.any() or word >= self.shown_words - 1:
            return
        assert self.read("first_illegal_time") == word * self.samples_per_word
        assert self.read("first_illegal_position") == self.per_word("raw_position")[word]


def _same(name: str, dtype: np.dtype, shown: list, expected: list) -> None:
    """Compare two lists of changes; the first difference makes the message."""
    if shown == expected:
        return
    place = next((i for i, pair in enumerate(zip(shown, expected, strict=False)) if pair[0] != pair[1]), None)
    place = min(len(shown), len(expected)) if place is None else place
    around = slice(max(place - 1, 0), place + 2)
    raise AssertionError(f"{name} {dtype.names}: core {shown[around]}, golden model {expected[around]}")
