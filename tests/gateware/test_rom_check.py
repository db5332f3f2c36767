"""Power-up check: good tables are found good after a set number of clocks, and a single wrong bit is found."""

import zlib

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import Out
from amaranth_bench import Bench, assert_rows

from arcref.correction_rom import CorrectionRom
from arcref.rom_identity import identity_words
from arcref_gateware.correction import Correction
from arcref_gateware.rom_check import CRC32_START, Crc32, RomCheck


class CheckedTables(wiring.Component):
    """The check with the tables it reads, wired as the core wires them."""

    busy: Out(1, init=1)
    good: Out(1)
    fault: Out(1)

    def __init__(self, identity, line, subdivision):
        self.contents = identity, line, subdivision
        super().__init__()

    def elaborate(self, platform):
        m = Module()
        identity, line, subdivision = self.contents
        m.submodules.tables = tables = Correction(line, subdivision)
        m.submodules.check = check = RomCheck(identity)
        m.d.comb += [
            tables.check_enable.eq(check.busy),
            tables.check_address.eq(check.address),
            check.line_word.eq(tables.line_word),
            check.subdivision_word.eq(tables.subdivision_word),
            self.busy.eq(check.busy),
            self.good.eq(check.good),
            self.fault.eq(check.fault),
        ]
        return m


def contents(rom):
    """Identity, line table and subdivision table as words, to be spoilt."""
    return [identity_words(rom).astype(int), rom.line_table.astype(int), rom.subdivision_table.astype(int)]


def check(identity, line, subdivision, extra_clocks=20):
    rows = Bench(CheckedTables(identity, line, subdivision), [], ["busy", "good", "fault"]).run(
        RomCheck.CLOCKS + extra_clocks
    )
    assert_rows("busy", rows["busy"], np.arange(len(rows["busy"])) < RomCheck.CLOCKS)
    good, fault = rows["good"], rows["fault"]
    assert not good[: RomCheck.CLOCKS].any(), "good before the verdict"
    assert not fault[: RomCheck.CLOCKS].any(), "a fault before the verdict"
    assert not fault[RomCheck.CLOCKS + 1 :].any(), "a fault lasts for one clock"
    assert len(set(good[RomCheck.CLOCKS :].tolist())) == 1, "the verdict stays"
    assert good[-1] != fault[RomCheck.CLOCKS], "a verdict is either good or a fault"
    return bool(good[-1])


def seal_identity(identity):
    """Put the right CRC behind a spoilt identity."""
    crc = zlib.crc32(identity[:510].astype("<u2").tobytes())
    identity[510:] = crc & 0xFFFF, crc >> 16


def test_good_tables_are_found_good_after_the_stated_clocks(random_rom):
    assert check(*contents(random_rom))


def test_tables_of_zeros_and_their_identity_are_good():
    assert check(*contents(CorrectionRom(np.zeros(4096, np.int16), provenance={"encoder_serial": "7"})))


PLACES = [("identity", 7), ("identity", 511), ("line", 0), ("line", 4095), ("subdivision", 0), ("subdivision", 511)]


@pytest.mark.parametrize(("table", "place"), PLACES)
def test_a_single_wrong_bit_is_found(table, place, random_rom, rng):
    words = contents(random_rom)
    words[["identity", "line", "subdivision"].index(table)][place] ^= 1 << int(rng.integers(16))
    assert not check(*words)


@pytest.mark.parametrize("place", [0, 1])
def test_a_wrong_magic_is_found_under_a_right_crc(place, random_rom):
    words = contents(random_rom)
    words[0][place] ^= 0x0100
    seal_identity(words[0])
    assert not check(*words)


@pytest.mark.parametrize("place", [4, 5])
def test_the_identity_of_other_tables_is_found(place, random_rom):
    words = contents(random_rom)
    words[0][place] ^= 0x8000
    seal_identity(words[0])
    assert not check(*words)


def test_two_words_exchanged_are_found(random_rom):
    words = contents(random_rom)
    words[1][[100, 101]] = words[1][[101, 100]]
    assert not check(*words)


def test_memories_that_were_never_written_are_found():
    assert not check(np.zeros(512, int), np.zeros(4096, int), np.zeros(512, int))
    assert not check(np.full(512, 0xFFFF), np.full(4096, 0xFFFF), np.full(512, 0xFFFF))


def test_the_crc_is_that_of_zlib_from_every_restart_on(rng):
    restart = rng.random(600) < 0.02
    restart[0] = True
    octets = rng.integers(0, 1 << 8, 600) * ~restart
    rows = Bench(Crc32(), ["octet", "restart"], ["register"]).run(600 + Crc32.CLOCKS, octet=octets, restart=restart)

    expected, crc = [], 0
    for octet, following, again in zip(octets[:-1].tolist(), octets[1:].tolist(), restart, strict=False):
        crc = 0 if again else zlib.crc32(bytes([octet]), crc)
        expected.append(crc ^ CRC32_START ^ following)
    assert np.count_nonzero(restart) > 2
    assert_rows("register", rows["register"][Crc32.CLOCKS :][:599], np.array(expected))
