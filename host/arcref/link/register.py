"""What a register is, and what makes a set of them sound.

An address names a word of 16 bits. A register wider than that takes as many words as it needs, the lowest first.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from enum import Enum

WORD_BITS = 16
ADDRESS_BITS = 16

UNKNOWN_WORD = 0xBAD0
"""What a word reads that no register stands at."""


class Access(Enum):
    """How a register may be used: read alone, read and written, or written as a command that reads 0."""

    READ = "read"
    WRITE = "read, write"
    COMMAND = "command"


@dataclass(frozen=True)
class Field:
    """Bits `low` .. `low + width - 1` of a register. `choices` names the values when they are more than a number."""

    name: str
    low: int
    width: int
    meaning: str
    choices: tuple[str, ...] = ()

    def extract(self, value: int) -> int:
        """The field's bits in a register's value."""
        return value >> self.low & ((1 << self.width) - 1)


@dataclass(frozen=True)
class Register:
    """One register.

    `width` in bits, `reset` its value after reset (of registers that can be written, and of constants);
    `unit` of the value, "" for a pure number; `meaning`: one sentence. `largest`: the largest value that may be
    written, None for all that fit.
    """

    name: str
    address: int
    width: int
    access: Access
    meaning: str
    unit: str = ""
    reset: int = 0
    signed: bool = False
    largest: int | None = None
    fields: tuple[Field, ...] = ()

    @property
    def words(self) -> int:
        """Words of 16 bits that it takes."""
        return -(-self.width // WORD_BITS)

    @property
    def addresses(self) -> range:
        """Its addresses."""
        return range(self.address, self.address + self.words)

    def decode(self, words: Iterable[int]) -> int:
        """The value out of its words, the lowest first."""
        value = sum((word & 0xFFFF) << WORD_BITS * i for i, word in enumerate(words)) & ((1 << self.width) - 1)
        return value - (1 << self.width) if self.signed and value >> (self.width - 1) else value

    def encode(self, value: int) -> list[int]:
        """The words of `value`. Raises ValueError when it does not fit."""
        low = -(1 << self.width - 1) if self.signed else 0
        high = (1 << self.width - self.signed) - 1 if self.largest is None else self.largest
        if not low <= value <= high:
            raise ValueError(f"{self.name} is {value}, it must lie in {low} .. {high}")
        value &= (1 << self.width) - 1
        return [value >> WORD_BITS * i & 0xFFFF for i in range(self.words)]


@dataclass(frozen=True)
class Window:
    """A memory that stands at addresses of its own, one word an address."""

    name: str
    address: int
    words: int
    access: Access
    meaning: str

    @property
    def addresses(self) -> range:
        """Its addresses."""
        return range(self.address, self.address + self.words)


class AddressClash(ValueError):
    """Two registers were given one address, or one name; or one has an address that does not exist."""


@dataclass(frozen=True)
class RegisterMap(Mapping):
    """All registers and windows by name. Raises `AddressClash` when two share an address or a name."""

    registers: tuple[Register, ...]
    windows: tuple[Window, ...] = ()
    _by_name: dict = field(init=False, repr=False, compare=False)

    def __post_init__(self):
        by_name, owner = {}, {}
        for entry in (*self.registers, *self.windows):
            if entry.name in by_name:
                raise AddressClash(f"two registers are called {entry.name}")
            by_name[entry.name] = entry
            for address in entry.addresses:
                if not 0 <= address < 1 << ADDRESS_BITS:
                    raise AddressClash(f"{entry.name} has the address {address:#x}, there are {ADDRESS_BITS} bits")
                if address in owner:
                    raise AddressClash(f"{entry.name} and {owner[address]} both have the address {address:#06x}")
                owner[address] = entry.name
        for register in self.registers:
            taken = 0
            for part in register.fields:
                mask = (1 << part.width) - 1 << part.low
                if mask >> register.width or mask & taken:
                    raise AddressClash(f"the field {part.name} of {register.name} overlaps another or stands outside")
                taken |= mask
        object.__setattr__(self, "_by_name", by_name)

    def __getitem__(self, name: str):
        return self._by_name[name]

    def __iter__(self):
        return iter(self._by_name)

    def __len__(self):
        return len(self._by_name)

    def suggestion(self, name: str) -> str | None:
        """The name most like `name`, None when none is near."""
        return next(iter(get_close_matches(name, self._by_name, 1)), None)
