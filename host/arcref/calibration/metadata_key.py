"""What a metadata key of run files is: kinds of run, groups of keys, and one key with its unit and meaning."""

import math
from dataclasses import dataclass

POLYGON, CLOSURE, THEODOLITE, SUBDIVISION = "polygon", "closure", "theodolite", "subdivision"
EVERY = (POLYGON, CLOSURE, THEODOLITE, SUBDIVISION)
FACES = (POLYGON, CLOSURE)
SEEN = (*FACES, SUBDIVISION)

IDENTIFICATION, CONDITIONS, METHOD, UNCERTAINTY = "identification", "conditions", "method", "uncertainty"


@dataclass(frozen=True)
class MetadataKey:
    """One key: `name` as it stands behind `#`; `kinds` of run that use it; `group`, where a report shows it.

    `unit`: of its number, "1" for a number without one, None when its value is text. `lowest`: least number allowed.
    """

    name: str
    group: str
    meaning: str
    kinds: tuple[str, ...] = EVERY
    unit: str | None = None
    lowest: float = -math.inf

    @property
    def label(self) -> str:
        """The name as people read it, without the unit: `encoder_serial` is "encoder serial"."""
        words = self.name.split("_")
        return " ".join(words if self.unit in (None, "1") else words[:-1])

    @property
    def description(self) -> str:
        """The meaning as a sentence of the manual, which says of an uncertainty that it is a standard one."""
        return f"standard uncertainty {self.meaning}" if self.name.startswith("u_") else self.meaning
