"""What the host's tests share: the published tables, and the command run inside the test."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from hypothesis import HealthCheck, settings

from arcref.command import main
from arcref.error_curve import ErrorCurve

# A busy machine is no failure.
settings.register_profile("patient", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("patient")

EXAMPLES = Path(__file__).parents[2] / "examples"


@pytest.fixture(scope="session")
def examples() -> Path:
    """The folder of the published tables."""
    return EXAMPLES


@pytest.fixture(scope="session")
def table_1() -> ErrorCurve:
    """Yu Hai et al. 2015, Table 1: before compensation."""
    return ErrorCurve.from_polygon_csv(EXAMPLES / "polygon_before_correction.csv")


@pytest.fixture(scope="session")
def table_2() -> ErrorCurve:
    """Table 2: after compensation, at the faces of the calibration."""
    return ErrorCurve.from_polygon_csv(EXAMPLES / "polygon_after_correction.csv")


@pytest.fixture(scope="session")
def table_3() -> ErrorCurve:
    """Table 3: after compensation, 5 degrees beside the faces."""
    return ErrorCurve.from_polygon_csv(EXAMPLES / "polygon_after_correction_offset_5deg.csv")


@pytest.fixture
def arcref():
    """Runs the command: `arcref("rom", "x.csv", ...)` gives click's result."""

    def run(*arguments):
        return CliRunner().invoke(main, [str(argument) for argument in arguments])

    return run
