"""An SPI controller in mode 0, drawn as what the word clock sees of its lines.

Times are in word clocks and need not be whole. An edge at time t is in the row of the first word clock edge after it;
`doubt` makes it one row later now and then, as a synchroniser may.
"""

import math
from dataclasses import dataclass, field

import numpy as np


@dataclass
class SpiLines:
    """Chip select, SCK and COPI drawn over time, and the times at which the controller reads CIPO.

    `high` and `low` are the times of SCK's two phases. `setup` and `hold` are what COPI is kept before and after
    the rising edge; outside of that it is noise. `pad` is how long CIPO takes to reach the controller; below 0 it is
    how long after the rising edge the controller reads.
    """

    high: float = 4.0
    low: float = 4.0
    start: float = 5.0
    lead: float = 4.0
    setup: float = 1.0
    hold: float = 1.0
    pad: float = 0.0
    doubt: float = 0.0
    seed: int = 1
    edges: list = field(default_factory=list)
    reads: list = field(default_factory=list)
    selects: list = field(default_factory=list)

    def __post_init__(self):
        self.time = self.start
        self.rng = np.random.default_rng(self.seed)

    def transfer(self, sent=(), bits: int = 64, *, gap: float = 3.0, abort_high: bool = False) -> None:
        """One chip select with `bits` clocks. `sent` bytes go out on COPI, zeros after them.

        `gap` is how long chip select stays high afterwards. With `abort_high` it rises while SCK is still high.
        """
        word = [byte >> 7 - place & 1 for byte in bytes(sent) for place in range(8)]
        self.selects.append(self.time)
        self._edge("cs_n", self.time, 0)
        rise = self.time + max(self.lead, self.low)
        reads = []
        end = self.time + self.low
        for number in range(bits):
            level = word[number] if number < len(word) else 0
            self._edge("copi", rise - self.low * 0.9, int(self.rng.integers(2)))
            self._edge("copi", rise - self.setup, level)
            self._edge("copi", rise + self.hold, int(self.rng.integers(2)))
            self._edge("sck", rise, 1)
            reads.append(rise - self.pad)
            self._edge("sck", rise + self.high, 0)
            end = rise + (self.high / 2 if abort_high else self.high + self.low / 2)
            rise += self.high + self.low
        self.reads.append(reads)
        self._edge("cs_n", end, 1)
        self.time = end + gap
        if abort_high:
            self.time = max(self.time, end + self.high)

    def pulse(self, level: int) -> None:
        """One SCK pulse, with a level on COPI, right here: for clocks that come where none should."""
        self._edge("copi", self.time, level)
        self._edge("sck", self.time, 1)
        self._edge("sck", self.time + 3, 0)
        self.time += 8

    def noise(self, clocks: int) -> None:
        """SCK and COPI toggle at random while chip select is high; both are low again at the end."""
        for _ in range(clocks):
            self.time += 1
            self._edge("sck", self.time, int(self.rng.integers(2)))
            self._edge("copi", self.time, int(self.rng.integers(2)))
        self._edge("sck", self.time + 1, 0)
        self.time += 3

    def _edge(self, line: str, at: float, level: int) -> None:
        self.edges.append((at, len(self.edges), line, level))

    def rows(self) -> dict[str, np.ndarray]:
        """The three lines, an entry a word clock."""
        clocks = math.ceil(self.time) + 12
        rows = {"sck": np.zeros(clocks, int), "cs_n": np.ones(clocks, int), "copi": np.zeros(clocks, int)}
        doubt = np.random.default_rng(self.seed + 1)
        last_row = dict.fromkeys(rows, 0)
        for at, _, line, level in sorted(self.edges):
            late = line == "sck" and doubt.random() < self.doubt
            # Row k ends with the word clock edge at time k + 1, which is the one that samples it.
            row = max(math.ceil(at) - 1 + late, last_row[line])
            rows[line][row:] = level
            last_row[line] = row
        return rows

    def received(self, cipo: np.ndarray) -> list[list[int]]:
        """The bits the controller read in each transfer, from CIPO by word clock."""
        return [[int(cipo[math.floor(at)]) for at in reads] for reads in self.reads]


def to_bytes(bits) -> bytes:
    """Bits in order of the wire, most significant first, to bytes."""
    return bytes(int("".join(map(str, bits[place : place + 8])), 2) for place in range(0, len(bits), 8))
