"""The captured record of a strobe: raw and corrected position and time of its due sample."""

from amaranth.hdl import Cat, Module, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import POSITION_BITS
from arcref_gateware.correction import CORRECTION_BITS
from arcref_gateware.register_stages import delayed, pipeline_clocks, pipelined_add

CORRECTED_SEGMENT_BITS = 16
"""Segment of the last addition, which has no other logic before its carry chain."""

RAW_CLOCKS = pipeline_clocks(POSITION_BITS)
"""Clocks from a word's position to the raw position at an event in it."""

CORRECTED_CLOCKS = pipeline_clocks(POSITION_BITS, CORRECTED_SEGMENT_BITS)
"""Clocks from a raw position and its correction to the corrected position."""


def corrected_position(m: Module, raw, complement, active, *, name: str):
    """`raw` + `complement` + `active`, `CORRECTED_CLOCKS` clocks later: what `Correction` gives, taken off."""
    return pipelined_add(m, raw, complement, carry_in=active, name=name, segment_bits=CORRECTED_SEGMENT_BITS)


class Capture(wiring.Component):
    """Makes the record of an event, `RAW_CLOCKS` + `CORRECTED_CLOCKS` clocks after its word's position."""

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
    """1 when the word has an event, with `position`."""
    sample: In
    """Number of the event's sample in its word, with `position`."""
    position: In
    """Position after the word."""
    way_back: In
    """Minus the sum of the word's steps after the event, with `position`."""
    complement: In
    """Complement of the event's correction, `RAW_CLOCKS` clocks after `position`; see `Correction`."""
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
        raw = pipelined_add(m, self.position, self.way_back, name="raw")
        whole = RAW_CLOCKS + CORRECTED_CLOCKS
        m.d.comb += [
            self.corrected.eq(corrected_position(m, raw, self.complement, self.active, name="corrected")),
            self.raw.eq(delayed(m, raw, CORRECTED_CLOCKS, name="raw_out")),
            self.valid.eq(delayed(m, self.event, whole, name="valid")),
            self.time.eq(Cat(delayed(m, self.sample, whole, name="sample"), self.words)),
        ]
        return m
