"""Register stages: delays and adders that are cut into segments so that no carry chain limits the word clock."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal, signed

SEGMENT_BITS = 12
"""Longest carry chain of a pipelined adder: 1.5 ns on an iCE40-HX, whose carry takes 0.13 ns a bit, 3.3 on an UP5K."""


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


def add_small_to_segment(m: Module, segment, small, *, name: str, carry_in=None, restart=None):
    """Register `segment + small + carry_in`, and the carry that the next segment is owed.

    `small` is signed and smaller in size than the segment's range, so the carry is -1, 0 or +1 and fits two bits.
    With `restart` the segment counts as 0. That is chosen behind the sum: before it, it would take a level of logic.
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
    following = Signal(signed(width + 2), name=f"{name}_following")
    m.d.comb += following.eq(total if restart is None else Mux(restart, small, total))
    m.d.sync += [sum_register.eq(following[:width]), carry.eq(following[width:])]
    return sum_register, carry


def sum_and_carry(m: Module, first, second, carry_in=None):
    """`first + second + carry_in` of two numbers of one width, and one bit more: the carry out.

    That bit is added to a register which is always 0, as synthesis cannot know. A constant there would let it take the
    carry out from the carry chain itself, which costs an iCE40 two ways through its routing; a bit added to itself is
    one net at two inputs of a cell, on which nextpnr's router has been seen to go on without end.
    """
    never = Signal(reset_less=True)
    m.d.sync += never.eq(never & first[-1])
    if carry_in is None:
        return (Cat(first, never) + Cat(second))[: len(first) + 1]
    # One bit more at the low end makes the carry in part of the same carry chain.
    return (Cat(Const(1, 1), first, never) + Cat(carry_in, second))[1 : len(first) + 2]


def add_slice_to_segment(m: Module, segment, part, carry, *, name: str):
    """Register `segment + part + carry` for an unsigned `part` as wide as the segment and a carry of one bit, or None.

    Returns `(sum, carry)`: the carry is one bit again.
    """
    sum_register, carry_register = Signal(len(segment), name=name), Signal(name=f"{name}_carry")
    m.d.sync += Cat(sum_register, carry_register).eq(sum_and_carry(m, segment, part, carry))
    return sum_register, carry_register


def skewed_add(m: Module, segments, addend, *, name: str, carry_in=None):
    """The segments of `base + addend + carry_in`, from those of a base of which each comes a clock after the last.

    `addend` is signed and no wider than the base, and comes with the first segment, as does `carry_in`. Each segment
    of the sum comes a clock after that of the base, so that the sum is skewed as the base is. There is no subtracting
    form: the carry of an iCE40 cannot invert a number, which would cost a level of logic before it, so what is to be
    taken off is made negative where it comes from.
    """
    low, carry, parts = 0, carry_in, []
    for place, segment in enumerate(segments):
        width = len(segment)
        label = f"{name}_segment{place}"
        if low + width < len(addend):
            part = delayed(m, addend[low : low + width], place, name=f"{name}_part{place}")
            total, carry = add_slice_to_segment(m, segment, part, carry, name=label)
        elif low < len(addend):
            part = delayed(m, addend[low:].as_signed(), place, name=f"{name}_part{place}")
            total, carry = add_small_to_segment(m, segment, part, name=label, carry_in=carry)
        else:
            total, carry = add_small_to_segment(m, segment, carry, name=label)
        parts.append(total)
        low += width
    return parts


def skewed(m: Module, value, *, name: str, segment_bits: int = SEGMENT_BITS):
    """The segments of `value`, each a clock after the one below it."""
    bounds = segment_bounds(len(value), segment_bits)
    return [delayed(m, value[low:high], place, name=f"{name}{place}") for place, (low, high) in enumerate(bounds)]


def aligned(m: Module, segments, *, name: str):
    """The number of which each segment comes a clock after the last, with its last segment."""
    last = len(segments) - 1
    return Cat(*(delayed(m, part, last - place, name=f"{name}{place}") for place, part in enumerate(segments)))


def pipelined_add(m: Module, base, addend, *, name: str, carry_in=None, segment_bits: int = SEGMENT_BITS):
    """`base + addend + carry_in` for a signed addend no wider than the base, all bits valid at the same clock.

    Takes one clock a segment; `pipeline_clocks` says how many. The result wraps at the width of `base` and is signed
    when that is.
    """
    segments = skewed(m, base, name=f"{name}_base", segment_bits=segment_bits)
    result = aligned(m, skewed_add(m, segments, addend, name=name, carry_in=carry_in), name=f"{name}_aligned")
    return result.as_signed() if base.shape().signed else result


def pipeline_clocks(width: int, segment_bits: int = SEGMENT_BITS) -> int:
    """Clocks that `pipelined_add` takes for a base of `width` bits."""
    return len(segment_bounds(width, segment_bits))
