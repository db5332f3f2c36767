"""The zero-return test on an instrument: full turns forward, the same turns back, and every zero mark on its count.

The shaft is turned by the user or by the on-board test generator. The instrument itself judges every index against
the count; this test follows its registers, sees that every mark came in both directions, and gathers the verdict.
"""

import contextlib
import sys
from collections.abc import Callable

from arcref.correction_rom import CorrectionRom
from arcref.input_error import InputError
from arcref.instrument.instrument import Instrument
from arcref.instrument.shaft_drive import shaft_drive
from arcref.instrument.zero_return_course import ZeroReturnCourse
from arcref.instrument.zero_return_leg import ZeroReturnProgress
from arcref.instrument.zero_return_summary import summary
from arcref.instrument_error import InstrumentError
from arcref.zero_return.result import ZeroReturnResult

READINGS_PER_S = 50.0

MOST_REVOLUTIONS = 1000


def hardware_zero_return(
    instrument: Instrument,
    *,
    revolutions: int = 10,
    generator_speed_rps: float | None = None,
    generator_fault: str | None = None,
    rehome: bool = False,
    rom: CorrectionRom | None = None,
    timeout_s: float = 60.0,
    readings_per_s: float = READINGS_PER_S,
    progress: Callable[[ZeroReturnProgress], None] = lambda state: None,
    ask: Callable[[str], None] = lambda line: print(line, file=sys.stderr),
) -> ZeroReturnResult:
    """Run the test and return all it found; whether that passes, `result.passed` says.

    `generator_speed_rps`: let the test generator turn; where it turns in place of the shaft already, as it does from
    power-up in a self-test bitstream, it is used at its own speed unless told otherwise. Without it the user is asked
    to turn, by lines given to `ask`. `generator_fault`: one of `GENERATOR_FAULTS` for the generator to make.
    Fault flags are cleared at the start. The zero stays where it is, unless `rehome` (which the generator needs when
    the instrument is homed, because its zero mark is elsewhere) or when there is none yet. With `rom` every reading is
    compared with that image. Raises `InputError` for what cannot be done, `InstrumentError` when the shaft does not
    turn for `timeout_s`, no zero mark comes, or the instrument goes away.
    """
    if not 0 <= revolutions <= MOST_REVOLUTIONS:
        raise InputError(f"{revolutions} revolutions were asked for, 0 .. {MOST_REVOLUTIONS} were expected")
    if not (timeout_s > 0 and 0 < readings_per_s < float("inf")):
        raise InputError("time-out and readings a second must be above 0")
    identity = instrument.identity
    if rom is not None and rom.crc32 != identity.rom_crc32:
        raise InputError(
            f"the ROM image has CRC-32 0x{rom.crc32:08X}, the instrument carries 0x{identity.rom_crc32:08X}: "
            "it belongs to another encoder or another calibration"
        )
    drive = shaft_drive(instrument, generator_speed_rps, generator_fault, ask, may_home=rehome)
    course = ZeroReturnCourse(instrument, revolutions, timeout_s, readings_per_s, progress, ask)
    try:
        course.run(drive, rehome)
    except BaseException:
        with contextlib.suppress(InstrumentError):  # the port may be gone, and that is told already
            drive.stop()
        raise
    drive.stop()
    return summary(instrument, course, drive.name, rom)
