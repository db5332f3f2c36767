"""Register stages: delays and adders that are cut into segments so that no carry chain limits the word clock."""

from amaranth.hdl import Cat, Const, Module, Signal, signed

SEGMENT_BITS = 12
"""Longest carry chain of a pipelined adder: 1.6 ns on an iCE40-HX, whose carry takes 0.13 ns a bit."""


PACKED_BITS = 64
"""Registers of one delay that are kept in one signal: a simulator moves that many bits in one go."""


def delayed(m: Module, value, clocks: int, *, name: str):
    """`value`, `clocks` later, keeping its shape. Zero clocks give the value itself."""
    width = len(value)
    while clocks and width:
        stages = min(clocks, max(PACKED_BITS // width, 1))
        clocks -= stages
        line = Signal(stages * width, name=f"{name}_{clocks}")
        m.d.sync += line.eq(Cat(value, line))
        last = line[-width:]
        value = last.as_signed() if value.shape().signed else last
    return value


def segment_bounds(width: int, segment_bits: int = SEGMENT_BITS) -> list[tuple[int, int]]:
    """Where a number of `width` bits is cut: `(low, high)` of each segment, the least significant first."""
    return [(low, min(low + segment_bits, width)) for low in range(0, width, segment_bits)]


def add_small_to_segment(m: Module, segment, small, *, name: str, carry_in=None):
    """Register `segment + small + carry_in`, and the carry that the next segment is owed.

    `small` is signed and smaller in size than the segment's range, so the carry is -1, 0 or +1 and fits two bits.
    Returns `(sum, carry)`: unsigned of the segment's width, signed of two bits.
    """
    width = len(segment)
    total = Signal(signed(width + 2), name=f"{name}_total")
    if carry_in is None:
        m.d.comb += total.eq(segment + small)
    else:
        # One bit more at the low end makes the carry in part of the same carry chain.
        both = Signal(signed(width + 3), name=f"{name}_both")
        m.d.comb += [both.eq(Cat(Const(1, 1), segment) + Cat(carry_in, small).as_signed()), total.eq(both[1:])]
    sum_register = Signal(width, name=name)
    carry = Signal(signed(2), name=f"{name}_carry")
    m.d.sync += [sum_register.eq(total[:width]), carry.eq(total[width:])]
    return sum_register, carry


def pipelined_add(m: Module, base, small, *, name: str, carry_in=None, segment_bits: int = SEGMENT_BITS):
    """`base + small + carry_in` for a small signed number, all bits of the result valid at the same clock.

    Takes one clock a segment; `pipeline_clocks` says how many. The result wraps at the width of `base` and is signed
    when that is. There is no subtracting form: the carry of an iCE40 cannot invert a number, which would cost a level
    of logic before it, so what is to be taken off is made negative where it comes from.
    """
    bounds = segment_bounds(len(base), segment_bits)
    carry = small
    parts = []
    for place, (low, high) in enumerate(bounds):
        segment = delayed(m, base[low:high], place, name=f"{name}_base{place}")
        part, carry = add_small_to_segment(
            m, segment, carry, name=f"{name}_segment{place}", carry_in=None if place else carry_in
        )
        parts.append(delayed(m, part, len(bounds) - 1 - place, name=f"{name}_aligned{place}"))
    result = Cat(*parts)
    return result.as_signed() if base.shape().signed else result


def pipeline_clocks(width: int, segment_bits: int = SEGMENT_BITS) -> int:
    """Clocks that `pipelined_add` takes for a base of `width` bits."""
    return len(segment_bounds(width, segment_bits))
