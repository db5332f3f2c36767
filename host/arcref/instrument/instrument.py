"""One instrument on a serial port: who it is, its registers, and where its shaft stands."""

from collections.abc import Callable
from typing import Self

from arcref.flags import FAULT_FLAGS, Flag
from arcref.instrument.identity import Identity, read_identity
from arcref.instrument.kept_link import KeptLink
from arcref.instrument.register_access import RegisterAccess
from arcref.instrument.snapshot import Snapshot, read_snapshot
from arcref.link.capture_record import CaptureRecord, Gap, Overrun
from arcref.link.packet import DEFAULT_BAUD


class Instrument:
    """One instrument on a serial port, a context manager whose quantities are attributes.

    `port`: its name; None takes the one that `ARCREF_PORT` names, or the only one plugged in. When the port went away,
    each request tries once whether it is back. `on_record` is given what streams from it, by the thread that reads the
    port. Raises `InputError` when the port cannot be used, `InstrumentError` when the instrument does not answer as it
    should.
    """

    def __init__(
        self,
        port: str | None = None,
        *,
        baud: int = DEFAULT_BAUD,
        on_record: Callable[[CaptureRecord | Overrun | Gap], None] | None = None,
    ):
        self._kept = KeptLink(port, baud, on_record)
        self._identity: Identity | None = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception) -> None:
        self.close()

    def close(self) -> None:
        """Close the port."""
        self._kept.close()

    @property
    def port(self) -> str:
        """Name of the serial port."""
        return self._kept.name

    @property
    def interruptions(self) -> int:
        """Times that the port went away and was opened again."""
        return self._kept.interruptions

    @property
    def registers(self) -> RegisterAccess:
        """Every register as an attribute."""
        return self._kept.registers

    @property
    def identity(self) -> Identity:
        """Gateware, clocks and calibration; read once, and anew after a trial was loaded."""
        if self._identity is None:
            self._identity = read_identity(self.registers)
        return self._identity

    def snapshot(self) -> Snapshot:
        """Position, raw position, time and flags of one instant."""
        sample_rate_hz = self.identity.sample_rate_hz
        return read_snapshot(self._kept.link, sample_rate_hz)

    @property
    def angle_deg(self) -> float:
        """Corrected angle now, 0 .. 360 deg."""
        return self.snapshot().angle_deg

    @property
    def position(self) -> int:
        """Corrected position now, in counts, turns included."""
        return self.snapshot().position

    @property
    def flags(self) -> Flag:
        """The flags now."""
        return Flag(self.registers.flags & 0xFF)

    def clear_flags(self, flags: Flag = FAULT_FLAGS) -> None:
        """Clear fault flags, all unless told which."""
        self.registers.clear_flags = int(flags)

    def home(self) -> None:
        """Let the next index set the zero again."""
        self.registers.home = 1
