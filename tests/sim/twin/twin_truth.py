"""Holds what the host was told against where the shaft was."""

import time

import numpy as np

from arcref_sim.twin.twin import Twin

NEAR_SAMPLES = 1e-3
"""An edge this near a sample may be seen in it or in the one before: times are floating-point numbers."""


def assert_counts(twin: Twin, sample, raw) -> None:
    """`raw` are the counts that the square waves showed at `sample`."""
    sample, raw = np.atleast_1d(sample), np.atleast_1d(raw)
    before, after = (twin.encoder.ideal_count_at(sample + shift) for shift in (-NEAR_SAMPLES, NEAR_SAMPLES))
    wrong = np.flatnonzero((raw != before) & (raw != after))
    assert len(wrong) == 0, f"{len(wrong)} of {len(raw)}: {raw[wrong[:3]]} at {sample[wrong[:3]]}, {before[wrong[:3]]}"
    assert np.mean(before == after) > 0.9 or len(raw) < 100


def assert_captures(twin: Twin, captures) -> None:
    """Raw position, correction and time of every capture are true, and none was lost."""
    assert not captures["lost_before"].any()
    assert_counts(twin, captures["time_samples"], captures["raw_position_counts"])
    assert np.array_equal(captures["position_counts"], twin.rom.correct(captures["raw_position_counts"]))


def wait_until(condition, timeout_s: float = 60.0) -> None:
    """Until `condition()` holds."""
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline, "it never came true"
        time.sleep(0.02)


def wait_until_homed(twin: Twin) -> None:
    """Until the zero mark was met and the correction is on."""
    wait_until(lambda: twin.status().flags & 2 and twin.status().homed)
