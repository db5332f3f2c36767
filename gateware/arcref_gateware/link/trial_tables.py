"""Trial tables: loaded over the link, checked as at power-up, in force from the next index on."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.registers import REGISTERS, ROM_STATES
from arcref_gateware.table_access import TableAccess

CHECKING, GOOD, FAULT, LOADING, WAITING = (
    ROM_STATES.index(state) for state in ("checking", "good", "fault", "loading", "waiting for the index")
)

BEGIN, FINISH = (field.low for field in REGISTERS["trial"].fields)


class TrialTables(wiring.Component):
    """Takes the tables away from the core while they are loaded, and gives them back with the index after the check."""

    command: In(REGISTERS["trial"].width)
    """The register `trial`, for one clock."""
    index: In(1)
    """1 for one clock or longer when an index was met."""
    address: In(12)
    """Word of a window, from its beginning."""
    write: In(len(REGISTERS.windows))
    """Bit n: write `word` to window n of the declaration, for one clock."""
    word: In(16)
    """The word, held."""
    identity_word: Out(16)
    """Word of the identity at `address`."""
    loading: Out(1)
    """1 while the windows may be written."""
    state: Out(REGISTERS["rom_state"].width)
    """The register `rom_state`."""
    crc32: Out(32)
    """The register `rom_crc32`."""
    access: Out(TableAccess())
    """The core's tables."""

    def elaborate(self, platform):
        m = Module()
        access = self.access
        trial, waits, check = Signal(), Signal(), Signal()
        windows = [window.name for window in REGISTERS.windows]
        m.d.comb += [
            access.loading.eq(self.loading),
            access.hold.eq(self.loading | waits),
            access.check.eq(check),
            access.address.eq(self.address),
            access.write_word.eq(self.word),
            access.write_line.eq(self.write[windows.index("line_table")]),
            access.write_subdivision.eq(self.write[windows.index("subdivision_table")]),
            access.write_identity.eq(self.write[windows.index("identity")]),
            self.identity_word.eq(access.identity_word),
            self.crc32.eq(access.crc32),
        ]
        # The index must come after the verdict.
        begins, finishes, takes_force = Signal(), Signal(), Signal()
        m.d.comb += [
            begins.eq(self.command[BEGIN] & ~access.checking),
            finishes.eq(self.command[FINISH] & self.loading),
            takes_force.eq(~self.loading & ~check & ~access.checking & access.good & self.index),
        ]
        m.d.sync += [
            self.loading.eq((self.loading | begins) & ~finishes),
            check.eq(finishes),
            trial.eq(trial | begins),
            waits.eq(begins | (waits & ~takes_force)),
        ]
        # What is told of it, a clock later.
        loads, checks, faulty, in_waiting = Signal(), Signal(), Signal(), Signal()
        m.d.sync += [
            loads.eq(self.loading),
            checks.eq(access.checking | check),
            faulty.eq(~access.good),
            in_waiting.eq(waits),
        ]
        state = Signal(3)
        m.d.comb += state.eq(
            Mux(loads, LOADING, Mux(checks, CHECKING, Mux(faulty, FAULT, Mux(in_waiting, WAITING, GOOD))))
        )
        m.d.sync += self.state.eq(state | trial << 3)
        return m
