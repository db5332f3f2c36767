"""The register file on its bus, word by word, against the declaration."""

import random

import pytest
from amaranth.hdl import Module, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.sim import Simulator

from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD, Access
from arcref.link.registers import REGISTERS
from arcref_gateware.link.register_bus import Request
from arcref_gateware.link.register_file import RegisterFile
from arcref_gateware.link.register_layout import (
    CONSTANTS,
    initial_words,
    is_recorded,
    live_registers,
    settings,
    writable_registers,
)
from arcref_gateware.link.status_recorder import StatusRecorder

CONSTANT_VALUES = {name: 0xC0DE_5EA1 >> k & (1 << REGISTERS[name].width) - 1 for k, name in enumerate(CONSTANTS)}
RESETS = {"strobe_delay": 4000, "gate_state": 0b10}
LONGEST_WAIT = 400

AT = {place: (register, i) for register in REGISTERS.registers for i, place in enumerate(register.addresses)}
WINDOW_AT = {place: window for window in REGISTERS.windows for place in window.addresses}


def reset_of(register):
    return RESETS.get(register.name, register.reset) if register.access is Access.WRITE else 0


class Instrument(wiring.Component):
    def __init__(self):
        self.file, self.recorder = RegisterFile(CONSTANT_VALUES, RESETS), StatusRecorder()
        super().__init__({})

    def elaborate(self, platform):
        m = Module()
        m.submodules.file, m.submodules.recorder = file, recorder = self.file, self.recorder
        m.d.comb += [
            recorder.snapshot.eq(file.snapshot),
            file.snapshot_done.eq(recorder.snapshot_done),
            file.snapshot_number.eq(recorder.snapshot_number),
            file.record_valid.eq(recorder.record_valid),
            file.record_place.eq(recorder.record_place),
            file.record.eq(recorder.record),
        ]
        return m


class Rig:
    """Asks on the bus as a door does; `every_clock` may change the inputs."""

    def __init__(self, body, every_clock=lambda rig: None):
        self.dut, self.reset = Instrument(), Signal()
        self.file, self.every_clock, self.acted = self.dut.file, every_clock, []
        self.clock_number = 0
        simulator = Simulator(ResetInserter(self.reset)(self.dut))
        simulator.add_clock(1e-6)

        async def drive(ctx):
            self.ctx = ctx
            await body(self)

        simulator.add_testbench(drive)
        simulator.run()

    def set(self, name, value):
        self.ctx.set(getattr(self.file, name), value)

    def get(self, name):
        return self.ctx.get(getattr(self.file, name))

    async def tick(self, clocks=1):
        for _ in range(clocks):
            self.every_clock(self)
            await self.ctx.tick()
            self.clock_number += 1
            for register in writable_registers():
                if register.access is Access.COMMAND and (value := self.get(register.name)):
                    self.acted.append((register.name, value))
            if written := self.get("window_write"):
                names = [window.name for bit, window in enumerate(REGISTERS.windows) if written >> bit & 1]
                self.acted.append((*names, self.get("window_address"), self.get("window_word")))

    async def restart(self):
        self.ctx.set(self.reset, 1)
        await self.tick()
        self.ctx.set(self.reset, 0)

    async def ask(self, request, address, word=0, *, following=False, is_last=True):
        bus = self.file.bus
        for port, value in (
            (bus.request, request),
            (bus.address, address),
            (bus.write_word, word),
            (bus.following, following),
            (bus.is_last, is_last),
            (bus.valid, 1),
        ):
            self.ctx.set(port, value)
        await self.tick()
        self.ctx.set(bus.valid, 0)
        for _ in range(LONGEST_WAIT):
            if self.ctx.get(bus.done):
                return self.ctx.get(bus.read_word), Status(self.ctx.get(bus.status))
            await self.tick()
        raise AssertionError(f"{request} of {address:#06x} was never answered")

    async def read(self, name, *, following=True):
        register = REGISTERS[name]
        words = []
        for i, place in enumerate(register.addresses):
            word, status = await self.ask(Request.READ, place, following=following and i > 0)
            assert status is Status.DONE
            words.append(word)
        return register.decode(words)

    async def write(self, name, value):
        """As the UART's door does; gives the status."""
        register = REGISTERS[name]
        words = [value >> 16 * i & 0xFFFF for i in range(register.words)]
        for request in (Request.CHECK, Request.WRITE):
            for i, word in enumerate(words):
                asked = await self.ask(
                    request, register.address + i, word, following=i > 0, is_last=i == len(words) - 1
                )
                if asked[1] is not Status.DONE:
                    return asked[1]
        return Status.DONE


def expected_status(address, word, *, following, is_last, loading) -> Status:
    if address in WINDOW_AT:
        return Status.DONE if loading else Status.NOT_NOW
    if address not in AT:
        return Status.UNKNOWN_ADDRESS
    register, i = AT[address]
    if register.access is Access.READ:
        return Status.READ_ONLY
    fits = not word >> min(16, register.width - 16 * i)
    whole = (i == 0 or following) and not (i == 0 and register.words > 1 and is_last)
    return Status.DONE if fits and whole else Status.OUT_OF_RANGE


@pytest.mark.parametrize("loading", [False, True])
def test_a_check_says_of_every_address_what_the_declaration_says_and_changes_nothing(loading):
    rng = random.Random(loading)

    async def body(rig):
        rig.set("loading", loading)
        addresses = [*range(0x100), 0x1FF, 0x200, 0x3FF, 0x400, 0x5FF, 0x600, 0xFFF, 0x1000, 0x1FFF, 0x2000, 0xFFFF]
        addresses += [rng.getrandbits(16) for _ in range(20)] + [place | 0x100 for place in rng.sample(sorted(AT), 20)]
        for address in addresses:
            for word in {0, 1 << rng.randrange(16), rng.getrandbits(16)}:
                following, is_last = rng.random() < 0.5, rng.random() < 0.5
                _, status = await rig.ask(Request.CHECK, address, word, following=following, is_last=is_last)
                right = expected_status(address, word, following=following, is_last=is_last, loading=loading)
                assert status is right, f"{address:#06x} {word:#06x} {following} {is_last}"
        assert rig.acted == []
        for register in settings():
            assert rig.get(register.name) == reset_of(register)
            assert await rig.read(register.name) == reset_of(register)

    Rig(body)


def test_every_address_reads_its_own_word_with_reset_values_before_anything_is_written():
    live = {r.name: 0x9ABC_DEF0 * (k + 7) % (1 << r.width) for k, r in enumerate(live_registers())}

    async def body(rig):
        for name, value in live.items():
            rig.set(name, value)
        rig.set("identity_word", 0x1D1D)
        await rig.tick(5)
        for address in [*range(0x100), 0x100, 0x1FF, 0x200, 0x3FF, 0x400, 0x1000, 0x2000, 0xFF10, 0xFFFF]:
            register, i = AT.get(address, (None, 0))
            if address in WINDOW_AT:
                right = 0x1D1D if WINDOW_AT[address].access is Access.WRITE else UNKNOWN_WORD
            elif register is None:
                right = UNKNOWN_WORD
            elif is_recorded(register) or register.name == "snapshot_number":
                continue
            else:
                value = (CONSTANT_VALUES | live).get(register.name, reset_of(register))
                right = value >> 16 * i & 0xFFFF
            word, status = await rig.ask(Request.READ, address, rng.getrandbits(16))
            assert (word, status) == (right, Status.DONE), hex(address)

    rng = random.Random(2)
    Rig(body)


def test_settings_read_what_was_written_and_their_reset_values_after_a_reset_in_the_middle():
    rng = random.Random(4)

    async def body(rig):
        values = {r.name: reset_of(r) for r in settings()}
        for _ in range(120):
            if rng.random() < 0.06:
                await rig.restart()
                values = {r.name: reset_of(r) for r in settings()}
                if rng.random() < 0.5:
                    await rig.tick(rng.randrange(9))
            register = rng.choice(settings())
            if rng.random() < 0.6:
                value = rng.choice([0, 1, rng.getrandbits(register.width), rng.getrandbits(register.width + 1)])
                status = await rig.write(register.name, value)
                if value >> register.width and (register.width % 16 or register.words < 2) and register.width < 16:
                    assert status is Status.OUT_OF_RANGE
                if status is Status.DONE:
                    values[register.name] = value & (1 << register.width) - 1
            assert await rig.read(register.name, following=rng.random() < 0.5) == values[register.name]
            await rig.tick(3)
            assert {r.name: rig.get(r.name) for r in settings()} == values
        for name, value in values.items():
            assert await rig.read(name) == value

    Rig(body)


def test_a_request_that_a_reset_cuts_short_does_nothing_afterwards():
    async def body(rig):
        bus = rig.file.bus
        for after in range(1, 24):
            for port, value in (
                (bus.request, Request.WRITE),
                (bus.address, REGISTERS["home"].address),
                (bus.write_word, 1),
            ):
                rig.ctx.set(port, value)
            rig.ctx.set(bus.valid, 1)
            await rig.tick()
            rig.ctx.set(bus.valid, 0)
            await rig.tick(after)
            if rig.ctx.get(bus.done):
                break
            await rig.restart()
            rig.acted.clear()
            await rig.tick(40)
            assert rig.acted == []
            assert await rig.read("strobe_delay") == RESETS["strobe_delay"]
        assert after > 12

    Rig(body)


def test_commands_act_for_one_clock_and_read_nothing():
    rng = random.Random(6)

    async def body(rig):
        for register in writable_registers() * 3:
            if register.access is Access.COMMAND:
                value = rng.randrange(1, 1 << register.width)
                rig.acted.clear()
                assert await rig.write(register.name, value) is Status.DONE
                await rig.tick(10)
                assert rig.acted == [(register.name, value)]
                assert await rig.read(register.name) == 0

    Rig(body)


def test_words_of_windows_are_written_to_their_places():
    rng = random.Random(7)

    async def body(rig):
        rig.set("loading", 1)
        for window in REGISTERS.windows * 4:
            place, word = rng.randrange(window.words), rng.getrandbits(16)
            rig.acted.clear()
            await rig.ask(Request.WRITE, window.address + place, word)
            await rig.tick(10)
            (name, address, written), *more = rig.acted
            assert (name, address % window.words, written, more) == (window.name, place, word, [])

    Rig(body)


def test_a_live_number_of_two_words_is_of_one_clock_and_a_wide_read_is_never_torn():
    wide = [r for r in live_registers() if r.words == 2]

    def spin(rig):
        # In both words the same number, another one in every clock.
        for register in wide:
            low = rig.clock_number & (1 << register.width - 16) - 1
            value = low << 16 | low
            rig.set(register.name, register.decode([value & 0xFFFF, value >> 16]))

    async def body(rig):
        for k in range(40):
            await rig.tick(k % 7)
            for register in wide:
                first, _ = await rig.ask(Request.READ, register.address)
                if k % 2:
                    await rig.tick(k)
                second, _ = await rig.ask(Request.READ, register.address + 1, following=True)
                assert first == second, register.name
                alone, _ = await rig.ask(Request.READ, register.address + 1)
                assert alone != second, "a word that follows nothing is read anew"

    Rig(body, spin)


def test_a_setting_of_two_words_acts_as_one_with_its_upper_word_even_when_others_write_between():
    """As over SPI, a word a frame."""
    rng = random.Random(8)
    wide = [r for r in settings() if r.words == 2]

    async def body(rig):
        for _ in range(12):
            values = {r.name: rng.getrandbits(r.width) for r in wide}
            before = {r.name: rig.get(r.name) for r in wide}
            for register in wide:
                for request in (Request.CHECK, Request.WRITE):
                    word = values[register.name] & 0xFFFF
                    assert (await rig.ask(request, register.address, word, following=True, is_last=False))[
                        1
                    ] is Status.DONE
            await rig.tick(20)
            assert {r.name: rig.get(r.name) for r in wide} == before
            assert await rig.write("strobe_delay", rng.getrandbits(16)) is Status.DONE
            for register in reversed(wide):
                for request in (Request.CHECK, Request.WRITE):
                    word = values[register.name] >> 16
                    await rig.ask(request, register.address + 1, word, following=True, is_last=False)
            await rig.tick(4)
            assert {r.name: rig.get(r.name) for r in wide} == values
            assert {r.name: await rig.read(r.name) for r in wide} == values

    Rig(body)


def test_snapshots_are_numbered_and_of_the_time_of_their_request():
    def run(rig):
        for name in ("raw_position", "time", "position"):
            rig.ctx.set(getattr(rig.dut.recorder, name), rig.clock_number)

    async def body(rig):
        number = 0
        for k in range(12):
            if k == 7:
                await rig.restart()
                number = 0
            await rig.tick(11 * k)
            asked = rig.clock_number
            number += 1
            assert await rig.read("snapshot_number") == number
            answered = rig.clock_number
            values = [await rig.read(name) for name in ("snapshot_raw", "snapshot_time", "snapshot_position")]
            assert values[0] == values[1] == values[2]
            assert asked <= values[0] <= asked + 20 < answered
            again, _ = await rig.ask(Request.READ, REGISTERS["snapshot_raw"].address)
            assert again == values[0], "reading another word of the pair takes no snapshot"

    Rig(body, run)


def test_the_memory_holds_every_word_of_the_declaration_at_power_up():
    words = initial_words(CONSTANT_VALUES, RESETS)
    for place, word in enumerate(words[:0xC1]):
        register, i = AT.get(place, (None, 0))
        if register is None:
            assert word == UNKNOWN_WORD
        else:
            assert word == CONSTANT_VALUES.get(register.name, reset_of(register)) >> 16 * i & 0xFFFF
