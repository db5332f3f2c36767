"""What a board is: the part, its clock, and which pin is which signal."""

from dataclasses import dataclass, field

from arcref.link.packet import DEFAULT_BAUD

SAMPLED_SIGNALS = ("a", "b", "z", "strobe")
"""Signals that go through the samplers, all four along identical paths."""

ALIGNMENT = "alignment"
"""A pin with nothing wired to it, through which the order of the samples in a word is checked at start-up."""

SIGNAL_DIRECTIONS = {
    **dict.fromkeys(SAMPLED_SIGNALS, "i"),
    "spi_sck": "i",
    "spi_cs_n": "i",
    "spi_copi": "i",
    "spi_cipo": "o",
    "uart_rx": "i",
    "uart_tx": "o",
    "compare": "o",
    ALIGNMENT: "io",
    "led_homed": "o",
    "led_fault": "o",
    "led_heartbeat": "o",
}
"""Every signal a board can wire: name and direction, seen from the FPGA."""

UART_SIGNALS = ("uart_rx", "uart_tx")
"""A board with both of them gets the serial link."""

CAPTURE_DEPTHS = {"ecp5": 1024, "ice40": 256}
"""Captures that the FIFO holds, by family: what eight block RAMs have room for."""

OPTIONAL_SIGNALS = frozenset({*UART_SIGNALS, "compare", "led_homed", "led_fault", "led_heartbeat"})
"""Signals that a board may leave out."""


@dataclass(frozen=True)
class BoardPin:
    """Where one signal is.

    `names` are as in the file, a connector's pin ("gpio_0:14+") or a ball ("U18"); two of them are a differential
    pair, the positive one first. `balls` are the same on the package. `label` is what a person reads on the board.
    """

    signal: str
    names: tuple[str, ...]
    balls: tuple[str, ...]
    io_standard: str
    pull: str = "none"
    inverted: bool = False
    termination_ohm: int | None = None
    label: str = ""

    @property
    def direction(self) -> str:
        """ "i", "o" or "io", seen from the FPGA."""
        return SIGNAL_DIRECTIONS[self.signal]

    @property
    def differential(self) -> bool:
        """True when the signal comes on a pair of balls."""
        return len(self.balls) == 2


@dataclass(frozen=True)
class Board:
    """A board as its file in `constraints/` describes it, checked.

    `name` is the file's name without its ending, with "-VARIANT" behind it for a variant that is not the first.
    `amaranth_platform` is "module:class" for a board of amaranth-boards, None for one's own. `flash` holds what
    openFPGALoader needs to know (`board` or `cable`); `seeds` are the place-and-route seeds to try, in that order.
    `baud` is that of the UART, for a board with a link.
    """

    name: str
    title: str
    family: str
    device: str
    package: str
    speed: str
    samples_per_word: int
    oscillator_hz: float
    oscillator_ball: str
    oscillator_io_standard: str
    word_clock_hz: float
    pins: dict[str, BoardPin]
    amaranth_platform: str | None = None
    flash: dict[str, str] = field(default_factory=dict)
    seeds: tuple[int, ...] = tuple(range(1, 9))
    synthesis_options: tuple[str, ...] = ()
    web: str = ""
    baud: float = DEFAULT_BAUD

    @property
    def has_link(self) -> bool:
        """True for a board that wires both lines of the UART: it gets the registers and captures behind it."""
        return set(UART_SIGNALS) <= self.pins.keys()

    @property
    def capture_depth(self) -> int:
        """Captures that the FIFO behind the link holds: as many as the part has block RAM for."""
        return CAPTURE_DEPTHS[self.family]

    @property
    def samples_per_s(self) -> float:
        """Samples a second of each line at the wanted word clock."""
        return self.samples_per_word * self.word_clock_hz
