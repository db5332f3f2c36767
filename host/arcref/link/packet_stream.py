"""From a stream of bytes, as a serial port brings them, to packets."""

from collections.abc import Iterator

from arcref.link.packet import DELIMITER, BrokenPacket, Packet

LONGEST_WIRE_BYTES = 255
"""No packet is longer than this on the wire. More bytes without a delimiter are noise and are dropped."""


class PacketStream:
    """Cuts a stream at its delimiters. Bytes before the first delimiter are of a packet whose start was missed.

    `broken`: pieces between two delimiters that were no packet.
    """

    def __init__(self):
        self._pending = bytearray()
        self._in_step = False
        self.broken = 0

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Take the next bytes and give every packet that they complete."""
        pieces = data.split(DELIMITER)
        for piece in pieces[:-1]:
            self._take(piece)
            wire, in_step = bytes(self._pending), self._in_step
            self._pending.clear()
            self._in_step = True
            if not wire:
                continue  # delimiters may follow one another
            try:
                packet = Packet.decode(wire)
            except BrokenPacket:
                # Without a delimiter before it, half a packet is no fault of the link.
                self.broken += in_step
                continue
            yield packet
        self._take(pieces[-1])

    def _take(self, piece: bytes) -> None:
        self._pending += piece
        if len(self._pending) > LONGEST_WIRE_BYTES:
            # Kept just long enough to be refused as broken when its delimiter comes.
            del self._pending[LONGEST_WIRE_BYTES + 1 :]
