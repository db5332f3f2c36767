"""An SPI controller in mode 0, with a clock of its own that has nothing to do with the core's."""

from dataclasses import dataclass

import cocotb
from arcref.position_frame import FRAME_BITS
from cocotb.simtime import get_sim_time
from cocotb.triggers import Timer
from core_driver import CLOCK_PERIOD_PS

FASTEST_PERIOD_PS = 8 * CLOCK_PERIOD_PS

SELECT_TO_CLOCK_PS = 4 * CLOCK_PERIOD_PS
"""Chip select falls this long before the first rising edge of the clock, at the least."""

BETWEEN_FRAMES_PS = 3 * CLOCK_PERIOD_PS
"""Chip select stays high this long, at the least."""


@dataclass(frozen=True)
class Transfer:
    """What came back: `bits` in the order of the wire, and when chip select fell, in picoseconds."""

    bits: list[int]
    selected_ps: int

    @property
    def data(self) -> bytes:
        """The bits as bytes; those after the last whole byte are left out."""
        whole = len(self.bits) // 8
        return bytes(int("".join(map(str, self.bits[8 * i : 8 * i + 8])), 2) for i in range(whole))


class SpiController:
    """Reads frames from the core's SPI pins, `period_ps` a bit."""

    def __init__(self, dut, period_ps: int = FASTEST_PERIOD_PS):
        self.dut, self.period_ps = dut, period_ps

    async def transfer(
        self, sent: bytes = bytes(8), bits: int = FRAME_BITS, *, lead_ps: int = 0, cut_ps: int | None = None
    ) -> Transfer:
        """Select the core, send and read `bits` bits, and let it go; zeros follow when `sent` is too short.

        `lead_ps` comes on top of the shortest time from chip select to clock. With `cut_ps` chip select rises that long
        after the last rising edge of the clock, wherever the clock stands, in place of a proper end.
        """
        dut, half = self.dut, self.period_ps // 2
        out = [byte >> 7 - bit & 1 for byte in sent for bit in range(8)]
        dut.spi_cs_n.value = 0
        selected_ps = round(get_sim_time("ps"))
        received = []
        dut.spi_copi.value = out[0]
        await Timer(max(SELECT_TO_CLOCK_PS + lead_ps, half), "ps")
        for bit in range(bits):
            received.append(int(dut.spi_cipo.value))
            dut.spi_sck.value = 1
            if cut_ps is not None and bit == bits - 1:
                await Timer(cut_ps, "ps")
                dut.spi_cs_n.value = 1
                await Timer(half, "ps")
                dut.spi_sck.value = 0
                break
            await Timer(half, "ps")
            dut.spi_sck.value = 0
            dut.spi_copi.value = out[bit + 1] if bit + 1 < len(out) else 0
            await Timer(self.period_ps - half, "ps")
        dut.spi_cs_n.value = 1
        await Timer(BETWEEN_FRAMES_PS, "ps")
        return Transfer(received, selected_ps)


async def wait_until_ps(time_ps: int) -> None:
    """Wait until an instant, if it is still to come."""
    wait = time_ps - round(get_sim_time("ps"))
    if wait > 0:
        await Timer(wait, "ps")


def start(coroutine) -> cocotb.task.Task:
    """Run a coroutine beside the bench."""
    return cocotb.start_soon(coroutine)
