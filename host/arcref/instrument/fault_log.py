"""What the instrument keeps of each fault: how often its cause was met, and where and when its flag went up."""

from arcref.flags import FAULT_FLAGS, FLAG_MEANINGS, Flag
from arcref.instrument.register_access import RegisterAccess
from arcref.link.registers import fault_key
from arcref.zero_return.instrument_parts import FaultRecord


class FaultLog:
    """The counts as they stood when this was made, to tell what came since."""

    def __init__(self, registers: RegisterAccess):
        self._registers = registers
        self._counts = {flag: self._count(flag) for flag in FLAG_MEANINGS if flag & FAULT_FLAGS}

    def since(self, flags: Flag, sample_rate_hz: float, start_s: float) -> tuple[FaultRecord, ...]:
        """A record for each fault of `flags`, all of which were cleared when this was made. Times from `start_s` on."""
        return tuple(
            FaultRecord(
                FLAG_MEANINGS[flag].name,
                FLAG_MEANINGS[flag].action,
                self._count(flag) - before,
                self._registers.read(f"{fault_key(flag)}_first_position"),
                self._registers.read(f"{fault_key(flag)}_first_time") / sample_rate_hz - start_s,
            )
            for flag, before in self._counts.items()
            if flags & flag
        )

    def _count(self, flag: Flag) -> int:
        return self._registers.read(f"{fault_key(flag)}_count")
