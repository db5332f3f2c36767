"""What the SPI port asks of the registers."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.register import ADDRESS_BITS, WORD_BITS


class SpiRegisters(wiring.Signature):
    """Members as the SPI port sees them. `valid` is 1 for one clock, and what is asked holds from it until `done`. That
    brings the answer, which holds for a clock more. A command that comes before the answer to the one before it
    replaces nothing: it is not obeyed.
    """

    def __init__(self):
        super().__init__(
            {
                "valid": Out(1),
                "write": Out(1),
                "address": Out(ADDRESS_BITS),
                "write_word": Out(WORD_BITS),
                "done": In(1),
                "status": In(8),
                "read_word": In(WORD_BITS),
            }
        )
