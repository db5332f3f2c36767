"""Parts of a result that come from an instrument, where the shaft's way is measured and not planned."""

from dataclasses import dataclass, field

import numpy as np

NOT_CHECKED = {
    "the angle's true error": "an instrument does not know the true angle; calibrate it, and verify with a polygon",
    "counts lost and found again": "what is lost and gained again between two zero marks does not show at them",
    "core against golden model": "that needs every sample of A and B; `arcref simulate zero-return` compares them",
    "SPI frames": "this test reads over the serial link",
}
"""What the simulated test checks and a test on an instrument cannot, each with the reason."""


@dataclass(frozen=True)
class FaultRecord:
    """One fault flag that went up: in how many words its cause was met, where and when it went up first, what to do."""

    name: str
    action: str
    words: int
    position_counts: int
    time_s: float


@dataclass(frozen=True)
class InstrumentParts:
    """What was measured beside the counts.

    `driven_by`: what turned the shaft. `fastest_rps`: highest mean speed from one reading to the next. `further_marks`:
    zero marks that came between two readings as the shaft went to and fro over one. `largest_closure_error_counts`:
    over every zero mark of the test, kept by the instrument. `rom_state` at the end. `rom_readings_wrong`: readings
    whose correction is not the ROM image's, None when no image was given. `time_s` from the test's start and
    `raw_position_counts`: the shaft's way as it was read.
    """

    port: str
    driven_by: str
    fastest_rps: float
    further_marks: int
    largest_closure_error_counts: int
    rom_state: str
    rom_readings_wrong: int | None
    faults: tuple[FaultRecord, ...]
    time_s: np.ndarray = field(repr=False)
    raw_position_counts: np.ndarray = field(repr=False)

    @property
    def readings(self) -> int:
        """Readings taken."""
        return len(self.time_s)

    @property
    def duration_s(self) -> float:
        """Time from the first reading to the last."""
        return float(self.time_s[-1] - self.time_s[0])

    @property
    def readings_per_s(self) -> float:
        """Mean rate of the readings."""
        return (self.readings - 1) / self.duration_s if self.duration_s > 0 else 0.0

    def to_json(self) -> dict:
        """The figures for a program."""
        return {
            "port": self.port,
            "driven_by": self.driven_by,
            "fastest_rps": self.fastest_rps,
            "further_zero_marks": self.further_marks,
            "largest_closure_error_counts": self.largest_closure_error_counts,
            "rom_state": self.rom_state,
            "readings": self.readings,
            "readings_per_s": self.readings_per_s,
            "readings_off_the_rom": self.rom_readings_wrong,
            "duration_s": self.duration_s,
            "faults": [
                {
                    "fault": fault.name,
                    "words": fault.words,
                    "position_counts": fault.position_counts,
                    "time_s": fault.time_s,
                }
                for fault in self.faults
            ],
            "not_checked": list(NOT_CHECKED),
        }
