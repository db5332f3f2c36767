"""Where the tests keep the cores that they compile."""

from pathlib import Path

BUILDS = Path(__file__).parents[2] / "build" / "verilated"
