"""The instrument at one instant: corrected and raw position, time and flags, by one request."""

from dataclasses import dataclass

from arcref.angle import COUNTS_PER_TURN, counts_to_deg
from arcref.flags import Flag
from arcref.link.link import Link
from arcref.link.registers import REGISTERS

_SNAPSHOT_REGISTERS = [REGISTERS[name] for name in REGISTERS if name.startswith("snapshot_")]
_SNAPSHOT_WORDS = sum(register.words for register in _SNAPSHOT_REGISTERS)


@dataclass(frozen=True)
class Snapshot:
    """The instrument at one instant.

    `position`: corrected, `raw_position`: as counted, both in counts and turns included; `time_s`: seconds since the
    instrument's reset; `flags`; `homed`: False until the zero mark was met.
    """

    position: int
    raw_position: int
    time_s: float
    flags: Flag
    homed: bool

    @property
    def angle_deg(self) -> float:
        """Corrected angle, 0 .. 360."""
        return counts_to_deg(self.position % COUNTS_PER_TURN)

    @property
    def turns(self) -> int:
        """Whole turns since the zero mark."""
        return self.position // COUNTS_PER_TURN


def read_snapshot(link: Link, sample_rate_hz: float) -> Snapshot:
    """Take one and read it. Raises `InstrumentError` as `Link.read_words` does."""
    first = _SNAPSHOT_REGISTERS[0].address
    words = link.read_words(first, _SNAPSHOT_WORDS, "read of the position")
    values = {
        register.name: register.decode(words[register.address - first :][: register.words])
        for register in _SNAPSHOT_REGISTERS
    }
    flags, homed = (field.extract(values["snapshot_flags"]) for field in REGISTERS["snapshot_flags"].fields)
    return Snapshot(
        values["snapshot_position"],
        values["snapshot_raw"],
        values["snapshot_time"] / sample_rate_hz,
        Flag(flags),
        bool(homed),
    )
