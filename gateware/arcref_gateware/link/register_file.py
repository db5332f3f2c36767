"""The register file, made from the declaration in `arcref.link.registers`.

An address goes through a clock each to its group of sixteen words, to the word in every group, to the one of its
group, and to the answer, so that no clock has long to think. Registers that a snapshot or a fault log holds come from
`StatusRecorder`'s memory, windows from memories elsewhere.
"""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD, WORD_BITS, Access, Register
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request
from arcref_gateware.link.status_recorder import is_recorded
from arcref_gateware.register_stages import delayed

ANSWER_CLOCKS = 7
"""Clocks from `valid` to `done`, unless a snapshot is taken."""

GROUP_BITS = 4

UNKNOWN, READ_ONLY, INSIDE, BEGINS = range(4)
"""Kinds of a word for a write: no register, one that is only read, a later word of a register, its first word."""

FACT_BITS = 1 + 2 + 2 + WORD_BITS


def live_registers() -> list[Register]:
    """Registers whose value is an input of the register file."""
    return [r for r in REGISTERS.registers if r.access is Access.READ and not is_recorded(r)]


class RegisterFile(wiring.Component):
    """One port for each register: inputs of what can be read, outputs of settings and commands, by their names.

    A command's output holds the written value for one clock and is 0 otherwise. Besides: the bus, the snapshot's
    handshake, the recorder's memory and the windows. `resets` gives settings another reset value than the declaration.
    """

    def __init__(self, resets: dict[str, int] | None = None):
        resets = resets or {}
        self.held = Signal(WORD_BITS)
        members = {"bus": In(RegisterBus())}
        for register in live_registers():
            members[register.name] = In(signed(register.width) if register.signed else register.width)
        for register in REGISTERS.registers:
            if register.access is not Access.READ:
                reset = resets.get(register.name, register.reset) if register.access is Access.WRITE else 0
                members[register.name] = Out(register.width, init=reset)
        super().__init__(
            members
            | {
                "snapshot": Out(1),
                "snapshot_done": In(1),
                "recorded_address": Out(6),
                "recorded_word": In(WORD_BITS),
                "window_address": Out(12),
                "identity_word": In(WORD_BITS),
                "loading": In(1),
                "window_write": Out(len(REGISTERS.windows)),
                "window_word": Out(WORD_BITS),
            }
        )

    bus: In
    """The doors' bus."""
    snapshot: Out
    """1 for one clock: take a snapshot."""
    snapshot_done: In
    """1 for one clock once the snapshot is in the recorder's memory."""
    recorded_address: Out
    """Word of the recorder's memory that is wanted."""
    recorded_word: In
    """The word, two to four clocks later."""
    window_address: Out
    """Word of a window, counted from its beginning."""
    identity_word: In
    """Word of the identity memory, four clocks after its address."""
    loading: In
    """1 while trial tables are loaded: the windows may be written."""
    window_write: Out
    """Bit n: write `window_word` to window n of the declaration, for one clock."""
    window_word: Out
    """Word for a window."""

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        is_read, is_write = Signal(), Signal()
        m.d.sync += [is_read.eq(bus.request == Request.READ), is_write.eq(bus.request == Request.WRITE)]

        # First clock: the address. Second: which group of sixteen it is in.
        address = Signal(len(bus.address))
        low = Signal(GROUP_BITS)
        m.d.sync += [address.eq(bus.address), low.eq(address[:GROUP_BITS])]
        groups = sorted({place >> GROUP_BITS for r in REGISTERS.registers for place in r.addresses})
        selected = {group: Signal(name=f"group{group:x}") for group in groups}
        for group, here in selected.items():
            m.d.sync += here.eq(address[GROUP_BITS:] == group)
        in_window = [Signal(name=f"in_{window.name}") for window in REGISTERS.windows]
        for here, window in zip(in_window, REGISTERS.windows, strict=True):
            assert window.address % window.words == 0
            m.d.sync += here.eq(address[exact_log2(window.words) :] == window.address // window.words)
        m.d.comb += [
            # The snapshot stands at 0x10.., the fault logs at 0x40..: see StatusRecorder for the memory's order.
            self.recorded_address.eq(Cat(address[:5], address[5] | ~address[6])),
            self.window_address.eq(address[:12]),
            self.window_word.eq(bus.write_word),
        ]

        def here(place: int):
            """1 in the third clock when the address is `place`."""
            return selected[place >> GROUP_BITS] & (low == place % (1 << GROUP_BITS))

        # Third clock: what each group has there. Fourth: that of the group it is.
        words, holds = self._words()
        facts = {
            place: _facts(register, i) for register in REGISTERS.registers for i, place in enumerate(register.addresses)
        }
        chosen = {group: delayed(m, signal, 1, name=f"chosen{group:x}") for group, signal in selected.items()}
        word, fact = Signal(WORD_BITS), Signal(FACT_BITS)
        joined_word, joined_fact = 0, 0
        for group in groups:
            places = range(group << GROUP_BITS, (group + 1) << GROUP_BITS)
            group_word = Signal(WORD_BITS, name=f"word{group:x}")
            group_fact = Signal(FACT_BITS, name=f"fact{group:x}")
            unknown = Const(UNKNOWN_WORD, WORD_BITS)
            m.d.sync += [
                group_word.eq(Array([words.get(place, unknown) for place in places])[low]),
                group_fact.eq(Array([Const(facts.get(place, 0), FACT_BITS) for place in places])[low]),
            ]
            joined_word = joined_word | (group_word & chosen[group].replicate(WORD_BITS))
            joined_fact = joined_fact | (group_fact & chosen[group].replicate(FACT_BITS))
        none = Signal()
        m.d.sync += [word.eq(joined_word), fact.eq(joined_fact), none.eq(~Cat(chosen.values()).any())]
        windows = [
            delayed(m, signal, 2, name=f"{w.name}_chosen")
            for signal, w in zip(in_window, REGISTERS.windows, strict=True)
        ]
        is_recorded_word, kind, register_words, forbidden = fact[0], fact[1:3], fact[3:5], fact[5:]
        in_identity = windows[[w.name for w in REGISTERS.windows].index("identity")]

        # Fifth: the answer to a READ. Sixth: that to a CHECK.
        plain, other, misfit, outside = Signal(WORD_BITS), Signal(WORD_BITS), Signal(), Signal()
        status = Signal(STATUS_BITS)
        in_any_window = Cat(windows).any()
        m.d.sync += [
            plain.eq(word & ~is_recorded_word.replicate(WORD_BITS)),
            other.eq(
                (self.recorded_word & is_recorded_word.replicate(WORD_BITS))
                | (self.identity_word & in_identity.replicate(WORD_BITS))
                | (Const(UNKNOWN_WORD, WORD_BITS) & (none & ~in_identity).replicate(WORD_BITS))
            ),
            bus.read_word.eq(plain | other),
            misfit.eq((bus.write_word & forbidden).any()),
            outside.eq((kind == INSIDE) & ~bus.following | (kind == BEGINS) & (bus.words_left < register_words)),
            status.eq(Status.DONE),
        ]
        window_later = delayed(m, in_any_window, 1, name="window_later")
        kind_later = delayed(m, kind, 1, name="kind_later")
        with m.If(window_later & ~is_read), m.If(~self.loading):
            m.d.sync += status.eq(Status.NOT_NOW)
        with m.Elif((kind_later == UNKNOWN) & ~is_read):
            m.d.sync += status.eq(Status.UNKNOWN_ADDRESS)
        with m.Elif((kind_later == READ_ONLY) & ~is_read):
            m.d.sync += status.eq(Status.READ_ONLY)
        with m.Elif((misfit | outside) & ~is_read):
            m.d.sync += status.eq(Status.OUT_OF_RANGE)
        m.d.comb += bus.status.eq(status)

        # When it is done: a snapshot takes its time.
        stage = Signal(ANSWER_CLOCKS)
        waits = Signal()
        m.d.sync += [stage.eq(Cat(bus.valid, stage)), self.snapshot.eq(0), bus.done.eq(0)]
        with m.If(stage[1] & here(REGISTERS["snapshot_number"].address) & is_read):
            m.d.sync += [self.snapshot.eq(1), waits.eq(1)]
        settled = delayed(m, self.snapshot_done & waits, ANSWER_CLOCKS, name="settled")
        with m.If(settled):
            m.d.sync += [waits.eq(0), bus.done.eq(1)]
        with m.If(stage[-1] & ~waits):
            m.d.sync += bus.done.eq(1)

        # The upper words of live registers are kept as their lowest word is read, so that a number is never torn.
        for place, upper in holds:
            with m.If(stage[1] & is_read & here(place)):
                m.d.sync += self.held.eq(upper)
        self._write(m, here, in_window, stage[1] & is_write)
        return m

    def _words(self) -> tuple[dict, list]:
        """What stands at each address, and (address of the lowest word, upper word) of live registers of two words."""
        words, holds = {}, []
        for register in REGISTERS.registers:
            if is_recorded(register):
                continue
            if register.access is Access.COMMAND:
                words |= {place: Const(0, WORD_BITS) for place in register.addresses}
                continue
            value = getattr(self, register.name).as_unsigned()
            parts = [value[WORD_BITS * i : WORD_BITS * (i + 1)] for i in range(register.words)]
            if register.words > 1 and register.access is Access.READ:
                assert register.words == 2, "a live register has two words at the most; wider ones are recorded"
                holds.append((register.address, parts[1]))
                parts[1] = Mux(self.bus.following, self.held, parts[1])
            words |= dict(zip(register.addresses, parts, strict=True))
        return words, holds

    def _write(self, m: Module, here, in_window, acts) -> None:
        """Let a written word act. Of a wide register the lower word waits for the upper one."""
        word, lower = self.bus.write_word, Signal(WORD_BITS)
        with m.If(acts):
            m.d.sync += lower.eq(word)
        for register in REGISTERS.registers:
            if register.access is Access.READ:
                continue
            assert register.words <= 2, "a setting has two words at the most"
            output = getattr(self, register.name)
            if register.access is Access.COMMAND:
                m.d.sync += output.eq(0)
            with m.If(acts & here(register.addresses[-1])):
                m.d.sync += output.eq(word if register.words == 1 else Cat(lower, word))
        m.d.sync += self.window_write.eq(Cat(in_window) & acts.replicate(len(in_window)))


def _facts(register: Register, word: int) -> int:
    """What must be known of a word to read it or to check a write: see the slices of `fact`."""
    recorded = is_recorded(register)
    kind = READ_ONLY if register.access is Access.READ else INSIDE if word else BEGINS
    is_last = word == register.words - 1
    bits = register.width - WORD_BITS * word if is_last else WORD_BITS
    forbidden = (1 << WORD_BITS) - (1 << bits)
    return recorded | kind << 1 | register.words << 3 | forbidden << 5
