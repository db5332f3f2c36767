"""From the course of a zero-return test on an instrument to its result."""

from datetime import UTC, datetime

import numpy as np

from arcref import __version__
from arcref.angle import COUNTS_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.flags import FAULT_FLAGS, Flag
from arcref.instrument.identity import read_identity
from arcref.instrument.instrument import Instrument
from arcref.instrument.zero_return_course import ZeroReturnCourse
from arcref.zero_return.instrument_parts import InstrumentParts
from arcref.zero_return.result import ZeroReturnResult

STANDING_PART = 0.01
"""Below this part of the fastest speed the shaft counts as standing, and does not enter the usual speed."""


def summary(
    instrument: Instrument, course: ZeroReturnCourse, driven_by: str, rom: CorrectionRom | None
) -> ZeroReturnResult:
    """The result of a course that has run."""
    identity, states, end = read_identity(instrument.registers), course.states, course.states[-1]
    rate_hz, start_s = identity.sample_rate_hz, course.start.time_s
    time_s = np.array([state.time_s - start_s for state in states])
    raw = np.array([state.raw_position for state in states])
    usual_rps, fastest_rps = _speeds(time_s, raw)
    flags = course.flags & FAULT_FLAGS
    # The count stays at its end, and then only the flag tells.
    illegal_steps = max(end.illegal_steps - course.start.illegal_steps, int(bool(flags & Flag.ILLEGAL_STEP)))
    calibration = identity.rom.values if identity.rom else {}
    return ZeroReturnResult(
        speed_rps=usual_rps,
        revolutions=course.revolutions,
        samples_per_word=identity.samples_per_word,
        sample_rate_hz=rate_hz,
        counts=int(np.abs(np.diff(raw)).sum()),
        index_passes=course.passes.finished(end.largest_closure_error),
        illegal_steps=illegal_steps,
        flags=int(course.flags),
        shortest_edge_spacing_samples=end.shortest_edge_spacing,
        first_turn=course.first_turn,
        instrument=InstrumentParts(
            port=instrument.port,
            driven_by=driven_by,
            fastest_rps=fastest_rps,
            further_marks=course.passes.further,
            largest_closure_error_counts=end.largest_closure_error,
            rom_state=identity.rom_state,
            rom_readings_wrong=None if rom is None else _wrong_readings(states, rom),
            faults=course.fault_log.since(flags, rate_hz, start_s),
            time_s=time_s,
            raw_position_counts=raw,
        ),
        provenance={
            "arcref_version": __version__,
            "date": datetime.now(UTC).isoformat(timespec="seconds"),
            "gateware": identity.gateware,
            "rom_crc32": f"0x{identity.rom_crc32:08X}",
            "rom_is_trial": identity.rom_is_trial,
            "rom": calibration,
        },
    )


def _speeds(time_s: np.ndarray, raw: np.ndarray) -> tuple[float, float]:
    """Median and largest speed between readings, both as sizes; the shaft standing is left out of the median."""
    elapsed = np.diff(time_s)
    speeds = np.abs(np.diff(raw)[elapsed > 0] / elapsed[elapsed > 0]) / COUNTS_PER_TURN
    fastest = float(speeds.max())
    return float(np.median(speeds[speeds > STANDING_PART * fastest])), fastest


def _wrong_readings(states: list, rom: CorrectionRom) -> int:
    """Readings that are not corrected as `rom` says; those that are not corrected at all are among them."""
    raw, position = (np.array([getattr(state, name) for state in states]) for name in ("raw_position", "position"))
    active = np.array([bool(state.flags & Flag.CORRECTION_ACTIVE) for state in states])
    return int(np.count_nonzero(~active | (rom.correct(raw) != position)))
