"""One compiled instrument for all tests on the twin, and its correction."""

from pathlib import Path

import pytest

from arcref.correction_rom import CorrectionRom
from arcref_sim.twin.twin import Twin
from arcref_sim.twin.twin_command import error_that_the_rom_corrects

PROJECT = Path(__file__).parents[3]
BUILDS = PROJECT / "build" / "verilated"

BAUD = 25_000_000
"""The highest rate at 200 MHz: what costs a second at 3 Mbaud costs an eighth, and every margin is the smallest."""


@pytest.fixture
def make_twin(rom: CorrectionRom):
    """Makes a twin with the published run's correction and the encoder that it corrects: `make_twin(speed_rps=10)`."""

    def make(**options) -> Twin:
        graduation = options.pop("graduation", None) or error_that_the_rom_corrects(rom)
        return Twin(rom, **{"baud": BAUD, "graduation": graduation, "folder": BUILDS} | options)

    return make
