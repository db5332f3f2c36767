"""SPI on the core with its wire: a master of zeros reads what the bare core sends, one that asks reaches registers.

The longer tests of the registers over SPI are those of the cocotb bench and of the twin.
"""

from functools import cache

import numpy as np
from amaranth_bench import Bench, as_bits
from encoder_lines import GATE_STATE_NUMBER, lines_of_counts
from spi_lines import SpiLines, to_bytes

from arcref.angle import LINES_PER_TURN
from arcref.correction_rom import CorrectionRom
from arcref.flags import Flag
from arcref.link.packet import Status
from arcref.link.register import UNKNOWN_WORD
from arcref.link.registers import MAGIC, REGISTERS
from arcref.position_frame import (
    PositionFrame,
    RegisterFrame,
    encode_clear_flags,
    encode_read_register,
    encode_write_register,
)
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, STROBE_BIT, Z_BIT
from arcref_gateware.reference_encoder import ReferenceEncoder

SAMPLES = 2
LINES = {"a": A_BIT, "b": B_BIT, "z": Z_BIT, "strobe": STROBE_BIT}
SPI = ["spi_sck", "spi_cs_n", "spi_copi"]
DIVISOR = 8
CLOCK_HZ = 100e6
SOON = 90
"""Clocks of chip select high in which a register answers, a snapshot's too."""


def rom() -> CorrectionRom:
    return CorrectionRom((np.arange(LINES_PER_TURN) % 500 - 250).astype(np.int16))


@cache
def bare() -> Bench:
    return Bench(ReferenceEncoder(rom(), SAMPLES), [*LINES, *SPI], ["spi_cipo"])


@cache
def connected() -> Bench:
    core = ConnectedEncoder(rom(), SAMPLES, word_clock_hz=CLOCK_HZ, baud=CLOCK_HZ / DIVISOR)
    outputs = ["spi_cipo", "uart_tx", "raw_position", "generator_rate", "generator_control"]
    return Bench(core, [*LINES, *SPI, "uart_rx"], outputs)


def moving_lines(clocks: int) -> dict:
    """Over the zero mark, with an illegal step, back over it, and on."""
    zero = GATE_STATE_NUMBER
    path = np.concatenate((np.arange(zero - 60, zero + 90), np.arange(zero + 91, zero - 200, -1)))
    counts = np.repeat(path, 3)
    counts = np.concatenate((counts, counts[-1] - np.arange(clocks * SAMPLES) // 4))[: clocks * SAMPLES]
    words = lines_of_counts(counts, counts == zero).to_words(SAMPLES)
    return {name: as_bits(words >> bit & 1) for name, bit in LINES.items()}


def run(bench: Bench, lines: SpiLines, clocks: int = 0, **more):
    """The bits read in each transfer, and the rows of the outputs."""
    spi = {f"spi_{name}": row for name, row in lines.rows().items()}
    clocks = max(clocks, len(spi["spi_sck"]))
    rows = bench.run(clocks, **moving_lines(clocks), **spi, **more)
    return lines.received(rows["spi_cipo"]), rows


def answers_of(commands: list[bytes], **more):
    """The answer to each command, asked one after the other with a position frame in between, and the rows."""
    lines = SpiLines()
    for command in commands:
        lines.transfer(command, gap=SOON)
        lines.transfer(gap=20)
        lines.transfer(gap=20)
    bits, rows = run(connected(), lines, **more)
    frames = [to_bytes(read) for read in bits]
    for frame in frames[0::3] + frames[2::3]:
        PositionFrame.decode(frame)
    return [RegisterFrame.decode(frame) for frame in frames[1::3]], rows


def test_a_master_that_sends_zeros_reads_what_the_bare_core_sends_bit_for_bit():
    lines = SpiLines(4, 4.5)
    for bits in (64, 64, 24, 32, 7, 64, 65, 80, 0, 1, 64, 63, 64):
        lines.transfer(bits=bits, gap=5)
    lines.transfer(b"\xff" * 8)
    lines.transfer(encode_clear_flags(Flag.ILLEGAL_STEP), gap=30)
    lines.transfer()
    (expected, bare_rows), (got, rows) = run(bare(), lines), run(connected(), lines)
    assert got == expected
    np.testing.assert_array_equal(rows["spi_cipo"], bare_rows["spi_cipo"])
    before, after = (PositionFrame.decode(to_bytes(got[place])) for place in (5, -1))
    assert before.homed
    assert before.flags & Flag.ILLEGAL_STEP
    assert not after.flags & Flag.ILLEGAL_STEP
    assert len({PositionFrame.decode(to_bytes(read)).angle for read in got if len(read) == 64}) > 4


def test_registers_are_read_and_written_word_by_word():
    address = {name: register.address for name, register in REGISTERS.items()}
    wide = 0x00ABCDEF
    commands = [
        ("read", address["magic"], Status.DONE, MAGIC),
        ("read", 0x0FFF, Status.DONE, UNKNOWN_WORD),
        ("write", address["strobe_delay"], Status.DONE, 4000),
        ("read", address["strobe_delay"], Status.DONE, 4000),
        ("write", address["magic"], Status.READ_ONLY, 1),
        ("write", 0x00FE, Status.UNKNOWN_ADDRESS, 1),
        # A register of two words is written the lower word first, and acts with the upper one.
        ("write", address["generator_rate"], Status.DONE, wide & 0xFFFF),
        ("read", address["generator_rate"], Status.DONE, 0),
        ("write", address["generator_rate"] + 1, Status.DONE, wide >> 16),
        ("read", address["generator_rate"] + 1, Status.DONE, wide >> 16),
        ("write", address["generator_control"], Status.DONE, 0x23),
    ]
    frames = [
        encode_read_register(place) if kind == "read" else encode_write_register(place, word)
        for kind, place, _, word in commands
    ]
    answers, rows = answers_of(frames)
    for (kind, place, status, word), answer in zip(commands, answers, strict=True):
        got = kind, answer.address, Status(answer.status), answer.word
        assert got == (kind, place, status, word)
    assert set(rows["generator_rate"]) == {0, wide}, "it changes at once, not half by half"
    assert rows["generator_control"][-1] == 0x23
