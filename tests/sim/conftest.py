"""What the simulation's tests share: the published run's correction, and cores compiled once a session."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from compiled_cores import BUILDS

from arcref.correction_rom import CorrectionRom
from arcref.error_curve import ErrorCurve
from arcref.radial_basis_network import RadialBasisNetwork
from arcref_gateware.golden.core import CoreModel
from arcref_gateware.reference_encoder import ReferenceEncoder
from arcref_sim.core_log import Comparison
from arcref_sim.verilated_core import CompiledCore, VerilatedCore

PROJECT = Path(__file__).parents[2]
POLYGON = PROJECT / "examples" / "polygon_before_correction.csv"


@pytest.fixture(scope="session")
def network() -> RadialBasisNetwork:
    """The curve of the published run."""
    return RadialBasisNetwork.fit(ErrorCurve.from_polygon_csv(POLYGON))


@pytest.fixture(scope="session")
def rom(network) -> CorrectionRom:
    """The correction made from the published run."""
    return CorrectionRom.from_fit(network.evaluate)


@pytest.fixture
def random(request) -> np.random.Generator:
    """Random numbers, the same in every run, different from test to test."""
    return np.random.default_rng(list(request.node.nodeid.encode()))


class CoreBench:
    """A Verilated core beside its golden model, compared at every word."""

    def __init__(self, rom: CorrectionRom, compiled: CompiledCore, strobe_delay: int = 0):
        self.core = VerilatedCore(compiled)
        self.core.set_input("strobe_delay", strobe_delay)
        self.model = CoreModel(rom, self.core.samples_per_word, strobe_delay=strobe_delay)
        self.comparison = Comparison()
        self.outputs = []

    def run(self, pieces):
        """Run pieces of input to the end and hold every word against the model; returns the model's outputs."""
        words = 0
        for piece in pieces:
            log, output = self.core.run(piece), self.model.run(piece)
            self.comparison.add(log, output)
            self.outputs.append(output)
            words = piece.end // self.core.samples_per_word
        self.comparison.add(self.core.finish())
        assert self.comparison.difference is None, str(self.comparison.difference)
        assert self.comparison.words == words
        return self.outputs

    def joined(self, name: str) -> np.ndarray:
        """All records of one of the lists `positions`, `status`, `captures`."""
        return np.concatenate([getattr(output, name) for output in self.outputs])


@pytest.fixture(scope="session")
def compiled(rom):
    """The core for a word size, compiled when it is first asked for: `compiled(samples_per_word, plain=False)`."""

    @cache
    def compile_once(samples_per_word: int, plain: bool) -> CompiledCore:
        return CompiledCore.of(ReferenceEncoder(rom, samples_per_word), BUILDS, plain=plain)

    return compile_once


@pytest.fixture
def bench(rom, compiled):
    """Makes a bench: `bench(samples_per_word, strobe_delay=0, plain=False)`."""

    def make(samples_per_word: int, strobe_delay: int = 0, *, plain: bool = False) -> CoreBench:
        return CoreBench(rom, compiled(samples_per_word, plain), strobe_delay)

    return make
