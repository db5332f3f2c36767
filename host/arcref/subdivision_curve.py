"""The error of the encoder within one grating line (sub-divisional error), as a calibration gives it."""

from dataclasses import dataclass, field

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.calibration_file import read_calibration
from arcref.input_error import InputError

FEWEST_POINTS = 8
"""Errors of order 4 within a line are usual; fewer points than this cannot show them."""


@dataclass(frozen=True, eq=False)
class SubdivisionCurve:
    """Errors (reading - true angle) over one grating line, which repeats 4096 times a turn.

    `line_deg`: float64[n], increasing, 360 to a line, first to last less than 360 apart; `error_arcsec`: float64[n].
    The phase is that of the reading, zero where the count is a multiple of a line. `u_arcsec`: standard uncertainty
    (k=1) of each error, or None when none is stated.
    """

    line_deg: np.ndarray
    error_arcsec: np.ndarray
    provenance: dict = field(default_factory=dict)
    u_arcsec: np.ndarray | None = None

    @classmethod
    def from_calibration_json(cls, path) -> "SubdivisionCurve":
        """Read the curve of a `CAL.json` of kind subdivision.

        Raises `InputError` as `read_calibration` does, for a disc of other than 4096 lines, for fewer than eight
        points, and for phases that do not increase or span a line or more.
        """
        calibration = read_calibration(path, ("subdivision",))
        lines = calibration.results.get("line_count", LINES_PER_TURN)
        if lines != LINES_PER_TURN:
            problem = f"is {lines!r:.40}, {LINES_PER_TURN} lines were expected: those of the disc that the ROM is for"
            raise InputError.at(path, problem, column="results.line_count")
        phase = calibration.angle_deg
        if phase.size < FEWEST_POINTS:
            problem = f"has {phase.size} points, at least {FEWEST_POINTS} were expected"
            raise InputError.at(path, problem, column="curve.line_deg")
        bad = np.flatnonzero((np.diff(phase) <= 0) | (phase[1:] >= phase[0] + 360.0))
        if bad.size:
            index = int(bad[0]) + 1
            problem = f"is {phase[index]:g}, increasing phases within 360 deg of the first were expected"
            raise InputError.at(path, problem, column=f"curve.line_deg[{index}]")
        record = calibration.file.record | {"kind": calibration.kind, "provenance": calibration.provenance}
        return cls(phase, calibration.error_arcsec, {"inputs": [record]}, calibration.u_arcsec)

    def evaluate(self, line_deg) -> np.ndarray:
        """The error in arcsec at the phases `line_deg` of a line, straight from point to point around the line."""
        return np.interp(line_deg, self.line_deg, self.error_arcsec, period=360.0)
