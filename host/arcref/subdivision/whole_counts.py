"""Counts in run files of kind subdivision: whole, and of an encoder with as many lines as arcref's."""

import numpy as np

from arcref.angle import LINES_PER_TURN
from arcref.calibration.stated_values import stated_number


def whole_counts(run, column: str) -> np.ndarray:
    """The counts of a column, float64[n]. Raises `InputError` for one that is not whole."""
    values = run[column]
    fraction = np.flatnonzero((values != np.rint(values)) | (np.abs(values) > 2.0**47))
    if fraction.size:
        index = int(fraction[0])
        raise run.error(f"{values[index]:.12g} is no whole count", reading=index, column=column)
    return values


def check_line_count(run) -> None:
    """Raises `InputError` when the file states another number of lines: its counts would have other phases."""
    lines = stated_number(run, "line_count")
    if lines is not None and lines != LINES_PER_TURN:
        problem = f"{lines:g} lines, {LINES_PER_TURN} were expected: the phase of a count rests on them"
        raise run.metadata_error("line_count", problem)
