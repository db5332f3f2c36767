"""The ports of the Verilog module `arcref_core`: a promise to everyone who instantiates it.

The export is made and checked from this list, `core.json` and the tests read it. Ports are never renamed.
"""

from dataclasses import dataclass

MODULE_NAME = "arcref_core"


@dataclass(frozen=True)
class Port:
    """One port of `arcref_core`.

    `width` is in bits; 0 stands for one bit a sample of the word. `signed` tells how to read it.
    """

    name: str
    direction: str
    width: int
    meaning: str
    signed: bool = False

    def bits(self, samples_per_word: int) -> int:
        """Width in bits for a core with `samples_per_word` samples a word."""
        return self.width or samples_per_word


CORE_PORTS: tuple[Port, ...] = (
    Port("clk", "input", 1, "Word clock: one sample word each rising edge."),
    Port("rst", "input", 1, "Synchronous reset. The first word after it sets the quadrature state."),
    Port("a", "input", 0, "Samples of A, bit 0 the oldest."),
    Port("b", "input", 0, "Samples of B, bit 0 the oldest."),
    Port("z", "input", 0, "Samples of the zero pulse Z, bit 0 the oldest."),
    Port("strobe", "input", 0, "Samples of the strobe, bit 0 the oldest. Its rising edge captures the position."),
    Port("raw_position", "output", 48, "Position as counted, after the last sample of a word.", signed=True),
    Port("position", "output", 48, "Corrected position; raw_position while the correction is off.", signed=True),
    Port("homed", "output", 1, "1 once the first index has set the zero."),
    Port("illegal_steps", "output", 16, "Samples in which A and B both changed; stays at 65535 when reached."),
    Port("closure_error", "output", 24, "Closure error at the last checked index, in counts.", signed=True),
    Port("index_count", "output", 16, "Indices seen since reset, modulo 65536."),
    Port("flags", "output", 8, "Flag byte as in the position frame."),
    Port("capture_valid", "output", 1, "1 for one clock with each captured strobe."),
    Port("capture_position", "output", 48, "Corrected position at the due sample of the strobe.", signed=True),
    Port("capture_raw", "output", 48, "Raw position at the due sample of the strobe.", signed=True),
    Port("capture_time", "output", 48, "Due sample of the strobe, in sample periods since reset."),
    Port("spi_sck", "input", 1, "SPI clock, mode 0, at most one eighth of the word clock."),
    Port("spi_cs_n", "input", 1, "SPI chip select, low while a frame is read."),
    Port("spi_copi", "input", 1, "SPI data from the controller: command frames."),
    Port("spi_cipo", "output", 1, "SPI data to the controller: the position frame, most significant bit first."),
    Port("uart_rx", "input", 1, "UART from the host: 8 data bits, no parity, one stop bit."),
    Port("uart_tx", "output", 1, "UART to the host."),
    Port("compare", "output", 1, "The compare output: a pulse every so many counts of corrected position."),
)
