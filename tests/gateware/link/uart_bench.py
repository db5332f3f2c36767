"""The register door over its two UART lines in Amaranth's simulator, byte by byte as a host sees it."""

import random

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import connect
from amaranth.sim import Simulator

from arcref.link.register import Access
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_file import RegisterFile
from arcref_gateware.link.register_layout import CONSTANTS, live_registers
from arcref_gateware.link.status_recorder import StatusRecorder
from arcref_gateware.link.uart_door import UartDoor

DIVISOR = 8

CONSTANT_VALUES = {name: 0x5A5A_1234 * (k + 3) % (1 << REGISTERS[name].width) for k, name in enumerate(CONSTANTS)}

SETTINGS = [register for register in REGISTERS.registers if register.access is not Access.READ]


class Door(wiring.Component):
    """UART door, register file and recorder, with live registers that are set by the test."""

    def __init__(self):
        super().__init__({})
        self.door, self.file, self.recorder = UartDoor(DIVISOR), RegisterFile(CONSTANT_VALUES), StatusRecorder()
        self.changed = Signal()

    def elaborate(self, platform):
        m = Module()
        m.submodules += [self.door, self.file, self.recorder]
        connect(m, self.door.bus, self.file.bus)
        has_bus = Signal()
        m.d.sync += has_bus.eq(self.door.wants_bus)
        m.d.comb += [
            self.door.has_bus.eq(has_bus & self.door.wants_bus),
            self.recorder.snapshot.eq(self.file.snapshot),
            self.file.snapshot_done.eq(self.recorder.snapshot_done),
            self.file.snapshot_number.eq(self.recorder.snapshot_number),
            self.file.record_valid.eq(self.recorder.record_valid),
            self.file.record_place.eq(self.recorder.record_place),
            self.file.record.eq(self.recorder.record),
            self.file.link_state.eq(self.door.requests_obeyed),
            self.file.packets_refused.eq(self.door.packets_refused),
        ]
        # One bit that tells when a write acts, so that the bench need not look at every port at every clock.
        outputs = Cat(getattr(self.file, r.name) for r in SETTINGS)
        before = Signal(
            len(outputs), init=Const.cast(Cat(Const(getattr(self.file, r.name).init, r.width) for r in SETTINGS)).value
        )
        m.d.sync += before.eq(outputs)
        m.d.comb += self.changed.eq((outputs != before) | self.file.window_write.any())
        return m


def exchange(chunks: list[bytes], live: dict[str, int], instant: dict[str, int], *, loading: bool = False):
    """Send each chunk, wait for silence, and give (the bytes that came back for each chunk, every write that acted)."""
    dut = Door()
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    answers: list[bytearray] = []
    acted: list[tuple[str, int]] = []
    over: list[bool] = []

    async def host(ctx):
        for register in live_registers():
            if register.name in live:
                ctx.set(getattr(dut.file, register.name), live[register.name])
        for name, value in instant.items():
            ctx.set(getattr(dut.recorder, name), value)
        ctx.set(dut.file.loading, loading)
        rng = random.Random(0)
        await ctx.tick().repeat(20)
        for chunk in chunks:
            answers.append(bytearray())
            for byte in chunk:
                for bit in (0, *(byte >> i & 1 for i in range(8)), 1):
                    ctx.set(dut.door.rx, bit)
                    await ctx.tick().repeat(DIVISOR)
                await ctx.tick().repeat(1 + rng.randrange(4))
            quiet, before = 0, len(answers[-1])
            while quiet < 48:
                await ctx.tick().repeat(DIVISOR * 12)
                quiet = quiet + 1 if len(answers[-1]) == before else 0
                before = len(answers[-1])
        # The other two end by themselves: a simulator that is dropped with one in the middle of a wait complains.
        over.append(True)
        await ctx.tick().repeat(2)

    async def line(ctx):
        while not over:
            await ctx.tick()
            if ctx.get(dut.door.tx):
                continue
            await ctx.tick().repeat(DIVISOR + DIVISOR // 2 - 1)
            byte = 0
            for i in range(8):
                byte |= ctx.get(dut.door.tx) << i
                await ctx.tick().repeat(DIVISOR)
            assert ctx.get(dut.door.tx), "the stop bit was low"
            answers[-1].append(byte)

    async def watch(ctx):
        before = {register.name: register.reset for register in SETTINGS}
        while not over:
            await ctx.tick()
            if not ctx.get(dut.changed):
                continue
            for register in SETTINGS:
                value = ctx.get(getattr(dut.file, register.name))
                if value != before[register.name]:
                    before[register.name] = value
                    if register.access is Access.WRITE or value:
                        acted.append((register.name, value))
            written = ctx.get(dut.file.window_write)
            for i, window in enumerate(REGISTERS.windows):
                if written >> i & 1:
                    place = ctx.get(dut.file.window_address) % window.words
                    acted.append((f"{window.name}[{place}]", ctx.get(dut.file.window_word)))

    simulator.add_testbench(host)
    simulator.add_testbench(line, background=True)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    return [bytes(answer) for answer in answers], acted
