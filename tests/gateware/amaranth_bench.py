"""A block of the gateware in Amaranth's simulator: one value a clock in, one value a clock out."""

import numpy as np
from amaranth.hdl import Module, ResetInserter, Signal
from amaranth.sim import Simulator


class Bench:
    """Runs one component again and again, each time from power-up.

    `inputs` and `outputs` name its ports. An input that is called `rst` is the reset of the whole component.
    """

    def __init__(self, component, inputs: list[str], outputs: list[str]):
        self.component, self.outputs = component, outputs
        reset = Signal()
        top = Module()
        top.submodules.component = ResetInserter(reset)(component) if "rst" in inputs else component
        # A port that is several signals, one a sample, is given as a list.
        self.inputs = {name: reset if name == "rst" else getattr(component, name) for name in inputs}
        self.simulator = Simulator(top)
        self.simulator.add_clock(1e-6)
        self.simulator.add_testbench(self._drive)
        self.fresh = True

    def run(self, clocks: int, **values) -> dict[str, np.ndarray]:
        """Drive the inputs for so many clocks and return the outputs.

        A value is a number, held all the time, or a sequence with an entry a clock, whose last entry is held.
        Row k of an output is what it shows in clock k, just before the edge that ends it and with the inputs of
        clock k there: an output that comes L clocks after its input shows the answer to input k in row k + L.
        """
        unknown = values.keys() - self.inputs.keys()
        if unknown:
            raise ValueError(f"no such inputs: {unknown}")
        self.changes: list[list] = [[] for _ in range(clocks)]
        for name, value in values.items():
            row = np.atleast_1d(np.asarray(value, dtype=object))[:clocks]
            changed = [k for k in range(len(row)) if k == 0 or row[k] != row[k - 1]]
            for k in changed:
                self.changes[k].append((self.inputs[name], int(row[k])))
        self.rows: list[list] = []
        if not self.fresh:
            self.simulator.reset()
        self.fresh = False
        self.simulator.run()
        columns = zip(*self.rows, strict=True)
        return {name: np.array(column, dtype=np.int64) for name, column in zip(self.outputs, columns, strict=True)}

    async def _drive(self, ctx):
        ports = [getattr(self.component, name) for name in self.outputs]
        single = all(isinstance(port, Signal) for port in ports)
        for changes in self.changes:
            for signal, value in changes:
                ctx.set(signal, value)
            if single:
                self.rows.append([ctx.get(port) for port in ports])
            else:
                self.rows.append([self._get(ctx, port) for port in ports])
            await ctx.tick()

    @staticmethod
    def _get(ctx, port):
        if isinstance(port, Signal):
            return ctx.get(port)
        return [ctx.get(member) for member in port]


def as_bits(flags) -> np.ndarray:
    """Rows of booleans, the oldest sample first, to one number a row with the oldest sample in bit 0."""
    flags = np.atleast_2d(np.asarray(flags, dtype=bool))
    return flags @ (1 << np.arange(flags.shape[1]))


def as_samples(numbers, samples_per_word: int) -> np.ndarray:
    """The inverse of `as_bits`: rows of 0 and 1."""
    return np.asarray(numbers)[:, np.newaxis] >> np.arange(samples_per_word) & 1


def assert_rows(name: str, got, expected, first_row: int = 0) -> None:
    """Fail with the first row that differs, and its neighbours."""
    got, expected = np.asarray(got), np.asarray(expected)
    assert got.shape == expected.shape, f"{name}: {got.shape} rows, {expected.shape} were expected"
    wrong = got != expected
    wrong = wrong.any(axis=tuple(range(1, wrong.ndim))) if wrong.ndim > 1 else wrong
    if wrong.any():
        at = int(np.argmax(wrong))
        near = slice(max(at - 3, 0), at + 4)
        raise AssertionError(
            f"{name} differs in {np.count_nonzero(wrong)} of {len(wrong)} rows, first in row {first_row + at}\n"
            f"  rows     {first_row + near.start} ..\n"
            f"  got      {got[near].tolist()}\n"
            f"  expected {expected[near].tolist()}"
        )
