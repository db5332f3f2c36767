"""The declaration of the registers, and what makes a set of them sound."""

import pytest

from arcref.flags import FAULT_FLAGS, Flag
from arcref.link.register import Access, AddressClash, Field, Register, RegisterMap, Window
from arcref.link.registers import REGISTERS, fault_key


def register(name="one", address=0, width=16, **more):
    return Register(name, address, width, Access.WRITE, "For a test.", **more)


def test_two_registers_at_one_address_are_refused_and_both_named():
    with pytest.raises(AddressClash, match="two and one both have the address 0x0002"):
        RegisterMap((register("one", 0, 48), register("two", 2)))


def test_a_register_inside_a_window_is_refused():
    with pytest.raises(AddressClash, match="both have the address 0x0100"):
        RegisterMap((register(address=0x100),), (Window("memory", 0x80, 256, Access.WRITE, "For a test."),))


def test_two_registers_of_one_name_are_refused():
    with pytest.raises(AddressClash, match="two registers are called one"):
        RegisterMap((register(address=0), register(address=5)))


def test_an_address_beyond_16_bits_is_refused():
    with pytest.raises(AddressClash, match="16 bits"):
        RegisterMap((register(address=0xFFFF, width=32),))


@pytest.mark.parametrize("fields", [(("a", 0, 4), ("b", 3, 2)), (("a", 15, 2),)])
def test_fields_that_overlap_or_stand_outside_are_refused(fields):
    with pytest.raises(AddressClash, match="overlaps another or stands outside"):
        RegisterMap((register(fields=tuple(Field(*field, "For a test.") for field in fields)),))


@pytest.mark.parametrize("entry", REGISTERS.registers, ids=lambda entry: entry.name)
def test_every_register_encodes_and_decodes_its_extremes(entry):
    low = -(1 << entry.width - 1) if entry.signed else 0
    high = (1 << entry.width - entry.signed) - 1
    for value in (low, high, 0, high // 3):
        words = entry.encode(value)
        assert len(words) == entry.words
        assert all(0 <= word <= 0xFFFF for word in words)
        assert entry.decode(words) == value
    for value in (low - 1, high + 1):
        with pytest.raises(ValueError, match=f"{entry.name} is {value}, it must lie in {low} .. {high}"):
            entry.encode(value)


def test_every_register_says_what_it_is_in_one_sentence():
    for entry in REGISTERS.registers:
        assert entry.meaning.endswith("."), entry.name
        assert 0 <= entry.reset < 1 << entry.width, entry.name


def test_every_fault_flag_has_a_log_of_first_position_first_time_and_count():
    for flag in Flag:
        names = {f"{fault_key(flag)}_{what}" for what in ("first_position", "first_time", "count")}
        assert (names <= set(REGISTERS)) == bool(flag & FAULT_FLAGS)


def test_a_misspelt_name_is_answered_with_the_near_one():
    assert REGISTERS.suggestion("strobe_dealy") == "strobe_delay"
    assert REGISTERS.suggestion("xyzzy") is None
