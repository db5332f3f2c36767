"""The SPI port: one position frame a chip select, and command frames the other way.

SPI mode 0. The three inputs are asynchronous and sampled by the word clock through two registers each. The output is
chosen by the sampled clock itself, a clock before the edge is even recognised: that is what lets SCK run at one eighth
of the word clock with time left for the pads. Chip select must stay high for three word clocks between frames and fall
four before the first rising edge of SCK.
"""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.crc.catalog import CRC8_AUTOSAR
from amaranth.lib.wiring import In, Out

from arcref.position_frame import (
    COMMAND_CLEAR_FLAGS,
    COMMAND_READ_REGISTER,
    COMMAND_WRITE_REGISTER,
    FRAME_BITS,
    FRAME_FIELD,
    FRAME_FIELDS,
)
from arcref_gateware.register_stages import delayed
from arcref_gateware.spi_registers import SpiRegisters

LOWEST_CLOCK_RATIO = 8
"""Word clocks in one SCK period, at the least."""

SENT_BITS = FRAME_BITS - FRAME_FIELD["crc"].width
"""Bits before the CRC: 56."""

SHOWN_CLOCKS = 3
"""Clocks from a chip select or an edge of SCK to the next bit, ready for the CRC."""

COMMAND_BITS = 40
"""Bits of a command that are kept: the command byte, and what goes with it."""


class PositionSpi(wiring.Component):
    """Sends a snapshot of its inputs as chip select falls, and takes commands.

    A command acts when chip select rises after exactly 64 bits whose CRC is right; anything else does nothing.
    Chip select raised at any bit leaves the port ready for the next frame.
    """

    sck: In(1)
    """SPI clock, asynchronous."""
    cs_n: In(1)
    """Chip select, active low, asynchronous."""
    copi: In(1)
    """Data from the controller, asynchronous."""
    cipo: Out(1)
    """Data to the controller: 0 while chip select is high, and after bit 64."""
    angle: In(FRAME_FIELD["angle"].width)
    """Corrected angle, in counts."""
    homed: In(1)
    """1 when homed."""
    flags: In(FRAME_FIELD["flags"].width)
    """The flag byte."""
    turns: In(FRAME_FIELD["turns"].width)
    """Lowest bits of the turn count."""
    chip_select: Out(1)
    """1 while chip select is active, synchronised."""
    registers: Out(SpiRegisters())
    """Register commands, and their answers."""
    clear_flags: Out(FRAME_FIELD["flags"].width)
    """Bit n: clear flag n, for one clock, as a command asks."""

    def elaborate(self, platform):
        m = Module()
        sck, cs_n, copi = Signal(), Signal(init=1), Signal()
        m.submodules.sck_synchroniser = FFSynchronizer(self.sck, sck)
        m.submodules.cs_n_synchroniser = FFSynchronizer(self.cs_n, cs_n, init=1)
        m.submodules.copi_synchroniser = FFSynchronizer(self.copi, copi)
        last_sck, last_cs_n = Signal(), Signal(init=1)
        m.d.sync += [last_sck.eq(sck), last_cs_n.eq(cs_n)]
        selected = ~cs_n
        # A rising edge is acted on a clock late; what it changes is shown only once SCK has fallen again.
        starts, samples, received = Signal(), Signal(), Signal()
        rises = selected & ~last_cs_n & sck & ~last_sck
        m.d.sync += [starts.eq(last_cs_n & selected), samples.eq(rises), received.eq(copi)]
        # What only the far end of a frame depends on is another clock behind.
        late_starts, late_samples, late_received = Signal(), Signal(), Signal()
        m.d.sync += [late_starts.eq(starts), late_samples.eq(samples), late_received.eq(received)]
        # Late enough for the last bit to have gone through the CRC.
        ended = delayed(m, ~last_cs_n & cs_n, 5, name="ended")

        # `following` holds the bit that the next low phase of SCK shows, `showing` the one that a high phase keeps.
        following = Signal(SENT_BITS, reset_less=True)
        showing = Signal(reset_less=True)
        bit = Signal(range(FRAME_BITS + 2), reset_less=True)
        frame_counter = Signal(FRAME_FIELD["frame_counter"].width)
        values = {
            "angle": self.angle,
            "homed": self.homed,
            "flags": self.flags,
            "turns": self.turns,
            "frame_counter": frame_counter,
        }
        position = Cat(*(values[field.name] for field in reversed(FRAME_FIELDS) if field.name in values))
        # The answer to a register command takes the place of one position frame, and its CRC is inverted.
        answer_waits, sends_answer = Signal(), Signal()
        answer = Signal(SENT_BITS - len(frame_counter), reset_less=True)
        snapshot = Mux(answer_waits, Cat(frame_counter, answer), position)
        with m.If(starts):
            m.d.sync += [sends_answer.eq(answer_waits), answer_waits.eq(0)]
        # SCK leaves eight clocks a bit, so where the frame stands may be known a clock late.
        last_before_crc, in_command, in_rest, complete = Signal(), Signal(), Signal(), Signal()
        overlong, counts = Signal(), Signal()
        m.d.comb += self.cipo.eq(selected & Mux(sck, showing, following[-1]))
        m.d.sync += [
            last_before_crc.eq(bit == SENT_BITS - 1),
            in_command.eq(bit < COMMAND_BITS),
            in_rest.eq((bit >= COMMAND_BITS) & (bit < SENT_BITS)),
            complete.eq(bit == FRAME_BITS),
            overlong.eq(bit == FRAME_BITS + 1),
            counts.eq(samples & ~overlong),
            bit.eq(bit + counts),
        ]
        with m.If(late_starts):
            m.d.sync += bit.eq(0)
        with m.If(starts):
            m.d.sync += frame_counter.eq(frame_counter + 1)
        with m.If(~sck):
            m.d.sync += showing.eq(following[-1])

        # Each bit goes into the CRC while it is shown: the CRC is there before the last of them has gone out.
        m.submodules.sent_crc = sent_crc = CRC8_AUTOSAR(data_width=1).create()
        sent_bit = Signal(reset_less=True)
        crc_bits = len(sent_crc.crc)
        tail = Signal(crc_bits)
        crc = sent_crc.crc ^ sends_answer.replicate(crc_bits)
        m.d.sync += [sent_bit.eq(following[-1]), tail.eq(crc & last_before_crc.replicate(crc_bits))]
        m.d.comb += [
            sent_crc.start.eq(starts),
            sent_crc.data.eq(sent_bit),
            sent_crc.valid.eq(delayed(m, starts | samples, SHOWN_CLOCKS, name="shown")),
        ]
        # Followed until a clock after chip select falls, so that the first bit is there at once. Whether it moves is
        # decided a clock ahead. Zeros come in behind the frame, where the CRC is put in with its last bit.
        moves = Signal(init=1)
        m.d.sync += moves.eq(cs_n | rises)
        shifted = Cat(Const(0, 1), following[:-1]) | Cat(Const(0, SENT_BITS - crc_bits), tail)
        tracks = last_cs_n.replicate(SENT_BITS)
        with m.If(moves):
            m.d.sync += following.eq((snapshot & tracks) | (shifted & ~tracks))

        # The command: its first five bytes are kept, the two after them must be zero.
        m.submodules.received_crc = received_crc = CRC8_AUTOSAR(data_width=1).create()
        kept = Signal(COMMAND_BITS, reset_less=True)
        low_word, high_word, command = kept[:16], kept[16:32], kept[32:]
        rest_is_zero = Signal(reset_less=True)
        m.d.comb += [
            received_crc.start.eq(late_starts),
            received_crc.data.eq(late_received),
            received_crc.valid.eq(late_samples),
        ]
        spoils = Signal()
        m.d.sync += [
            spoils.eq(samples & in_rest & received),
            rest_is_zero.eq((rest_is_zero & ~spoils) | late_starts),
        ]
        keeps, kept_bit = Signal(), Signal(reset_less=True)
        m.d.sync += [keeps.eq(late_samples & in_command), kept_bit.eq(late_received)]
        with m.If(keeps):
            m.d.sync += kept.eq(Cat(kept_bit, kept))
        clears, reads, writes, whole, matches = Signal(), Signal(), Signal(), Signal(), Signal()
        no_low_word, no_high_rest = Signal(), Signal()
        obeyed, reads_now, writes_now = Signal(), Signal(), Signal()
        m.d.sync += [
            no_low_word.eq(low_word == 0),
            no_high_rest.eq(high_word[:8] == 0),
            clears.eq((command == COMMAND_CLEAR_FLAGS) & no_low_word & no_high_rest),
            reads.eq((command == COMMAND_READ_REGISTER) & no_low_word),
            writes.eq(command == COMMAND_WRITE_REGISTER),
            matches.eq(received_crc.match_detected),
            whole.eq(complete & rest_is_zero & matches),
            obeyed.eq(ended & whole & clears),
            reads_now.eq(ended & whole & reads),
            writes_now.eq(ended & whole & writes),
        ]
        m.d.sync += self.clear_flags.eq(high_word[8:] & obeyed.replicate(8))

        registers = self.registers
        asking, answered, puts = Signal(), Signal(), Signal()
        asks, answers = Signal(), Signal()
        m.d.comb += [asks.eq((reads_now | writes_now) & ~asking), answers.eq(answered & cs_n & last_cs_n)]
        # Plain data paths: a reset of so few registers would come late.
        m.d.sync += [
            puts.eq(asks),
            registers.valid.eq(puts),
            asking.eq((asking | asks) & ~answers),
            answered.eq((answered | (asking & registers.done)) & ~answers),
        ]
        # Held without a reset: until the first command nobody looks.
        is_write = Signal(reset_less=True)
        address, write_word = (
            Signal.like(signal, reset_less=True) for signal in (registers.address, registers.write_word)
        )
        with m.If(puts):
            m.d.sync += [is_write.eq(writes), address.eq(high_word), write_word.eq(low_word)]
        m.d.comb += [registers.write.eq(is_write), registers.address.eq(address), registers.write_word.eq(write_word)]
        # An answer that comes while a frame is being sent waits for the next one, and one that is ready as chip select
        # falls must not change in the middle.
        takes = Signal()
        m.d.sync += takes.eq(asking & registers.done)
        with m.If(takes):
            word = Mux(registers.write, registers.write_word, registers.read_word)
            code = Mux(registers.write, COMMAND_WRITE_REGISTER, COMMAND_READ_REGISTER)
            m.d.sync += answer.eq(Cat(word, registers.address, registers.status, code))
        with m.If(answers):
            m.d.sync += answer_waits.eq(1)
        m.d.comb += self.chip_select.eq(selected)
        return m
