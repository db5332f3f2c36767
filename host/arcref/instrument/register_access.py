"""The registers as attributes: `registers.strobe_delay`, `registers.strobe_delay = 4000`."""

from collections.abc import Sequence

from arcref.input_error import InputError
from arcref.link.link import Link
from arcref.link.packet import MOST_WORDS
from arcref.link.register import Access, Register
from arcref.link.registers import REGISTERS


class RegisterAccess:
    """Every register of `arcref.link.registers` by name. Misspelt names and values out of range raise `InputError`."""

    def __init__(self, link: Link):
        object.__setattr__(self, "_link", link)

    def __dir__(self):
        return sorted(register.name for register in REGISTERS.registers)

    def __getattr__(self, name: str) -> int:
        return self.read(name)

    def __setattr__(self, name: str, value: int) -> None:
        self.write(name, value)

    def read(self, name: str) -> int:
        """The value of a register."""
        register = find_register(name)
        if register.access is Access.COMMAND:
            raise InputError(f"the register {name} is a command, it can only be written")
        return register.decode(self._link.read_words(register.address, register.words, f"read of {name}"))

    def write(self, name: str, value: int) -> None:
        """Write a register, and return when the instrument says that it took."""
        register = find_register(name)
        if register.access is Access.READ:
            raise InputError(f"the register {name} can only be read")
        if isinstance(value, bool):
            value = int(value)
        if not isinstance(value, int):
            raise InputError(f"{name} is {value!r}, a whole number was expected")
        try:
            words = register.encode(value)
        except ValueError as error:
            raise InputError(str(error)) from None
        self._link.write_words(register.address, words, f"write of {name}")

    def read_together(self, names: Sequence[str]) -> dict[str, int]:
        """The values of registers that stand near one another, by one request, one right after the other."""
        registers = [find_register(name) for name in names]
        first = min(register.address for register in registers)
        end = max(register.addresses[-1] for register in registers) + 1
        words = self._link.read_words(first, end - first, f"read of {', '.join(names)}")
        return {
            register.name: register.decode(words[register.address - first :][: register.words])
            for register in registers
        }

    def read_window(self, name: str) -> list[int]:
        """All words of a memory window."""
        window = REGISTERS[name]
        words = []
        for first in range(0, window.words, MOST_WORDS):
            count = min(MOST_WORDS, window.words - first)
            words += self._link.read_words(window.address + first, count, f"read of {name}")
        return words

    def write_window(self, name: str, first: int, words: list[int]) -> None:
        """Write words of a memory window from place `first` on, `MOST_WORDS` at the most."""
        window = REGISTERS[name]
        if not 0 <= first <= first + len(words) <= window.words:
            raise ValueError(f"{name} has {window.words} words")
        self._link.write_words(window.address + first, words, f"write of {name}")


def find_register(name: str) -> Register:
    """The register of that name. Raises `InputError` that suggests the near one."""
    register = REGISTERS.get(name)
    if isinstance(register, Register):
        return register
    if register is not None:
        raise InputError(f"{name} is a memory of {register.words} words, a register was expected")
    near = REGISTERS.suggestion(name)
    hint = f"; did you mean {near}?" if near else "; `arcref registers` lists them"
    raise InputError(f"there is no register {name!r}{hint}")
