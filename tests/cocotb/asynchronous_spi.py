"""An SPI controller in mode 0, with a clock of its own that has nothing to do with the core's."""

from dataclasses import dataclass

import cocotb
from cocotb.simtime import get_sim_time
from cocotb.triggers import Timer
from core_driver import CLOCK_PERIOD_PS, CoreDriver

from arcref.position_frame import FRAME_BITS, PositionFrame

FASTEST_PERIOD_PS = 8 * CLOCK_PERIOD_PS

SELECT_TO_CLOCK_PS = 4 * CLOCK_PERIOD_PS
"""The shortest time from chip select falling to the first rising edge of the clock."""

BETWEEN_FRAMES_PS = 3 * CLOCK_PERIOD_PS
"""The shortest time for which chip select is high."""


@dataclass(frozen=True)
class Transfer:
    """What came back: `bits` in the order of the wire, and when chip select fell, in picoseconds."""

    bits: list[int]
    selected_ps: int

    @property
    def data(self) -> bytes:
        """The bits as bytes; those after the last whole byte are left out."""
        text = "".join(map(str, self.bits))
        return bytes(int(text[start : start + 8], 2) for start in range(0, len(text) - 7, 8))

    @property
    def frame(self) -> PositionFrame:
        """The position frame, its CRC checked."""
        return PositionFrame.decode(self.data)


class SpiController:
    """Reads frames from the core's SPI pins, `period_ps` a bit."""

    def __init__(self, dut, period_ps: int = FASTEST_PERIOD_PS):
        self.dut, self.period_ps = dut, period_ps

    async def transfer(
        self, sent: bytes = bytes(8), bits: int = FRAME_BITS, *, lead_ps: int = 0, cut_ps: int | None = None
    ) -> Transfer:
        """Select the core, send and read `bits` bits, and let it go; zeros follow when `sent` is too short.

        `lead_ps` comes on top of the shortest time from chip select to clock. With `cut_ps` chip select rises that long
        after the last rising edge of the clock, or after `lead_ps` when there was none, in place of a proper end.
        """
        dut, half = self.dut, self.period_ps // 2
        out = [byte >> 7 - bit & 1 for byte in sent for bit in range(8)] + [0] * bits
        dut.spi_cs_n.value, dut.spi_copi.value = 0, out[0]
        selected_ps = round(get_sim_time("ps"))
        await Timer(max(SELECT_TO_CLOCK_PS, half) + lead_ps, "ps")
        received = []
        for bit in range(bits):
            received.append(int(dut.spi_cipo.value))
            dut.spi_sck.value = 1
            if cut_ps is not None and bit == bits - 1:
                await self._cut(half, cut_ps)
                break
            await Timer(half, "ps")
            dut.spi_sck.value, dut.spi_copi.value = 0, out[bit + 1]
            await Timer(self.period_ps - half, "ps")
        dut.spi_cs_n.value = 1
        await Timer(BETWEEN_FRAMES_PS, "ps")
        return Transfer(received, selected_ps)

    async def _cut(self, half: int, cut_ps: int) -> None:
        """Raise chip select in the high or in the low half of a bit; the clock falls when it would have."""
        if cut_ps < half:
            await Timer(max(cut_ps, 1), "ps")
            self.dut.spi_cs_n.value = 1
            await Timer(half - max(cut_ps, 1) + 1, "ps")
            self.dut.spi_sck.value = 0
        else:
            await Timer(half, "ps")
            self.dut.spi_sck.value = 0
            await Timer(cut_ps - half + 1, "ps")


async def wait_ps(time_ps: int) -> None:
    """Let some time pass, none at all for 0."""
    if time_ps:
        await Timer(time_ps, "ps")


async def play_beside(driver: CoreDriver, coroutine, pieces):
    """Play `pieces` of states while `coroutine` runs, until it ends; returns its result."""
    task = cocotb.start_soon(coroutine)
    for states in pieces:
        if task.done():
            break
        await driver.play(states)
    return await task


def assert_frame_of_a_word(driver: CoreDriver, transfer: Transfer, counter: int) -> None:
    """A frame holds what the outputs showed in one of the two clocks after chip select fell, and its own number."""
    frame = transfer.frame
    shown = []
    for word in driver.words_shown_after(transfer.selected_ps):
        if word < 0:  # nothing was shown yet
            position = homed = flags = 0
        else:
            position, homed, flags = (int(driver.per_word(name)[word]) for name in ("position", "homed", "flags"))
        shown.append(PositionFrame.of_position(position, homed=bool(homed), flags=flags, frame_counter=counter & 0xFF))
    assert frame in shown, f"{frame} is none of {shown}"
