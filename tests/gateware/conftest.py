"""What the gateware's tests share."""

import numpy as np
import pytest

from arcref.correction_rom import CorrectionRom


@pytest.fixture
def rng(request) -> np.random.Generator:
    """Random numbers, the same in every run, different from test to test."""
    return np.random.default_rng(list(request.node.nodeid.encode()))


@pytest.fixture(scope="session")
def random_rom() -> CorrectionRom:
    """Tables over the whole range of an entry: neighbouring cells differ as much as they can."""
    rng = np.random.default_rng(2)
    return CorrectionRom(rng.integers(-32768, 32768, 4096), rng.integers(-32768, 32768, 512))
