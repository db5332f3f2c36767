"""Which register an address names, and what must be known of it: made from the declaration.

The address is held while it is worked on, so each step has a clock of its own and none waits for another.
"""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.link.register import ADDRESS_BITS, WORD_BITS, Access, Register
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_layout import (
    FIRST_SHADOW,
    PLACE_BITS,
    READABLE_WINDOW,
    REAL_PAIRS,
    live_registers,
    settings,
    writable_registers,
)
from arcref_gateware.link.selected_words import selected_word

GROUP_BITS = 4
"""Address bits of a word in its group; the others name the group."""


def forbidden_bits(register: Register, word: int) -> int:
    """Bits of a word that must be 0 when it is written."""
    bits = min(register.width - WORD_BITS * word, WORD_BITS)
    return (1 << WORD_BITS) - (1 << bits)


class RegisterDecoder(wiring.Component):
    """Looks at `address` for all that concerns a packet, and at `place` for the word that is being worked on.

    The place is the address, or the other word of its pair. `at_...` of a register is 1 while `place` is its last
    word; `in_...` while it is any of them.
    """

    def __init__(self):
        super().__init__(
            {
                "address": In(ADDRESS_BITS),
                "is_upper": In(1),
                "word": In(WORD_BITS),
                "place": Out(PLACE_BITS),
                "is_unknown": Out(1),
                "window": Out(len(REGISTERS.windows)),
                "at_snapshot": Out(1),
                "known": Out(1),
                "writable": Out(1),
                "kept": Out(1),
                "later_word": Out(1),
                "two_words": Out(1),
                "misfit": Out(1),
            }
            | {f"at_{register.name}": Out(1) for register in writable_registers()}
            | {f"in_{register.name}": Out(1) for register in settings()}
            | {f"pair_{register.name}": Out(1) for register in live_registers()}
        )

    address: In
    """The address of the request, held."""
    is_upper: In
    """1 to work on the second word of the address's pair, 0 on the first."""
    word: In
    """The word that is to be written, held."""
    place: Out
    """Place of the word in the register file's memory, if it has one."""
    is_unknown: Out
    """1 when what is read stands neither in the memory nor in a window that can be read."""
    window: Out
    """Bit n: the address is in window n of the declaration."""
    at_snapshot: Out
    """1 when the address is that of `snapshot_number`."""
    known: Out
    """1 when a register has the place."""
    writable: Out
    """1 when it can be written."""
    kept: Out
    """1 when it keeps what is written."""
    later_word: Out
    """1 when the place is not the register's first word."""
    two_words: Out
    """1 when it is the first of two."""
    misfit: Out
    """1 when `word` has a bit that the register lacks."""

    def elaborate(self, platform):
        m = Module()
        place, address = self.place, self.address
        m.d.comb += place.eq(Cat(self.is_upper, address[1:PLACE_BITS]))
        high_is_zero, is_shadow, is_inside = Signal(), Signal(), Signal()
        m.d.sync += [
            high_is_zero.eq(address[PLACE_BITS:] == 0),
            is_shadow.eq(
                (address[6:PLACE_BITS] == FIRST_SHADOW >> 6)
                & ~_any(address[1:6] == pair - (FIRST_SHADOW >> 1) for pair in REAL_PAIRS)
            ),
            is_inside.eq(high_is_zero & ~is_shadow),
        ]
        for bit, window in enumerate(REGISTERS.windows):
            assert window.address % window.words == 0
            m.d.sync += self.window[bit].eq(address[exact_log2(window.words) :] == window.address // window.words)
        m.d.sync += self.is_unknown.eq(~is_inside & ~self.window[READABLE_WINDOW])

        # First step: the group, and where in a group the place is.
        words = {at: (register, i) for register in REGISTERS.registers for i, at in enumerate(register.addresses)}
        numbers = sorted({at >> GROUP_BITS for at in words})
        groups = {number: Signal(name=f"group{number:x}", reset_less=True) for number in numbers}
        for number, group in groups.items():
            m.d.sync += group.eq((place[GROUP_BITS:] == number) & high_is_zero)
        masks: dict[int, Signal] = {}

        def in_group(places) -> Signal:
            """1 while the place is at one of these in any group."""
            mask = sum(1 << at for at in places)
            if mask not in masks:
                masks[mask] = Signal(name=f"mask{mask:04x}")
                m.d.sync += masks[mask].eq(_any(place[:GROUP_BITS] == at for at in places))
            return masks[mask]

        def at(register: Register, first: int):
            """1 while the place is the register's word `first` or a later one."""
            places = [at % (1 << GROUP_BITS) for at in register.addresses[first:]]
            return groups[register.address >> GROUP_BITS] & in_group(places)

        def fact(output: Signal, holds) -> None:
            """`output` is 1 at the words of which `holds(register, word)` is true."""
            by_mask: dict[int, list] = {}
            for number, group in groups.items():
                places = [k for k in range(1 << GROUP_BITS) if (number << GROUP_BITS | k) in words]
                mask = tuple(k for k in places if holds(*words[number << GROUP_BITS | k]))
                if mask:
                    by_mask.setdefault(mask, []).append(group)
            choices = [(in_group(mask), _any(members)) for mask, members in by_mask.items()]
            m.d.comb += output.eq(selected_word(m, choices, name=output.name))

        for register in writable_registers():
            m.d.comb += getattr(self, f"at_{register.name}").eq(at(register, register.words - 1))
            if register.access is Access.WRITE:
                m.d.comb += getattr(self, f"in_{register.name}").eq(at(register, 0))
        for register in live_registers():
            group = groups[register.address >> GROUP_BITS]
            low = register.address % (1 << GROUP_BITS)
            m.d.sync += getattr(self, f"pair_{register.name}").eq(group & (place[1:GROUP_BITS] == low >> 1))
        number = REGISTERS["snapshot_number"].address
        m.d.sync += self.at_snapshot.eq(
            groups[number >> GROUP_BITS] & (address[:GROUP_BITS] == number % (1 << GROUP_BITS))
        )

        def can_write(register: Register) -> bool:
            return register.access is not Access.READ

        fact(self.known, lambda register, word: True)
        fact(self.writable, lambda register, word: can_write(register))
        fact(self.kept, lambda register, word: register.access is Access.WRITE)
        fact(self.later_word, lambda register, word: can_write(register) and word > 0)
        fact(self.two_words, lambda register, word: can_write(register) and word == 0 and register.words > 1)

        # Bits that are forbidden together, in the very same words, are looked at together.
        together: dict[frozenset, list[int]] = {}
        for bit in range(WORD_BITS):
            places = frozenset(
                at
                for at, (register, i) in words.items()
                if can_write(register) and forbidden_bits(register, i) >> bit & 1
            )
            if places:
                together.setdefault(places, []).append(bit)
        misfits = []
        for k, (places, bits) in enumerate(together.items()):
            any_bit, matters = Signal(name=f"bits{k}"), Signal(name=f"forbidden{k}")
            m.d.sync += any_bit.eq(Cat(self.word[bit] for bit in bits).any())
            starts = {(words[at][0].name, words[at][1]) for at in places}
            fact(matters, lambda register, word, starts=starts: (register.name, word) in starts)
            misfits.append((any_bit, matters))
        m.d.comb += self.misfit.eq(selected_word(m, misfits, name="misfit_or"))
        return m


def _any(values):
    """The or of some values."""
    total = Const(0, 1)
    for value in values:
        total = total | value
    return total
