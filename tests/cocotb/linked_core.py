"""Drives the core with its wire: an encoder that turns without end, a host at the UART, and what the core shows."""

import os

import cocotb
from cocotb.clock import Clock
from cocotb.simtime import get_sim_time
from cocotb.triggers import ClockCycles, FallingEdge
from core_driver import CLOCK_PERIOD_PS, LINE_BITS
from core_under_test import LINKED_BAUD, LINKED_CLOCK_HZ, SAMPLES_VARIABLE

from arcref.link.packet import Packet
from arcref.link.packet_stream import PacketStream
from arcref.position_frame import PositionFrame

assert round(1e12 / LINKED_CLOCK_HZ) == CLOCK_PERIOD_PS
DIVISOR = round(LINKED_CLOCK_HZ / LINKED_BAUD)
SAMPLES_PER_COUNT = 3
SHOWN_CLOCKS = 4
"""Clocks after chip select has fallen within which a frame takes its position."""

STATES = (0, 1, 3, 2)


class LinkedCore:
    """One core with its wire. Inputs change, and outputs are looked at, at the falling edge of the clock."""

    def __init__(self, dut):
        self.dut = dut
        self.samples_per_word = int(os.environ[SAMPLES_VARIABLE])
        self.shown: list[tuple[int, int, bool, int]] = []
        """At each clock since the reset: time in ps, position, homed, flags."""
        self.packets: list[Packet] = []
        """Packets that came over the UART."""
        self._line: list[int] = []

    async def start(self) -> None:
        """Reset it, and let the encoder turn."""
        dut = self.dut
        Clock(dut.clk, CLOCK_PERIOD_PS, "ps", period_high=CLOCK_PERIOD_PS // 2).start()
        dut.spi_sck.value, dut.spi_cs_n.value, dut.spi_copi.value, dut.uart_rx.value = 0, 1, 0, 1
        for name in LINE_BITS:
            dut[name].value = 0
        dut.rst.value = 1
        await ClockCycles(dut.clk, 3)
        await FallingEdge(dut.clk)
        dut.rst.value = 0
        cocotb.start_soon(self._turn())
        cocotb.start_soon(self._listen())
        await ClockCycles(dut.clk, 40)

    async def _turn(self) -> None:
        dut, samples, edge = self.dut, self.samples_per_word, FallingEdge(self.dut.clk)
        sample, line = 0, iter(())
        while True:
            counts = [(sample + place) // SAMPLES_PER_COUNT for place in range(samples)]
            sample += samples
            words = {"a": 0, "b": 0, "z": 0}
            for place, count in enumerate(counts):
                words["a"] |= (STATES[count % 4] & 1) << place
                words["b"] |= (STATES[count % 4] >> 1) << place
                words["z"] |= (20 <= count < 24) << place
            for name, word in words.items():
                dut[name].value = word
            if (bit := next(line, None)) is None and self._line:
                line = iter(self._line)
                self._line = []
                bit = next(line)
            dut.uart_rx.value = 1 if bit is None else bit
            await edge
            position = dut.position.value.to_signed()
            flags = int(dut.flags.value)
            self.shown.append((round(get_sim_time("ps")), position, bool(dut.homed.value), flags))

    async def _listen(self) -> None:
        tx, edge, stream = self.dut.uart_tx, FallingEdge(self.dut.clk), PacketStream()
        list(stream.feed(b"\0"))
        while True:
            await FallingEdge(tx)
            await ClockCycles(self.dut.clk, DIVISOR + DIVISOR // 2)
            byte = 0
            for bit in range(8):
                byte |= int(tx.value) << bit
                await ClockCycles(self.dut.clk, DIVISOR)
            assert int(tx.value) == 1, "the stop bit is low"
            self.packets += stream.feed(bytes([byte]))
            await edge

    def send(self, packet: Packet) -> None:
        """Send a packet over the UART, after those before it, and a zero that ends whatever was on the line."""
        for byte in b"\0" + packet.encode():
            for bit in (0, *(byte >> place & 1 for place in range(8)), 1):
                self._line += [bit] * DIVISOR

    def assert_position(self, data: bytes, selected_ps: int, counter: int) -> None:
        """A frame holds what was shown at one clock right after chip select fell, and its own number."""
        frame = PositionFrame.decode(data)
        shown = [
            PositionFrame.of_position(position, homed=homed, flags=flags, frame_counter=counter & 0xFF)
            for time_ps, position, homed, flags in self.shown
            if 0 <= time_ps - selected_ps <= SHOWN_CLOCKS * CLOCK_PERIOD_PS
        ]
        assert frame in shown, f"{frame} is none of {shown}"
