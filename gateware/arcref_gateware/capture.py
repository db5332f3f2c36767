"""The captured record of a strobe: raw and corrected position and time of its due sample."""

from amaranth.hdl import Cat, Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import POSITION_BITS
from arcref_gateware.correction import CORRECTION_BITS
from arcref_gateware.position import POSITION_SEGMENTS, segments_of
from arcref_gateware.register_stages import aligned, delayed, skewed_add

CORRECTED_CLOCKS = len(POSITION_SEGMENTS)
"""Clocks from segment 0 of a raw position, and its correction, to the corrected position."""


def corrected_position(m: Module, raw, complement, active, *, name: str):
    """`raw` and `raw` + `complement` + `active`, `CORRECTED_CLOCKS` clocks later: what `Correction` gives, taken off.

    `raw` comes a segment a clock, the results whole.
    """
    segments = segments_of(raw)
    corrected = skewed_add(m, segments, complement, carry_in=active, name=name)
    whole_raw = aligned(m, segments, name=f"{name}_raw")
    return (
        delayed(m, whole_raw, 1, name=f"{name}_raw_out").as_signed(),
        aligned(m, corrected, name=f"{name}_aligned").as_signed(),
    )


class Capture(wiring.Component):
    """Makes the record of an event, 1 + `CORRECTED_CLOCKS` clocks after segment 0 of its word's position."""

    def __init__(self, samples_per_word: int):
        super().__init__(
            {
                "event": In(1),
                "sample": In(exact_log2(samples_per_word)),
                "position": In(signed(POSITION_BITS)),
                "way_back": In(signed(3)),
                "complement": In(signed(CORRECTION_BITS)),
                "active": In(1),
                "words": In(POSITION_BITS),
                "valid": Out(1),
                "corrected": Out(signed(POSITION_BITS)),
                "raw": Out(signed(POSITION_BITS)),
                "time": Out(POSITION_BITS),
            }
        )

    event: In
    """1 when the word has an event, with segment 0 of `position`."""
    sample: In
    """Number of the event's sample in its word, with `event`."""
    position: In
    """Position after the word, a segment a clock."""
    way_back: In
    """Minus the sum of the word's steps after the event, with segment 0 of `position`."""
    complement: In
    """Complement of the event's correction, a clock after `event`; see `Correction`."""
    active: In
    """1 when the word is corrected, with `complement`."""
    words: In
    """Number of the event's word, with the outputs."""
    valid: Out
    """1 for one clock with each record."""
    corrected: Out
    """Corrected position at the event, in counts."""
    raw: Out
    """Raw position at the event, in counts."""
    time: Out
    """The event's sample, in sample periods since reset."""

    def elaborate(self, platform):
        m = Module()
        at_event = Cat(skewed_add(m, segments_of(self.position), self.way_back, name="at_event"))
        raw, corrected = corrected_position(m, at_event, self.complement, self.active, name="corrected")
        m.d.comb += [
            self.raw.eq(raw),
            self.corrected.eq(corrected),
            self.valid.eq(delayed(m, self.event, 1 + CORRECTED_CLOCKS, name="valid")),
            self.time.eq(Cat(delayed(m, self.sample, 1 + CORRECTED_CLOCKS, name="sample"), self.words)),
        ]
        return m
