"""The machine's look at what place and route says: is every clock constrained, and does every constraint hold?

nextpnr checks a clock it knows nothing of at a frequency of its own choosing, 12 MHz unless told otherwise, and only
warns of a constraint that it could not use. Both look like success to whoever does not read the log.
"""

import re
from dataclasses import dataclass

UNCONSTRAINED_MHZ = 11.137
"""The frequency at which nextpnr is told to check clocks without a constraint: one that no board has, so that they
stand out even on a board with a 12 MHz oscillator."""

NEXTPNR_DEFAULT_MHZ = 12.0

TOLERANCE = 1e-3
"""nextpnr rounds a period to whole picoseconds."""

CELL_KINDS = {"ice40": "ICESTORM_LC", "ecp5": "TRELLIS_COMB"}
FLIP_FLOP_KINDS = {"ecp5": "TRELLIS_FF"}
BLOCK_RAM_KINDS = {"ice40": "ICESTORM_RAM", "ecp5": "DP16KD"}

_CONSTRAINED = re.compile(
    r"constraining clock net '[^']*' to ([\d.]+) MHz|Derived frequency constraint of ([\d.]+) MHz for net"
)
_IGNORED = re.compile(r"^(?:Warning|ERROR): *(.*(?:ignor\w*|unmatched)\b.*constraint.*)$", re.MULTILINE | re.IGNORECASE)


@dataclass(frozen=True)
class ClockTiming:
    """One clock, after routing."""

    name: str
    constraint_hz: float
    """What it was checked at."""
    reached_hz: float
    """What it reaches."""

    @property
    def holds(self) -> bool:
        """Whether it reaches what it was checked at."""
        return self.reached_hz >= self.constraint_hz


@dataclass(frozen=True)
class TimingReport:
    """What is known of a placed and routed design."""

    clocks: tuple[ClockTiming, ...]
    word_clock_hz: float
    """Wanted."""
    word_clock_reached_hz: float | None
    """Reached; None when no clock is the word clock."""
    cells: int
    cells_available: int
    flip_flops: int | None
    """None where a cell holds its flip-flop."""
    block_rams: int
    block_rams_available: int
    misuse: tuple[str, ...]
    """Constraints that were not used as they were meant, a sentence each. No other seed helps against these."""

    @property
    def missed(self) -> tuple[str, ...]:
        """Clocks that do not reach their constraint, a sentence each."""
        return tuple(
            f"{clock.name} reaches {clock.reached_hz / 1e6:.2f} MHz, {clock.constraint_hz / 1e6:.2f} MHz was wanted"
            for clock in self.clocks
            if not clock.holds
        )

    @property
    def problems(self) -> tuple[str, ...]:
        """Everything for which the build must fail."""
        return (*self.misuse, *self.missed)


def read_timing_report(report: dict, log: str, family: str, word_clock_hz: float) -> TimingReport:
    """The report of nextpnr, `report` its JSON and `log` its text, for a design whose word clock is `word_clock_hz`."""
    clocks = tuple(
        ClockTiming(name, entry["constraint"] * 1e6, entry["achieved"] * 1e6)
        for name, entry in sorted(report["fmax"].items())
    )
    constrained_hz = {float(first or second) * 1e6 for first, second in _CONSTRAINED.findall(log)}
    word = [clock.reached_hz for clock in clocks if _near(clock.constraint_hz, word_clock_hz)]
    misuse = [f"nextpnr: {' '.join(text.split())}" for text in _IGNORED.findall(log)]
    for clock in clocks:
        # Derived constraints are printed with one decimal.
        if not any(_near(clock.constraint_hz, wanted_hz, slack_hz=0.06e6) for wanted_hz in constrained_hz):
            misuse.append(_unconstrained(clock))
    if not word:
        misuse.append(f"no clock was checked at the word clock of {word_clock_hz / 1e6:g} MHz")
    used = report["utilization"]
    flip_flops = FLIP_FLOP_KINDS.get(family)
    return TimingReport(
        clocks=clocks,
        word_clock_hz=word_clock_hz,
        word_clock_reached_hz=min(word, default=None),
        cells=used[CELL_KINDS[family]]["used"],
        cells_available=used[CELL_KINDS[family]]["available"],
        flip_flops=used[flip_flops]["used"] if flip_flops else None,
        block_rams=used[BLOCK_RAM_KINDS[family]]["used"],
        block_rams_available=used[BLOCK_RAM_KINDS[family]]["available"],
        misuse=tuple(misuse),
    )


def _near(one_hz: float, other_hz: float, slack_hz: float = 0.0) -> bool:
    return abs(one_hz - other_hz) <= TOLERANCE * other_hz + slack_hz


def _unconstrained(clock: ClockTiming) -> str:
    default = any(_near(clock.constraint_hz, mhz * 1e6) for mhz in (UNCONSTRAINED_MHZ, NEXTPNR_DEFAULT_MHZ))
    reason = "nextpnr's choice for a clock without a constraint" if default else "which no constraint names"
    return f"{clock.name} was checked at {clock.constraint_hz / 1e6:.2f} MHz, {reason}"
