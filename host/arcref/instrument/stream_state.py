"""What must not change while captures stream: the instrument's settings, its zero and its clock."""

from dataclasses import dataclass

from arcref.instrument.instrument import Instrument
from arcref.link.link import LinkLost
from arcref.link.register import Access
from arcref.link.registers import REGISTERS

SETTINGS = tuple(
    register.name
    for register in REGISTERS.registers
    if register.access is Access.WRITE and not register.name.startswith(("capture_", "generator_"))
)


@dataclass(frozen=True)
class StreamState:
    """`settings`: every one by name; `time_s`: since the instrument's reset; `homed`: whether the zero is known."""

    settings: dict[str, int]
    time_s: float
    homed: bool

    @classmethod
    def of(cls, instrument: Instrument) -> "StreamState":
        """Read it. Raises `InstrumentError` as `Instrument` does."""
        snapshot = instrument.snapshot()
        return cls(instrument.registers.read_together(SETTINGS), snapshot.time_s, snapshot.homed)

    def check(self, now: "StreamState", port: str) -> None:
        """Raises `LinkLost` when the instrument was switched off between this and `now`."""
        changed = [
            f"{name} is {now.settings[name]} and was {value}"
            for name, value in self.settings.items()
            if now.settings[name] != value
        ]
        if now.time_s < self.time_s or (self.homed and not now.homed):
            changed.append("its clock began anew" if now.time_s < self.time_s else "its zero is gone")
        if changed:
            raise LinkLost(
                f"{port} came back, but the instrument had been switched off meanwhile ({'; '.join(changed)}): "
                "set it up, turn it past the zero mark and start again"
            )
