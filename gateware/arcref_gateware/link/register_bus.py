"""How a door (UART or SPI) reaches the registers: one request at a time."""

from amaranth.lib import enum, wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import Status
from arcref.link.register import ADDRESS_BITS, WORD_BITS

STATUS_BITS = 3
"""Bits of `arcref.link.packet.Status`."""

assert max(Status) < 1 << STATUS_BITS


class Request(enum.Enum, shape=2):
    """What is asked. CHECK says whether a word could be written, and changes nothing."""

    READ = 0
    CHECK = 1
    WRITE = 2


class RegisterBus(wiring.Signature):
    """Members of the bus, as the door sees them.

    `address`, `request` and `write_word` are held from `valid` (one clock) until `done` (one clock). `following` tells
    that the word belongs to the same packet as the one before it, at the next address; `is_last` that none follows it,
    from the clock after `valid` on. With `done` come `read_word` and `status`, and stay until the address changes.
    """

    def __init__(self):
        super().__init__(
            {
                "valid": Out(1),
                "request": Out(Request),
                "address": Out(ADDRESS_BITS),
                "following": Out(1),
                "is_last": Out(1),
                "write_word": Out(WORD_BITS),
                "done": In(1),
                "read_word": In(WORD_BITS),
                "status": In(STATUS_BITS),
            }
        )
