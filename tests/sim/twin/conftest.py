"""One compiled instrument for all tests on the twin, and its correction."""

from functools import cache
from pathlib import Path

import pytest

from arcref.correction_rom import CorrectionRom
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_sim.twin.twin import Twin
from arcref_sim.twin.twin_command import error_that_the_rom_corrects
from arcref_sim.twin.twin_core import CompiledTwin

PROJECT = Path(__file__).parents[3]
BUILDS = PROJECT / "build" / "verilated"

BAUD = 25_000_000
"""The highest rate at 200 MHz: what costs a second at 3 Mbaud costs an eighth, and every margin is the smallest."""


@pytest.fixture(scope="session")
def compiled_twin(rom: CorrectionRom):
    """The instrument with the published run's correction, for a baud rate: `compiled_twin(3e6)`."""
    return cache(lambda baud: CompiledTwin.of(ConnectedEncoder(rom, baud=baud), BUILDS))


@pytest.fixture
def make_twin(rom: CorrectionRom, compiled_twin):
    """Makes a twin with the published run's correction and the encoder that it corrects: `make_twin(speed_rps=10)`."""

    def make(*, baud: float = BAUD, **options) -> Twin:
        options.setdefault("graduation", error_that_the_rom_corrects(rom))
        return Twin(rom, compiled=compiled_twin(baud), **options)

    return make
