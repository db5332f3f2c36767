"""One reading of everything that the zero-return test follows: the position with its time, and what watches it."""

from dataclasses import dataclass

from arcref.flags import Flag
from arcref.instrument.instrument import Instrument

WATCHED = ("closure_error", "largest_closure_error", "index_count", "shortest_edge_spacing", "illegal_steps")
"""Registers that stand together and are read by one request."""


@dataclass(frozen=True)
class CountingState:
    """Counts unless the name says otherwise; `time_s` since the instrument's reset, `shortest_edge_spacing` in samples.

    The watching registers are read just before the snapshot, so every index that they count lies on the way up to
    `raw_position`.
    """

    time_s: float
    raw_position: int
    position: int
    flags: Flag
    homed: bool
    closure_error: int
    largest_closure_error: int
    index_count: int
    shortest_edge_spacing: int
    illegal_steps: int


def read_counting_state(instrument: Instrument) -> CountingState:
    """Read it, with two requests. Raises `InstrumentError` as `Instrument` does."""
    watched = instrument.registers.read_together(WATCHED)
    snapshot = instrument.snapshot()
    return CountingState(
        snapshot.time_s, snapshot.raw_position, snapshot.position, snapshot.flags, snapshot.homed, **watched
    )
