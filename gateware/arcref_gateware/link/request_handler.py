"""Obeys the packets that came over the UART: reads and writes registers, and answers."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import MOST_WORDS, Kind, Status
from arcref_gateware.link.packet_memory import PART_BITS, READ_CLOCKS
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request

HEAD_BYTES = 4
"""Bytes before the words of a WRITE, and before the number of words of a READ: kind, number, address."""

assert READ_CLOCKS <= 2, "a tick is too short for a byte"


class RequestHandler(wiring.Component):
    """Takes one packet after the other out of the memory, as `arcref_gateware.golden.link.LinkModel` does.

    It starts when the sender is idle, because its answer goes there, and keeps the bus until it is done.
    """

    ready: In(1)
    """1 while a packet is offered."""
    part: In(1)
    """The part of the memory it stands in."""
    length: In(PART_BITS)
    """Its bytes, without the CRC."""
    taken: Out(1)
    """1 for one clock: the packet is done with."""
    read_address: Out(PART_BITS + 2)
    """Byte of the memory that is wanted."""
    read_data: In(8)
    """The byte, `READ_CLOCKS` clocks later."""
    wants_sender: Out(1)
    """1 from the request's beginning to the end of its answer."""
    has_sender: In(1)
    """1 while the sender is idle and given to the handler; stays so until `wants_sender` falls or `finish`."""
    push_valid: Out(1)
    """1 for one clock with a byte of the answer."""
    push_data: Out(8)
    """The byte."""
    finish: Out(1)
    """1 for one clock: the answer is whole."""
    bus: Out(RegisterBus())
    """The registers."""
    wants_bus: Out(1)
    """1 from the request's beginning to its end."""
    has_bus: In(1)
    """1 while the bus is the handler's; stays so until `wants_bus` falls."""
    obeyed: Out(1)
    """Changes with each request that was answered."""

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        # Everything goes by ticks, one in four clocks: time for a byte to come from the memory, and to be judged.
        beat, tick = Signal(2), Signal()
        m.d.sync += [beat.eq(beat + 1), tick.eq(beat == 2)]
        byte = Signal(PART_BITS)
        at_end, at_byte = Signal(), Signal(HEAD_BYTES + 1)  # where `byte` is
        is_read, is_write = Signal(), Signal()
        says_read, says_write, repeats, count_fits = Signal(), Signal(), Signal(), Signal()  # of the byte that is there
        last_number, last_valid = Signal(8), Signal()
        address, words_left = Signal(len(bus.address)), Signal(range(MOST_WORDS + 1))
        status = Signal(STATUS_BITS)  # of the last WRITE, which may be repeated
        writes = Signal()  # the second time through its words
        first_word, answered = Signal(), Signal()
        length_of_read, length_of_write = Signal(), Signal()
        m.d.comb += [
            self.read_address.eq(Cat(byte, self.part, 0)),
            bus.address.eq(address),
            bus.is_last.eq(at_end),
            bus.following.eq(~first_word),
        ]
        m.d.sync += [
            at_end.eq(byte == self.length),
            at_byte.eq(Cat(byte == k for k in range(HEAD_BYTES + 1))),
            length_of_read.eq(self.length == HEAD_BYTES + 1),
            length_of_write.eq(
                ~self.length[0] & (self.length >= HEAD_BYTES + 2) & (self.length <= HEAD_BYTES + 2 * MOST_WORDS)
            ),
            says_read.eq((self.read_data == Kind.READ) & length_of_read),
            says_write.eq((self.read_data == Kind.WRITE) & length_of_write),
            repeats.eq((self.read_data == last_number) & last_valid),
            count_fits.eq((self.read_data != 0) & (self.read_data <= MOST_WORDS)),
            answered.eq(bus.done | (answered & ~tick)),
            bus.valid.eq(0),
            self.taken.eq(0),
            self.finish.eq(0),
        ]

        # The byte that a tick pushes is chosen a clock before it.
        head = Signal(3)
        from_memory, from_low, from_high, code = Signal(), Signal(), Signal(), Signal(8)
        pushes = Signal()
        m.d.comb += pushes.eq(0)

        with m.FSM() as states:
            with m.State("IDLE"), m.If(tick):
                m.d.sync += [byte.eq(0), first_word.eq(1), writes.eq(0)]
                with m.If(self.ready & self.has_sender & self.has_bus):
                    m.next = "PARSE"
            with m.State("PARSE"), m.If(tick):
                m.d.sync += byte.eq(byte + 1)
                with m.If(at_byte[0]):
                    m.d.sync += [is_read.eq(says_read), is_write.eq(says_write)]
                with m.If(at_byte[1]):
                    with m.If(~is_read & ~is_write):
                        m.next = "DROP"
                    with m.If(is_write):
                        m.d.sync += [last_number.eq(self.read_data), last_valid.eq(1)]
                        with m.If(repeats):
                            m.next = "ANSWER"
                        with m.Else():
                            m.d.sync += status.eq(Status.DONE)
                with m.If(at_byte[2]):
                    m.d.sync += address[:8].eq(self.read_data)
                with m.If(at_byte[3]):
                    m.d.sync += address[8:].eq(self.read_data)
                    with m.If(is_write):
                        m.next = "WORD"
                with m.If(at_byte[4]):
                    m.d.sync += words_left.eq(self.read_data)
                    m.next = "DROP"
                    with m.If(count_fits):
                        m.d.sync += last_valid.eq(0)
                        m.next = "ANSWER"
            with m.State("DROP"), m.If(tick):
                m.d.sync += self.taken.eq(1)
                m.next = "IDLE"

            # A WRITE: all words are checked first, then all are written.
            with m.State("WORD"), m.If(tick):
                m.d.sync += byte.eq(byte + 1)
                with m.If(~byte[0]):
                    m.d.sync += bus.write_word[:8].eq(self.read_data)
                with m.Else():
                    m.d.sync += [
                        bus.write_word[8:].eq(self.read_data),
                        bus.valid.eq(1),
                        bus.request.eq(Mux(writes, Request.WRITE, Request.CHECK)),
                    ]
                    m.next = "ACTING"
            with m.State("ACTING"), m.If(tick & answered):
                m.d.sync += [address.eq(address + 1), first_word.eq(0)]
                m.next = "WORD"
                with m.If(~writes & (bus.status != Status.DONE)):
                    m.d.sync += status.eq(bus.status)
                    m.next = "ANSWER"
                with m.Elif(at_end & writes):
                    m.next = "ANSWER"
                with m.Elif(at_end):
                    m.d.sync += [writes.eq(1), byte.eq(2), first_word.eq(1)]
                    m.next = "PARSE"

            # The answer: kind, number, status, address as the request has them, then the words of a READ.
            with m.State("ANSWER"):
                m.d.comb += pushes.eq(1)
                with m.If(tick):
                    # The bytes 1, 2, 2, 3 follow: status comes before the address.
                    m.d.sync += [head.eq(head + 1), byte.eq(Cat(~(head[0] ^ head[1]), head[0] | head[1]))]
                    with m.If(head == HEAD_BYTES):
                        m.d.sync += head.eq(0)
                        m.next = "FINISH"
                        with m.If(is_read):
                            m.next = "READ"
            with m.State("READ"), m.If(tick):
                m.d.sync += [bus.valid.eq(1), bus.request.eq(Request.READ)]
                m.next = "READING"
            with m.State("READING"):
                m.d.comb += pushes.eq(answered)
                with m.If(tick & answered):
                    m.next = "HIGH_BYTE"
            with m.State("HIGH_BYTE"):
                m.d.comb += pushes.eq(1)
                with m.If(tick):
                    m.d.sync += [address.eq(address + 1), words_left.eq(words_left - 1), first_word.eq(0)]
                    m.next = "READ"
                    with m.If(words_left == 1):
                        m.next = "FINISH"
            with m.State("FINISH"), m.If(tick):
                m.d.sync += [self.finish.eq(1), self.taken.eq(1), self.obeyed.eq(~self.obeyed)]
                m.next = "IDLE"

        in_head = states.ongoing("ANSWER")
        m.d.sync += [
            from_memory.eq(in_head & (head[0] | head[2])),
            from_low.eq(states.ongoing("READING")),
            from_high.eq(states.ongoing("HIGH_BYTE")),
            code.eq(0),
            self.push_valid.eq(tick & pushes),
            self.push_data.eq(
                (self.read_data & from_memory.replicate(8))
                | (bus.read_word[:8] & from_low.replicate(8))
                | (bus.read_word[8:] & from_high.replicate(8))
                | code
            ),
        ]
        with m.If(in_head & (head == 0)):
            m.d.sync += code.eq(Mux(is_read, Kind.READ_ANSWER, Kind.WRITE_ANSWER))
        with m.If(in_head & (head == 2)):
            m.d.sync += code.eq(Mux(is_read, Status.DONE, status))
        wants = Signal()
        m.d.comb += [
            wants.eq(~states.ongoing("IDLE") | (self.ready & ~self.taken)),
            self.wants_sender.eq(wants),
            self.wants_bus.eq(self.has_sender),  # and not before: SPI has it while an answer is being sent
        ]
        return m
