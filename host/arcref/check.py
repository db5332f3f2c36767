"""One line of a verdict, as calibrations and the zero-return test give them."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """What must hold, as a sentence, what was found, and whether it holds."""

    sentence: str
    found: str
    passed: bool
