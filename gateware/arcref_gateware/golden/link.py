"""What the FPGA's end of the serial link must do: requests in, answers out, byte for byte."""

from collections.abc import Callable

from arcref.link.packet import MOST_WORDS, Kind, Packet, Status
from arcref.link.packet_stream import PacketStream
from arcref.link.register import UNKNOWN_WORD, Access, Register, RegisterMap, Window
from arcref.link.registers import REGISTERS


class LinkModel:
    """The register door.

    `read(register)` gives a live register's value, `on_write(name, value)` and `on_window(name, place, word)` tell
    what was written. Written registers keep their values in `settings`. While `loading` is False, windows refuse
    writes with NOT_NOW.

    A WRITE is checked whole before any of it acts: every word must belong to a register that can be written, and a
    register must be given whole. A value above `Register.largest` is OUT_OF_RANGE.
    """

    def __init__(
        self,
        read: Callable[[Register], int],
        on_write: Callable[[str, int], None] = lambda name, value: None,
        on_window: Callable[[str, int, int], None] = lambda name, place, word: None,
        read_window: Callable[[str, int], int] = lambda name, place: UNKNOWN_WORD,
        registers: RegisterMap = REGISTERS,
    ):
        self._map = registers
        self._read, self._on_write, self._on_window, self._read_window = read, on_write, on_window, read_window
        self._at = {
            address: entry for entry in (*registers.registers, *registers.windows) for address in entry.addresses
        }
        self.settings = {r.name: r.reset for r in registers.registers if r.access is Access.WRITE}
        self.loading = False
        self._stream = PacketStream()
        self._last_write: tuple[int, Status] | None = None

    def feed(self, data: bytes) -> bytes:
        """Take bytes from the host; give the bytes of the answers."""
        return b"".join(self._answer(packet) for packet in self._stream.feed(data))

    def _answer(self, packet: Packet) -> bytes:
        address = int.from_bytes(packet.payload[:2], "little")
        if packet.kind is Kind.READ:
            count = packet.payload[2]
            if not 1 <= count <= MOST_WORDS:
                return b""
            self._last_write = None
            words = self._words(address, count)
            body = bytes([Status.DONE]) + packet.payload[:2] + b"".join(word.to_bytes(2, "little") for word in words)
            return Packet(Kind.READ_ANSWER, packet.number, body).encode()
        if packet.kind is not Kind.WRITE:
            return b""
        if self._last_write is None or self._last_write[0] != packet.number:
            raw = packet.payload[2:]
            words = [int.from_bytes(raw[i : i + 2], "little") for i in range(0, len(raw), 2)]
            status = self._write(address, words)
            self._last_write = packet.number, status
        body = bytes([self._last_write[1]]) + packet.payload[:2]
        return Packet(Kind.WRITE_ANSWER, packet.number, body).encode()

    def _words(self, address: int, count: int) -> list[int]:
        values: dict[str, int] = {}
        words = []
        for place in range(address, address + count):
            entry = self._at.get(place & 0xFFFF)
            if isinstance(entry, Window) and entry.access is Access.WRITE:
                words.append(self._read_window(entry.name, place - entry.address))
            elif not isinstance(entry, Register) or entry.access is Access.COMMAND:
                words.append(UNKNOWN_WORD if not isinstance(entry, Register) else 0)
            else:
                if entry.name not in values:
                    live = entry.access is Access.READ
                    values[entry.name] = (self._read(entry) if live else self.settings[entry.name]) & (
                        (1 << entry.width) - 1
                    )
                words.append(values[entry.name] >> 16 * (place - entry.address) & 0xFFFF)
        return words

    def _write(self, address: int, words: list[int]) -> Status:
        actions = []
        place, end = address, address + len(words)
        while place < end:
            entry = self._at.get(place & 0xFFFF)
            if entry is None:
                return Status.UNKNOWN_ADDRESS
            if isinstance(entry, Window):
                if not self.loading:
                    return Status.NOT_NOW
                actions.append((self._on_window, (entry.name, place - entry.address, words[place - address])))
                place += 1
                continue
            if entry.access is Access.READ:
                return Status.READ_ONLY
            if place != entry.address or place + entry.words > end:
                return Status.OUT_OF_RANGE
            value = sum(word << 16 * i for i, word in enumerate(words[place - address :][: entry.words]))
            if value >> entry.width or (entry.largest is not None and value > entry.largest):
                return Status.OUT_OF_RANGE
            actions.append((self._take, (entry, value)))
            place += entry.words
        for act, arguments in actions:
            act(*arguments)
        return Status.DONE

    def _take(self, register: Register, value: int) -> None:
        if register.access is Access.WRITE:
            self.settings[register.name] = value
        self._on_write(register.name, value)
