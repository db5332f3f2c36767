"""Where the words of the registers come from: which stand in the register file's memory, and which are live.

The memory has a word for every address below 256, each at its own address:

    constants          what they are, for good
    settings           what was written last; a copy of their reset values stands at `shadow`
    snapshot, logs     written by `StatusRecorder`
    counted registers  added to by `EventCounters`
    live registers     0: their values are joined to what is read
    commands           0
    no register        the constant that an unknown address reads
"""

from dataclasses import dataclass

from arcref.flags import FAULT_FLAGS, FLAG_MEANINGS, Flag
from arcref.link.register import UNKNOWN_WORD, WORD_BITS, Access, Register
from arcref.link.registers import REGISTERS, fault_key

PLACE_BITS = 8
PLACES = 1 << PLACE_BITS

CONSTANTS = (
    "magic",
    "protocol",
    "gateware",
    "samples_per_word",
    "word_clock_hz",
    "capture_depth",
    "features",
)
"""Registers that are the same for the whole life of a bitstream."""

TALLY_BITS = 7
"""Bits of a count that is told to `EventCounters`; it runs over, and is looked at more than once in so many clocks."""


@dataclass(frozen=True)
class Counted:
    """How a register is counted in the memory.

    `rare`: the events are told by a level that changes with each of them, otherwise by a count of `TALLY_BITS` bits.
    `saturates`: the register stays at its largest value, otherwise it runs over. `cleared`: by `capture_clear`.
    """

    name: str
    rare: bool = False
    saturates: bool = False
    cleared: bool = False

    @property
    def bits(self) -> int:
        """Bits that tell of its events."""
        return 1 if self.rare else TALLY_BITS


def fault_flags() -> list[Flag]:
    """The fault flags in the order of their logs."""
    return [flag for flag in FLAG_MEANINGS if flag & FAULT_FLAGS]


# In the order in which they are looked at; see `EventCounters` for why this order is the cheap one.
COUNTED = (
    *(Counted(f"{fault_key(flag)}_count", saturates=True) for flag in fault_flags()),
    Counted("index_count"),
    Counted("snapshot_number", rare=True),
    Counted("compare_count"),
    Counted("captures", cleared=True),
    Counted("captures_lost", cleared=True),
    Counted("packets_refused", rare=True),
    Counted("link_state", rare=True),
)


def is_recorded(register: Register) -> bool:
    """True for a register that `StatusRecorder` writes into the memory."""
    name = register.name
    return name.endswith(("_first_position", "_first_time")) or (
        name.startswith("snapshot_") and name != "snapshot_number"
    )


def live_registers() -> list[Register]:
    """Registers whose value is an input of the register file."""
    kept = {*CONSTANTS, *(counted.name for counted in COUNTED)}
    return [r for r in REGISTERS.registers if r.access is Access.READ and r.name not in kept and not is_recorded(r)]


def settings() -> list[Register]:
    """Registers that keep what is written."""
    return [r for r in REGISTERS.registers if r.access is Access.WRITE]


def writable_registers() -> list[Register]:
    """Settings and commands."""
    return [r for r in REGISTERS.registers if r.access is not Access.READ]


READABLE_WINDOW = [window.access for window in REGISTERS.windows].index(Access.WRITE)
"""The one window that can be read: the identity's."""


SHADOW_BITS = 0x48
"""Address bits in which the copy of a setting's reset value differs from the setting."""


def shadow(place: int) -> int:
    """Where the copy of the reset value of a setting's word stands."""
    return place ^ SHADOW_BITS


FIRST_SHADOW = 0xC0
"""From here on the memory has words that are no register's; the registers there are those of `REAL_PAIRS`."""

REAL_PAIRS = sorted({place >> 1 for r in REGISTERS.registers for place in r.addresses if place >= FIRST_SHADOW})
"""Pairs of places from `FIRST_SHADOW` on at which a register stands."""

ZERO_PLACE = REGISTERS["strobe_command"].address
"""An even place that holds 0 for good: a command's."""

UNKNOWN_PAIR = PLACES - 2
"""Two places that hold the constant of unknown addresses."""


def initial_words(constants: dict[str, int], resets: dict[str, int]) -> list[int]:
    """The memory's contents at power-up. `resets` gives settings another reset value than the declaration."""
    words = [UNKNOWN_WORD] * PLACES
    for register in REGISTERS.registers:
        value = 0
        if register.name in CONSTANTS:
            value = constants[register.name]
        elif register.access is Access.WRITE:
            value = resets.get(register.name, register.reset)
        for i, place in enumerate(register.addresses):
            words[place] = value >> WORD_BITS * i & 0xFFFF
            if register.access is Access.WRITE:
                words[shadow(place)] = words[place]
    return words


def _check() -> None:
    """What the gateware takes for granted of the declaration."""
    places = {place: r for r in REGISTERS.registers for place in r.addresses}
    shadows = {shadow(place) for r in settings() for place in r.addresses}
    assert max(places) < PLACES
    assert not shadows & places.keys()
    assert min(shadows) >= FIRST_SHADOW
    assert not shadows & {place for pair in REAL_PAIRS for place in (2 * pair, 2 * pair + 1)}
    assert places[ZERO_PLACE].access is Access.COMMAND
    assert ZERO_PLACE % 2 == 0
    assert ZERO_PLACE < FIRST_SHADOW
    assert not {UNKNOWN_PAIR, UNKNOWN_PAIR + 1} & (places.keys() | shadows)
    # The two words of a register are read as one pair.
    assert all(r.words == 1 or r.address % 2 == 0 and r.words == 2 for r in REGISTERS.registers if not is_recorded(r))


_check()
