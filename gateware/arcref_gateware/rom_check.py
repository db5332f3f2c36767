"""The power-up check: all three tables are read through, and the correction is used only when their CRCs hold."""

from functools import reduce
from operator import or_

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.angle import LINES_PER_TURN
from arcref.correction_rom import SUBDIVISION_ENTRIES
from arcref.rom_identity import IDENTITY_WORDS, MAGIC, MAGIC_WORDS, TABLE_CRC_WORDS
from arcref_gateware.register_stages import delayed
from arcref_gateware.table_memory import TABLE_CLOCKS, TableMemory

CRC32_POLYNOMIAL = 0xEDB88320
"""Polynomial of zlib's CRC-32, least significant bit first."""

CRC32_START = 0xFFFFFFFF
"""Register of CRC-32 before the first word."""

CRC32_RESIDUE = 0xDEBB20E3
"""Register of CRC-32 after a message and its own CRC, whatever the message was."""

READ_CLOCKS = 2 + TABLE_CLOCKS
"""Clocks from an address to the words of all tables."""


def crc32_fold(octet):
    """What an octet, added to the lowest eight bits of the CRC register, does to the register."""
    folded = Const(0, 32)
    for bit in range(8):
        register = 1 << bit
        for _ in range(8):
            register = register >> 1 ^ (CRC32_POLYNOMIAL if register & 1 else 0)
        folded = folded ^ Mux(octet[bit], register, 0)
    return folded


class Crc32(wiring.Component):
    """zlib's CRC-32 of the octets since `restart`, one every clock."""

    CLOCKS = 2
    """Clocks from `octet` to `register`."""

    octet: In(8)
    """The next octet; the first one comes a clock after `restart`."""
    restart: In(1)
    """1 to start, and to start again; `octet` is 0 then."""
    register: Out(32)
    """The register, not inverted: zlib's value is its complement. The octet that follows is already added to it."""

    def elaborate(self, platform):
        m = Module()
        # The lowest bits are kept with the next octet added, which leaves two levels of logic in the register's loop.
        low, high = Signal(8, reset_less=True), Signal(24, reset_less=True)
        restart = delayed(m, self.restart, 1, name="restart")
        following = Cat(high, Const(0, 8)) ^ crc32_fold(low)
        m.d.sync += [
            low.eq(Mux(restart, CRC32_START & 0xFF, following[:8]) ^ self.octet),
            high.eq(following[8:]),
        ]
        with m.If(restart):
            m.d.sync += high.eq(CRC32_START >> 8)
        m.d.comb += self.register.eq(Cat(low, high))
        return m


class RomCheck(wiring.Component):
    """Reads the identity, the line table and the subdivision table once after reset and says whether they are good.

    An octet is read a clock. The identity ends with a CRC of its own. The CRC of the two tables stands in it and is fed
    in after them, so one register compared with one constant decides both. While `busy` is high, `address` belongs to
    the check.
    """

    CLOCKS = 1 + 2 * (IDENTITY_WORDS + LINES_PER_TURN + SUBDIVISION_ENTRIES + 2) + 1 + READ_CLOCKS + Crc32.CLOCKS + 4
    """Clocks from reset to the first one with `busy` low."""

    SMALL_BITS = exact_log2(SUBDIVISION_ENTRIES)
    """Address bits of the two small tables, the identity and the subdivision table."""

    def __init__(self, identity_words):
        self.identity_words = identity_words
        super().__init__(
            {
                "restart": In(1),
                "busy": Out(1, init=1),
                "address": Out(self.SMALL_BITS + exact_log2(LINES_PER_TURN)),
                "line_word": In(16),
                "subdivision_word": In(16),
                "good": Out(1),
                "fault": Out(1),
                "table_crc32": Out(32),
                "identity_address": In(exact_log2(IDENTITY_WORDS)),
                "identity_word": Out(16),
                "write_identity": In(1),
                "write_word": In(16),
            }
        )

    restart: In
    """1 for one clock, not while `busy`: check the tables again."""
    busy: Out
    """1 from reset, or `restart`, until the verdict."""
    address: Out
    """Cell number whose words `line_word` and `subdivision_word` are, `READ_CLOCKS` clocks later."""
    line_word: In
    """Word of the line table."""
    subdivision_word: In
    """Word of the subdivision table."""
    good: Out
    """1 once all tables were found good."""
    fault: Out
    """1 for one clock, the first with `busy` low, when a table was found bad."""
    table_crc32: Out
    """CRC-32 of the tables as the identity states it."""
    identity_address: In
    """Word of the identity that is wanted, or written, while not `busy`."""
    identity_word: Out
    """The word, 1 + `TABLE_CLOCKS` clocks later."""
    write_identity: In
    """1 to write `write_word` at `identity_address`."""
    write_word: In
    """The word to write."""

    def elaborate(self, platform):
        m = Module()
        m.submodules.identity = identity = TableMemory(self.identity_words)
        octet_place = Signal(range(2 * LINES_PER_TURN), reset_less=True)  # `clears` is 1 at reset
        place = octet_place[1:]
        # One register a state, in the order they follow each other: nothing has to be decoded.
        start, identity_part, identity_end = Signal(init=1), Signal(), Signal()
        line_part, subdivision_part, crc_part, tables_end, wait = (
            Signal(name=name) for name in ("line_part", "subdivision_part", "crc_part", "tables_end", "wait")
        )
        # The last octet of a table is seen two clocks ahead, so that no state waits for a long comparison. Where a
        # table ends the place is all ones.
        low_last, middle_last, high_last = (Signal(name=f"{part}_last") for part in ("low", "middle", "high"))
        last_small, last_line, clears = Signal(), Signal(), Signal(init=1)
        m.d.sync += [
            low_last.eq(octet_place[:4] == (1 << 4) - 3),
            middle_last.eq(octet_place[4 : self.SMALL_BITS + 1].all()),
            high_last.eq(octet_place[self.SMALL_BITS + 1 :].all()),
            last_small.eq(low_last & middle_last),
            last_line.eq(low_last & middle_last & high_last),
            start.eq(wait & self.restart),
            identity_part.eq(start | (identity_part & ~last_small)),
            identity_end.eq(identity_part & last_small),
            line_part.eq(identity_end | (line_part & ~last_line)),
            subdivision_part.eq((line_part & last_line) | (subdivision_part & ~last_small)),
            crc_part.eq((subdivision_part & last_small) | (crc_part & ~octet_place[:2].all())),
            tables_end.eq(crc_part & octet_place[:2].all()),
            wait.eq(tables_end | (wait & ~self.restart)),
            # The place goes over to 0 by itself behind the line table, and stays there until the next check.
            clears.eq(tables_end | wait | (identity_part & last_small)),
            octet_place.eq(octet_place + 1),
        ]
        with m.If(clears):
            m.d.sync += octet_place.eq(0)
        m.d.comb += self.address.eq(Cat(place[: self.SMALL_BITS], place))

        # The identity is read a clock later than the others are, whose address goes through the correction first.
        identity_address = delayed(m, place[: self.SMALL_BITS], READ_CLOCKS - TABLE_CLOCKS - 1, name="identity_place")
        m.d.sync += [
            identity.address.eq(Mux(self.busy, identity_address, self.identity_address)),
            identity.write.eq(self.write_identity),
            identity.write_data.eq(self.write_word),
        ]
        m.d.comb += self.identity_word.eq(identity.data)
        states = Cat(
            identity_part, line_part, subdivision_part, crc_part, identity_end, tables_end, start, octet_place[0]
        )
        coming_identity, coming_line, coming_subdivision, coming_crc, *others, coming_high = delayed(
            m, states, READ_CLOCKS - 1, name="coming"
        )
        end_identity, end_tables, starts, in_crc = delayed(m, Cat(*others, coming_crc), 1, name="read")
        # Bit n: octet n of the identity is being read.
        identity_octet = Signal(2 * max(*MAGIC_WORDS, *TABLE_CRC_WORDS) + 1)
        m.d.sync += identity_octet.eq(Cat(starts, identity_octet))

        # The CRC of the tables as the identity states it; it goes round once as its octets are taken.
        table_crc = Signal(32, reset_less=True)
        for half, crc_word in enumerate(TABLE_CRC_WORDS):
            part = slice(16 * half, 16 * half + 16)
            with m.If(identity_octet[2 * crc_word] | in_crc):
                m.d.sync += table_crc[part].eq(Mux(in_crc, table_crc.rotate_right(8)[part], identity.data))
        misfits = []
        for magic_place, magic in zip(MAGIC_WORDS, MAGIC, strict=True):
            differs = Signal(4, name=f"differs{magic_place}")
            judges = Signal(name=f"judges{magic_place}")
            m.d.sync += [
                differs.eq(Cat(identity.data[low : low + 4] != (magic >> low & 0xF) for low in range(0, 16, 4))),
                judges.eq(identity_octet[2 * magic_place]),
            ]
            misfit = Signal(name=f"misfit{magic_place}")
            m.d.sync += misfit.eq(judges & differs.any())
            misfits.append(misfit)
        magic_good = Signal(init=1)
        m.d.sync += magic_good.eq((magic_good & ~Cat(misfits).any()) | self.restart)
        m.d.comb += self.table_crc32.eq(table_crc)

        # The octet that is read, each from its own table; at most one of them is not 0.
        octets = [delayed(m, table_crc[:8] & in_crc.replicate(8), 1, name="crc_octet")]
        for name, word, coming in (
            ("identity", identity.data, coming_identity),
            ("line", self.line_word, coming_line),
            ("subdivision", self.subdivision_word, coming_subdivision),
        ):
            takes_low, takes_high = Signal(name=f"takes_{name}_low"), Signal(name=f"takes_{name}_high")
            octet = Signal(8, name=f"{name}_octet", reset_less=True)
            m.d.sync += [
                takes_low.eq(coming & ~coming_high),
                takes_high.eq(coming & coming_high),
                octet.eq((word[:8] & takes_low.replicate(8)) | (word[8:] & takes_high.replicate(8))),
            ]
            octets.append(octet)
        octet = Signal(8, reset_less=True)
        m.d.sync += octet.eq(reduce(or_, octets))
        m.submodules.crc = crc = Crc32()
        end_identity, end_tables, restart = (
            delayed(m, tag, 2, name="octet") for tag in (end_identity, end_tables, starts | end_identity)
        )
        m.d.comb += [crc.octet.eq(octet), crc.restart.eq(restart)]

        # The register is compared in two clocks after the last octet went in. It goes on by itself: only what it holds
        # in that very clock counts.
        parts_match = Signal(4)
        matches = Signal()
        identity_good = Signal()
        for part in range(4):
            octet = slice(8 * part, 8 * part + 8)
            m.d.sync += parts_match[part].eq(crc.register[octet] == (CRC32_RESIDUE >> 8 * part & 0xFF))
        m.d.sync += matches.eq(parts_match.all())
        identity_ended = delayed(m, end_identity, Crc32.CLOCKS + 1, name="identity_ended")
        tables_ended = delayed(m, end_tables, Crc32.CLOCKS + 1, name="tables_ended")
        verdict = identity_good & magic_good & matches
        with m.If(identity_ended):
            m.d.sync += identity_good.eq(matches)
        m.d.sync += self.fault.eq(tables_ended & ~verdict)
        m.d.sync += [
            self.busy.eq((self.busy & ~tables_ended) | (wait & self.restart)),
            self.good.eq(Mux(tables_ended, verdict, self.good & ~self.restart)),
        ]
        return m
