"""Joining many words of which one at the most is selected."""

from amaranth.hdl import Module, Signal

GATED_AT_ONCE = 2
"""Words that are gated and joined in one clock: a LUT has four inputs."""

JOINED_AT_ONCE = 4


def selected_word(m: Module, choices, *, name: str, clocks: int | None = None):
    """The value of the pair (select, value) in `choices` whose select is 1, and 0 when there is none.

    It comes `joining_clocks(len(choices))` clocks later, or the given number of them, which is no less.
    """
    parts, clock = [], 0
    for k in range(0, len(choices), GATED_AT_ONCE):
        gated = [value & select.replicate(len(value)) for select, value in choices[k : k + GATED_AT_ONCE]]
        parts.append(_registered_or(m, gated, name=f"{name}_0_{k}"))
    while clock + 1 < (clocks or 0) or len(parts) > 1:
        clock += 1
        parts = [
            _registered_or(m, parts[k : k + JOINED_AT_ONCE], name=f"{name}_{clock}_{k}")
            for k in range(0, len(parts), JOINED_AT_ONCE)
        ]
    return parts[0]


def joining_clocks(choices: int) -> int:
    """Clocks that `selected_word` takes for so many choices, at the least."""
    parts, clocks = -(-choices // GATED_AT_ONCE), 1
    while parts > 1:
        parts, clocks = -(-parts // JOINED_AT_ONCE), clocks + 1
    return clocks


def _registered_or(m: Module, values, *, name: str) -> Signal:
    joined = Signal(max(map(len, values)), name=name)
    total = values[0]
    for value in values[1:]:
        total = total | value
    m.d.sync += joined.eq(total)
    return joined
