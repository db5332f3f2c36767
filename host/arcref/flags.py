"""The eight flags of the instrument: which bit is which, and what it tells a person.

This is the one place that says so. The gateware, the frame decoder, the manual and the tests read it.
"""

from dataclasses import dataclass
from enum import IntFlag


class Flag(IntFlag):
    """Flag bits of the position frame (bits 39..32) and of the core's port `flags`."""

    LAST_DIRECTION_REVERSE = 1 << 0
    CORRECTION_ACTIVE = 1 << 1
    EDGE_SPACING_LIMIT = 1 << 2
    ROM_FAULT = 1 << 3
    CAPTURE_OVERRUN = 1 << 4
    INDEX_FAULT = 1 << 5
    CLOSURE_ERROR = 1 << 6
    ILLEGAL_STEP = 1 << 7


STATUS_FLAGS = Flag.LAST_DIRECTION_REVERSE | Flag.CORRECTION_ACTIVE
"""Flags that follow the present state. All others are faults: sticky until cleared by command."""

FAULT_FLAGS = Flag(0xFF) & ~STATUS_FLAGS
"""Flags that are raised by a fault and stay until they are cleared by command."""


@dataclass(frozen=True)
class FlagMeaning:
    """What one flag says, in words.

    `name` is a short title, `meaning` says what happened and `action` what to do about it.
    """

    name: str
    meaning: str
    action: str


FLAG_MEANINGS: dict[Flag, FlagMeaning] = {
    Flag.ILLEGAL_STEP: FlagMeaning(
        "illegal step",
        "A and B changed in the same sample, so the direction is unknown and nothing was counted.",
        "The count is off by 2 or by nothing. Look for noise on A or B, or for a speed beyond the samples.",
    ),
    Flag.CLOSURE_ERROR: FlagMeaning(
        "closure error",
        "The zero mark came back at another count than a whole turn, less than one grating line away.",
        "Counts were lost or added since the last good zero mark. Read closure_error for how many; home again.",
    ),
    Flag.INDEX_FAULT: FlagMeaning(
        "index missing or unexpected",
        "A whole turn went by without a zero mark, or a zero mark came more than one grating line from its place.",
        "Look at the Z line, its width and its gate state, and for noise on it.",
    ),
    Flag.CAPTURE_OVERRUN: FlagMeaning(
        "capture overrun",
        "A strobe came while 16 others waited for their delay, or two fell due in one sample word; it was refused.",
        "Strobe less often or set a shorter delay.",
    ),
    Flag.ROM_FAULT: FlagMeaning(
        "ROM fault",
        "The correction tables did not match their CRC at power-up, so the correction is off.",
        "Build or patch the bitstream again from a good ROM image.",
    ),
    Flag.EDGE_SPACING_LIMIT: FlagMeaning(
        "edge spacing at the limit",
        "Two edges of A and B were one sample apart. No count is lost yet, but there is no margin.",
        "Turn slower, raise the sample rate, or look for bunched or noisy edges.",
    ),
    Flag.CORRECTION_ACTIVE: FlagMeaning(
        "correction active",
        "The angle is corrected from the ROM.",
        "When it is 0 the angle is not corrected: the encoder has not met its zero mark yet, or the ROM has a fault.",
    ),
    Flag.LAST_DIRECTION_REVERSE: FlagMeaning(
        "last direction",
        "The last count went in reverse (B leading A).",
        "No action: 0 is forward, 1 is reverse.",
    ),
}
"""Every flag, most significant bit first."""


def describe_faults(flags: int) -> list[str]:
    """The names of the fault flags that are up, most significant bit first.

    >>> describe_faults(0b1100_0010)
    ['illegal step', 'closure error']
    """
    return [meaning.name for flag, meaning in FLAG_MEANINGS.items() if flags & flag & FAULT_FLAGS]
