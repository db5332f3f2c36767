"""A clock signal that the tools know the frequency of."""

from amaranth.hdl import Signal


def constrained_clock(platform, name: str, frequency_hz: float) -> Signal:
    """A new signal for a clock, constrained to `frequency_hz`.

    It keeps its name through synthesis: a constraint on a name that has gone is dropped by the tools.
    """
    clock = Signal(name=name, attrs={"keep": "true"})
    platform.add_clock_constraint(clock, frequency_hz)
    return clock
