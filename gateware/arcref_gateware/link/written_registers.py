"""Settings and commands: what a write does."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.register import WORD_BITS, Access
from arcref_gateware.link.register_layout import settings, writable_registers

_TOGETHER = 4

GRID_REGISTERS = ("compare_period", "compare_start")
"""Registers with which the compare output begins a new grid."""


class WrittenRegisters(wiring.Component):
    """An output for each register that can be written, by its name; `resets` gives settings another reset value.

    The registers are told apart by inputs as `RegisterDecoder` has them.
    """

    def __init__(self, resets: dict[str, int]):
        def reset(register):
            return resets.get(register.name, register.reset) if register.access is Access.WRITE else 0

        super().__init__(
            {register.name: Out(register.width, init=reset(register)) for register in writable_registers()}
            | {f"at_{register.name}": In(1) for register in writable_registers()}
            | {f"in_{register.name}": In(1) for register in settings()}
            | {
                "act": In(1),
                "word": In(WORD_BITS),
                "lower_word": In(WORD_BITS),
                "as_after_reset": Out(1),
                "grid_written": Out(1),
            }
        )

    act: In
    """1 for one clock: the last word of the register at the place is written."""
    word: In
    """That word."""
    lower_word: In
    """Of a register of two words the first one, as it stands in the memory."""
    as_after_reset: Out
    """1 when the place is a setting's that was not written since reset; two clocks behind the place's inputs."""
    grid_written: Out
    """1 for one clock, the first with the new value, when a register of `GRID_REGISTERS` was written."""

    def elaborate(self, platform):
        m = Module()
        unwritten, grid_writes = [], []
        for register in writable_registers():
            output, writes = getattr(self, register.name), Signal(name=f"writes_{register.name}")
            m.d.sync += writes.eq(getattr(self, f"at_{register.name}") & self.act)
            if register.name in GRID_REGISTERS:
                grid_writes.append(writes)
            if register.access is Access.COMMAND:
                assert register.words == 1, "a command has one word"
                m.d.sync += output.eq(self.word & writes.replicate(register.width))
                continue
            written = Signal(name=f"{register.name}_written")
            unwritten.append(getattr(self, f"in_{register.name}") & ~written)
            # Not an enable: of a register with a reset, an iCE40's enable would have to wait for the reset as well.
            value = (self.word if register.words == 1 else Cat(self.lower_word, self.word))[: register.width]
            mask = writes.replicate(register.width)
            m.d.sync += [output.eq((value & mask) | (output & ~mask)), written.eq(written | writes)]
        parts = []
        for k in range(0, len(unwritten), _TOGETHER):
            parts.append(Signal(name=f"unwritten{k}"))
            m.d.sync += parts[-1].eq(Cat(unwritten[k : k + _TOGETHER]).any())
        m.d.sync += self.grid_written.eq(Cat(grid_writes).any())
        m.d.sync += self.as_after_reset.eq(Cat(parts).any())
        return m
