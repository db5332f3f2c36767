"""The register file, made from the declaration in `arcref.link.registers`.

A word goes through four clocks: the address is decoded to one group of sixteen words, each group picks its word, the
groups are joined, the answer is given. Registers that a snapshot or a fault log holds come from `StatusRecorder`'s
memory, windows from memories elsewhere.
"""

from amaranth.hdl import Array, Cat, Const, Module, Mux, Signal, signed
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD, WORD_BITS, Access, Register
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request
from arcref_gateware.link.status_recorder import is_recorded

ANSWER_CLOCKS = 6
"""Clocks from `valid` to `done`, unless a snapshot is taken."""

GROUP_BITS = 4


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
    """The word, two clocks later."""
    window_address: Out
    """Word of a window, counted from its beginning."""
    identity_word: In
    """Word of the identity memory, `ANSWER_CLOCKS` - 2 clocks after its address."""
    loading: In
    """1 while trial tables are loaded: the windows may be written."""
    window_write: Out
    """Bit n: write `window_word` to window n of the declaration, for one clock."""
    window_word: Out
    """Word for a window."""

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        address = Signal(len(bus.address))
        m.d.sync += address.eq(bus.address)
        low = address[:GROUP_BITS]
        m.d.comb += [
            # The snapshot stands at 0x10.., the fault logs at 0x40..: see StatusRecorder for the memory's order.
            self.recorded_address.eq(Cat(address[:5], address[5] | ~address[6])),
            self.window_address.eq(address[:12]),
            self.window_word.eq(bus.write_word),
        ]

        # The upper words of live registers are kept as their lowest word is read, so that a number is never torn.
        held = Signal(WORD_BITS)
        words: dict[int, object] = {}
        holds = []
        for register in REGISTERS.registers:
            if is_recorded(register):
                continue
            if register.access is Access.COMMAND:
                words |= {place: Const(0, WORD_BITS) for place in register.addresses}
                continue
            value = getattr(self, register.name)
            if register.words == 1 or register.access is Access.WRITE:
                for i, place in enumerate(register.addresses):
                    words[place] = value[WORD_BITS * i : WORD_BITS * (i + 1)]
                continue
            assert register.words == 2, "a live register has two words at the most; wider ones are recorded"
            upper = Signal(WORD_BITS, name=f"{register.name}_upper")
            m.d.comb += upper.eq(value[WORD_BITS:].as_unsigned())
            words[register.address] = value[:WORD_BITS]
            words[register.address + 1] = Mux(bus.following, held, upper)
            holds.append((register.address, upper))

        groups = sorted({place >> GROUP_BITS for place in words})
        joined = 0
        for group in groups:
            selected = Signal(name=f"group{group:x}")
            word = Signal(WORD_BITS, name=f"word{group:x}")
            members = [words.get(group << GROUP_BITS | i, Const(UNKNOWN_WORD, WORD_BITS)) for i in range(16)]
            here = Signal(name=f"here{group:x}")
            m.d.comb += here.eq(address[GROUP_BITS:] == group)
            m.d.sync += [selected.eq(here), word.eq(Array(members)[low])]
            joined = joined | Mux(selected, word, 0)
        recorded = [place for r in REGISTERS.registers if is_recorded(r) for place in r.addresses]
        identity = REGISTERS["identity"]
        in_recorded, in_identity, in_registers = Signal(), Signal(), Signal()
        recorded_groups = sorted({place >> GROUP_BITS for place in recorded})
        is_recorded_place = Signal()
        m.d.comb += is_recorded_place.eq(_is_one_of(address, recorded))
        m.d.sync += [
            in_recorded.eq(is_recorded_place),
            in_identity.eq(address[9:] == identity.address >> 9),
            in_registers.eq(_is_one_of(address[GROUP_BITS:], groups)),
        ]
        assert recorded_groups
        read_word = Signal(WORD_BITS)
        plain = Signal(WORD_BITS)
        other = Signal(WORD_BITS)
        m.d.sync += [
            plain.eq(Mux(in_registers & ~in_recorded, joined, 0)),
            other.eq(Mux(in_registers | in_recorded | in_identity, 0, UNKNOWN_WORD)),
        ]
        recorded_now, identity_now = Signal(), Signal()
        m.d.sync += [recorded_now.eq(in_recorded), identity_now.eq(in_identity)]
        m.d.sync += read_word.eq(
            plain | other | Mux(recorded_now, self.recorded_word, 0) | Mux(identity_now, self.identity_word, 0)
        )

        self._check(m, address)
        snapshot_address = REGISTERS["snapshot_number"].address
        stage = Signal(ANSWER_CLOCKS)
        waits = Signal()
        at_snapshot = Signal()
        m.d.sync += [
            stage.eq(Cat(bus.valid, stage)),
            at_snapshot.eq((address == snapshot_address) & (bus.request == Request.READ)),
            self.snapshot.eq(0),
            bus.done.eq(0),
        ]
        m.d.comb += bus.read_word.eq(read_word)
        with m.If(stage[1] & at_snapshot):
            m.d.sync += [self.snapshot.eq(1), waits.eq(1)]
        with m.If(self.snapshot_done & waits):
            m.d.sync += [waits.eq(0), bus.done.eq(1)]
        with m.If(stage[-2] & ~waits):
            m.d.sync += bus.done.eq(1)
        with m.If(stage[1] & (bus.request == Request.READ)):
            for place, upper in holds:
                with m.If(address == place):
                    m.d.sync += held.eq(upper)
        acts = Signal()
        m.d.comb += acts.eq(stage[2] & (bus.request == Request.WRITE))
        self._write(m, address, acts)
        return m

    def _check(self, m: Module, address) -> None:
        """Whether the word at `address` could be written, as `LinkModel` says it."""
        bus = self.bus
        kind, words, highest_bits = Signal(2), Signal(2), Signal(5)
        unknown, read_only, inside, begins = range(4)
        in_window = Signal()
        m.d.sync += [kind.eq(unknown), words.eq(0), highest_bits.eq(WORD_BITS), in_window.eq(0)]
        with m.Switch(address):
            for register in REGISTERS.registers:
                for i, place in enumerate(register.addresses):
                    with m.Case(place):
                        if register.access is Access.READ:
                            m.d.sync += kind.eq(read_only)
                        else:
                            is_last = i == register.words - 1
                            bits = register.width - WORD_BITS * i if is_last else WORD_BITS
                            m.d.sync += [
                                kind.eq(inside if i else begins),
                                words.eq(register.words),
                                highest_bits.eq(bits),
                            ]
        for window in REGISTERS.windows:
            with m.If(address[window.words.bit_length() - 1 :] == window.address // window.words):
                m.d.sync += in_window.eq(1)
        fits = Signal()
        m.d.sync += fits.eq((bus.write_word >> highest_bits) == 0)
        status = Signal(STATUS_BITS)
        m.d.sync += status.eq(Status.DONE)
        with m.If(in_window), m.If(~self.loading):
            m.d.sync += status.eq(Status.NOT_NOW)
        with m.Elif(kind == unknown):
            m.d.sync += status.eq(Status.UNKNOWN_ADDRESS)
        with m.Elif(kind == read_only):
            m.d.sync += status.eq(Status.READ_ONLY)
        with m.Elif(~fits | (kind == inside) & ~bus.following | (kind == begins) & (bus.words_left < words)):
            m.d.sync += status.eq(Status.OUT_OF_RANGE)
        m.d.comb += bus.status.eq(Mux(bus.request == Request.READ, Status.DONE, status))

    def _write(self, m: Module, address, acts) -> None:
        """Let a written word act. Of a wide register the lower word waits for the upper one."""
        word, lower = self.bus.write_word, Signal(WORD_BITS)
        with m.If(acts):
            m.d.sync += lower.eq(word)
        for register in REGISTERS.registers:
            if register.access is Access.READ:
                continue
            assert register.words <= 2, "a setting has two words at the most"
            output = getattr(self, register.name)
            here = Signal(name=f"{register.name}_here")
            m.d.sync += here.eq(address == register.addresses[-1])
            if register.access is Access.COMMAND:
                m.d.sync += output.eq(0)
            with m.If(acts & here):
                m.d.sync += output.eq(word if register.words == 1 else Cat(lower, word))
        for i, window in enumerate(REGISTERS.windows):
            here = Signal(name=f"{window.name}_here")
            m.d.sync += here.eq(address[window.words.bit_length() - 1 :] == window.address // window.words)
            m.d.sync += self.window_write[i].eq(acts & here)


def _is_one_of(value, numbers) -> object:
    """1 when `value` is one of `numbers`."""
    found = Const(0, 1)
    for number in numbers:
        found = found | (value == number)
    return found
