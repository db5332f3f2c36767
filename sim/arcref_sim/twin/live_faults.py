"""Faults by name, put between encoder and instrument a moment ahead."""

from collections.abc import Callable
from dataclasses import dataclass

from arcref.angle import COUNTS_PER_TURN
from arcref_gateware.golden.signal_changes import Z_BIT
from arcref_sim.faults import (
    LineHold,
    double_transition,
    dropped_pulses,
    extra_pulses,
    glitch,
    noise_glitches,
    slip,
)
from arcref_sim.twin.live_encoder import LiveEncoder

AHEAD_SAMPLES = 64
NOISE_S = 1e-3
"""How long noise lasts."""

EXTRA_MARK_COUNTS = 50_000
"""How far ahead a zero mark comes that does not belong there."""

Z_LINE = 1 << Z_BIT


def _drop(encoder: LiveEncoder, periods: int) -> None:
    speed = abs(encoder.speed_rps)
    if not speed:
        raise ValueError("pulses are dropped while the shaft turns; it stands")
    start = encoder.sample + AHEAD_SAMPLES
    samples = 4 * periods / (speed * COUNTS_PER_TURN) * encoder.sample_rate_hz
    encoder.add_faults(dropped_pulses(start, start + max(round(samples), 1)))


def _extra(encoder: LiveEncoder, periods: int) -> None:
    encoder.add_faults(extra_pulses(encoder.sample + AHEAD_SAMPLES, 4, periods))


def _slip(encoder: LiveEncoder, counts: int) -> None:
    encoder.add_faults(slip(encoder.sample + AHEAD_SAMPLES, counts))


def _illegal(encoder: LiveEncoder, number: int) -> None:
    for place in range(number):
        encoder.add_faults(double_transition(encoder.sample + AHEAD_SAMPLES * (1 + place), 4))


def _glitch(encoder: LiveEncoder, samples: int) -> None:
    encoder.add_faults(glitch(encoder.sample + AHEAD_SAMPLES, samples))


def _noise(encoder: LiveEncoder, number: int) -> None:
    start = encoder.sample + AHEAD_SAMPLES
    end = start + round(NOISE_S * encoder.sample_rate_hz)
    encoder.add_faults(noise_glitches(start, end, number, seed=encoder.sample))


def _index_missing(encoder: LiveEncoder, number: int) -> None:
    for _ in range(number):
        encoder.drop_next_zero_mark()


def _index_extra(encoder: LiveEncoder, counts: int) -> None:
    encoder.add_zero_mark(counts)


def _index_stuck(encoder: LiveEncoder, microseconds: int) -> None:
    start = encoder.sample + AHEAD_SAMPLES
    samples = round(microseconds * 1e-6 * encoder.sample_rate_hz)
    encoder.add_faults([LineHold(start, start + max(samples, 1), Z_LINE, Z_LINE)])


@dataclass(frozen=True)
class NamedFault:
    """One fault: what its number means and is unless given, how large it may be, and what is done."""

    meaning: str
    default: int
    largest: int
    add: Callable[[LiveEncoder, int], None]
    smallest: int = 1


NAMED_FAULTS = {
    "drop": NamedFault("A stays low for N periods, 4 counts each", 1, 1_000_000, _drop),
    "extra": NamedFault("A and B make N periods too many", 1, 100_000, _extra),
    "slip": NamedFault("A and B run N counts ahead of Z from now on; 4 leave no trace", 1, 100_000, _slip, -100_000),
    "illegal": NamedFault("A and B change in one sample, N times", 1, 100, _illegal),
    "glitch": NamedFault("A is wrong for N samples", 1, 1_000_000, _glitch),
    "noise": NamedFault("A is wrong for one sample, N times within 1 ms", 100, 100_000, _noise),
    "index-missing": NamedFault("the next zero mark does not come", 1, 1, _index_missing),
    "index-extra": NamedFault("a zero mark too many, N counts ahead", EXTRA_MARK_COUNTS, 4_000_000, _index_extra),
    "index-stuck": NamedFault("Z stays high for N us", 100, 10_000_000, _index_stuck),
}
"""Faults that can be asked for by name."""


def add_fault(encoder: LiveEncoder, name: str, number: int | None = None) -> None:
    """Put a fault in, a few samples ahead. Raises ValueError for an unknown name or a number out of range."""
    fault = NAMED_FAULTS.get(name)
    if fault is None:
        raise ValueError(f"there is no fault {name!r}; there are {', '.join(NAMED_FAULTS)}")
    number = fault.default if number is None else number
    if not fault.smallest <= number <= fault.largest:
        raise ValueError(f"{name} takes a whole number in {fault.smallest} .. {fault.largest}, not {number}")
    fault.add(encoder, number)
