"""The 64-bit frames of the SPI port: the position that the encoder sends, and the command a master may send.

Both are eight bytes, most significant bit first, SPI mode 0. The position is latched as chip select falls. While the
encoder sends it on CIPO, the master may send a command on COPI in the same 64 clocks. `FRAME_FIELDS` is the one place
that says which bit is what; encoding, decoding, the gateware and the manual are made from it.
"""

from dataclasses import dataclass

from arcref.angle import ANGLE_BITS, join_position, split_position
from arcref.flags import Flag

FRAME_BITS = 64
FRAME_BYTES = FRAME_BITS // 8


@dataclass(frozen=True)
class FrameField:
    """One field of the position frame: bits `high`..`low` of the 64-bit word, both counted in; bit 63 goes first."""

    name: str
    high: int
    low: int
    signed: bool
    meaning: str

    @property
    def width(self) -> int:
        """Number of bits."""
        return self.high - self.low + 1

    @property
    def smallest(self) -> int:
        """The smallest value the field holds."""
        return -(1 << (self.width - 1)) if self.signed else 0

    @property
    def largest(self) -> int:
        """The largest value the field holds."""
        return (1 << (self.width - self.signed)) - 1

    def insert(self, value: int) -> int:
        """`value` at its place in an otherwise empty word. Raises `ValueError` when it does not fit."""
        if not self.smallest <= value <= self.largest:
            raise ValueError(f"{self.name} is {value}, it must lie in {self.smallest} .. {self.largest}")
        return (value & ((1 << self.width) - 1)) << self.low

    def extract(self, word: int) -> int:
        """The field's value in `word`."""
        value = (word >> self.low) & ((1 << self.width) - 1)
        return value - (1 << self.width) if self.signed and value >> (self.width - 1) else value


FRAME_FIELDS: tuple[FrameField, ...] = (
    FrameField("angle", 63, 41, False, "Corrected angle in counts, 2^23 a turn."),
    FrameField("homed", 40, 40, False, "1 once the zero mark was met; before that the angle counts from power-up."),
    FrameField("flags", 39, 32, False, "The eight flags of the instrument, see the table of flags."),
    FrameField("turns", 31, 16, True, "Whole turns since the zero mark, the low 16 bits in two's complement."),
    FrameField("frame_counter", 15, 8, False, "One more each frame, 0 after 255; a gap is a frame missed."),
    FrameField("crc", 7, 0, False, "CRC-8/AUTOSAR over the 56 bits before it."),
)
"""The position frame, first bit on the wire first."""

FRAME_FIELD = {field.name: field for field in FRAME_FIELDS}
"""The same fields by name."""

CRC8_POLYNOMIAL = 0x2F
CRC8_INITIAL = 0xFF
CRC8_FINAL_XOR = 0xFF

COMMAND_CLEAR_FLAGS = 0xC1
"""Command byte that clears the fault flags whose bits are 1 in the argument byte.

Other command bytes, 0 for instance, ask for nothing, and neither does a frame whose CRC is wrong.
"""

COMMAND_READ_REGISTER = 0xA6
"""Command byte that asks for the word at an address of the registers."""

COMMAND_WRITE_REGISTER = 0x5A
"""Command byte that writes a word at an address of the registers."""


def _crc8_table() -> tuple[int, ...]:
    table = []
    for byte in range(256):
        for _ in range(8):
            byte = (byte << 1) ^ (CRC8_POLYNOMIAL if byte & 0x80 else 0)
        table.append(byte & 0xFF)
    return tuple(table)


_CRC8_TABLE = _crc8_table()


def crc8_autosar(data: bytes) -> int:
    """CRC-8/AUTOSAR: polynomial 0x2F, initial value 0xFF, not reflected, result inverted.

    It finds every error of up to three bits in a frame, and every burst of up to 8 bits.

    >>> hex(crc8_autosar(b"123456789"))
    '0xdf'
    """
    crc = CRC8_INITIAL
    for byte in data:
        crc = _CRC8_TABLE[crc ^ byte]
    return crc ^ CRC8_FINAL_XOR


class FrameError(ValueError):
    """A frame that cannot be trusted: wrong length or wrong CRC."""


@dataclass(frozen=True)
class PositionFrame:
    """What one position frame says. `angle` in counts, `turns` as sent: its low 16 bits, signed."""

    angle: int
    homed: bool
    flags: Flag
    turns: int
    frame_counter: int

    @property
    def position(self) -> int:
        """`turns` * 2^23 + `angle`, in counts. It wraps after 32 768 turns either way."""
        return join_position(self.turns, self.angle)

    @classmethod
    def of_position(cls, position: int, *, homed: bool = True, flags: int = 0, frame_counter: int = 0):
        """The frame the encoder sends at a corrected `position` of any number of turns."""
        turns, angle = split_position(int(position))
        return cls(angle, homed, Flag(flags), ((turns + 0x8000) & 0xFFFF) - 0x8000, frame_counter)

    def encode(self) -> bytes:
        """The eight bytes on the wire, first byte first. Raises `ValueError` for a value its field cannot hold."""
        word = sum(field.insert(int(getattr(self, field.name))) for field in FRAME_FIELDS if field.name != "crc")
        payload = word.to_bytes(FRAME_BYTES, "big")[:-1]
        return payload + bytes([crc8_autosar(payload)])

    @classmethod
    def decode(cls, data: bytes) -> "PositionFrame":
        """Read eight bytes, first byte on the wire first.

        Raises `FrameError` when there are not eight of them or the CRC is wrong.
        """
        data = bytes(data)
        if len(data) != FRAME_BYTES:
            raise FrameError(f"a position frame has {FRAME_BYTES} bytes, there are {len(data)}")
        expected = crc8_autosar(data[:-1])
        if data[-1] != expected:
            raise FrameError(f"position frame {data.hex()} has CRC 0x{data[-1]:02X}, 0x{expected:02X} was expected")
        word = int.from_bytes(data, "big")
        values = {field.name: field.extract(word) for field in FRAME_FIELDS if field.name != "crc"}
        return cls(**values | {"homed": bool(values["homed"]), "flags": Flag(values["flags"])})


@dataclass(frozen=True)
class ShortPositionFrame:
    """What the first 24 or 32 bits of a position frame say. `flags` is None after 24 bits.

    A short frame carries no CRC: nothing tells a wrong bit in it from a right one.
    """

    angle: int
    homed: bool
    flags: Flag | None


def decode_short(data: bytes) -> ShortPositionFrame:
    """Read the 3 or 4 bytes of a master that stops early. There is no CRC to check.

    Raises `FrameError` for any other length.
    """
    data = bytes(data)
    if len(data) not in (3, 4):
        raise FrameError(f"a short position frame has 3 or 4 bytes, there are {len(data)}")
    word = int.from_bytes(data.ljust(FRAME_BYTES, b"\0"), "big")
    flags = Flag(FRAME_FIELD["flags"].extract(word)) if len(data) == 4 else None
    return ShortPositionFrame(FRAME_FIELD["angle"].extract(word), bool(FRAME_FIELD["homed"].extract(word)), flags)


def encode_clear_flags(mask: int) -> bytes:
    """The eight bytes a master sends to clear the fault flags whose bits are 1 in `mask`.

    Byte 0 is the command, byte 1 the mask, bytes 2..6 are zero, byte 7 is the CRC-8/AUTOSAR of the seven before it.
    Raises `ValueError` when `mask` is no byte.

    >>> encode_clear_flags(0x80).hex()
    'c1800000000000cf'
    """
    if not 0 <= int(mask) <= 0xFF:
        raise ValueError(f"the mask of flags is {mask}, it must lie in 0 .. 255")
    payload = bytes([COMMAND_CLEAR_FLAGS, int(mask), 0, 0, 0, 0, 0])
    return payload + bytes([crc8_autosar(payload)])


def encode_read_register(address: int) -> bytes:
    """The eight bytes a master sends to read the register word at `address`: command, address (high byte first), zeros
    and CRC. The answer comes in a frame of its own, see `RegisterFrame`. Raises `OverflowError` for no address.
    """
    payload = bytes([COMMAND_READ_REGISTER]) + int(address).to_bytes(2, "big") + bytes(4)
    return payload + bytes([crc8_autosar(payload)])


def encode_write_register(address: int, word: int) -> bytes:
    """The eight bytes a master sends to write `word` at `address`: command, address, word, zeros and CRC, high bytes
    first. Raises `OverflowError` for what is not 16 bits.
    """
    payload = bytes([COMMAND_WRITE_REGISTER]) + int(address).to_bytes(2, "big") + int(word).to_bytes(2, "big")
    payload += bytes(2)
    return payload + bytes([crc8_autosar(payload)])


@dataclass(frozen=True)
class RegisterFrame:
    """The answer to a register command, sent once in place of the next position frame that begins when it is ready.

    Bytes: the command (1), status (1), address (2), word (2, that was read or written), frame counter (1), and the
    CRC-8 of these *inverted*, so that no answer passes for a position, nor a position for an answer.
    """

    command: int
    status: int
    address: int
    word: int
    frame_counter: int

    def encode(self) -> bytes:
        """The eight bytes on the wire, first byte first."""
        payload = bytes([self.command, self.status]) + self.address.to_bytes(2, "big") + self.word.to_bytes(2, "big")
        payload += bytes([self.frame_counter])
        return payload + bytes([crc8_autosar(payload) ^ 0xFF])

    @classmethod
    def decode(cls, data: bytes) -> "RegisterFrame":
        """Read eight bytes. Raises `FrameError` when they are no answer to a register command."""
        data = bytes(data)
        if len(data) != FRAME_BYTES or data[-1] != crc8_autosar(data[:-1]) ^ 0xFF:
            raise FrameError(f"{data.hex()} is no answer to a register command")
        address, word = int.from_bytes(data[2:4], "big"), int.from_bytes(data[4:6], "big")
        return cls(data[0], data[1], address, word, data[6])


assert FRAME_FIELD["angle"].width == ANGLE_BITS
