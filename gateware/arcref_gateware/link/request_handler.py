"""Obeys the packets that came over the UART: reads and writes registers, and answers."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import MOST_WORDS, Kind, Status
from arcref_gateware.link.packet_memory import PART_BITS
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request

HEAD_BYTES = 4
"""Bytes before the words of a WRITE, and before the number of words of a READ: kind, number, address."""


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
    """The byte, two clocks later."""
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
    obeyed: Out(16)
    """Requests that were answered, modulo 65536."""

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        byte = Signal(PART_BITS)
        wait = Signal(2)
        last_byte = Signal()  # the byte at `byte` is there
        number, kind = Signal(8), Signal(8)
        last_number, last_valid, last_status = Signal(8), Signal(), Signal(STATUS_BITS)
        address = Signal(len(bus.address))
        words, words_left = Signal(5), Signal(5)
        status = Signal(STATUS_BITS)
        writes = Signal()
        head = Signal(3)
        read_word = Signal(16)
        first_word = Signal()
        m.d.comb += [
            self.read_address.eq(Cat(byte, self.part, 0)),
            bus.address.eq(address),
            bus.words_left.eq(words_left),
            bus.following.eq(~first_word),
        ]
        m.d.sync += [
            last_byte.eq(wait == 2),
            self.push_valid.eq(0),
            self.finish.eq(0),
            self.taken.eq(0),
            bus.valid.eq(0),
        ]

        def fetched():
            """Waits for the byte at `byte`; what stands inside acts when it is there."""
            with m.If(~last_byte):
                m.d.sync += wait.eq(wait + 1)
            return m.If(last_byte)

        def next_byte():
            m.d.sync += [byte.eq(byte + 1), wait.eq(0), last_byte.eq(0)]

        def push(data):
            m.d.sync += [self.push_valid.eq(1), self.push_data.eq(data)]

        is_read, is_write, repeated, number_fits = Signal(), Signal(), Signal(), Signal()
        m.d.sync += [
            is_read.eq((kind == Kind.READ) & (self.length == HEAD_BYTES + 1)),
            is_write.eq(
                (kind == Kind.WRITE)
                & ~self.length[0]
                & (self.length >= HEAD_BYTES + 2)
                & (self.length <= HEAD_BYTES + 2 * MOST_WORDS)
            ),
            number_fits.eq((words != 0) & (words <= MOST_WORDS)),
            repeated.eq(last_valid & (last_number == number)),
        ]

        with m.FSM() as states:
            with m.State("IDLE"):
                m.d.sync += [byte.eq(0), wait.eq(0), last_byte.eq(0), first_word.eq(1), status.eq(Status.DONE)]
                with m.If(self.ready & ~self.taken & self.has_sender & self.has_bus):
                    m.next = "KIND"
            for state, target, following in (
                ("KIND", kind, "NUMBER"),
                ("NUMBER", number, "ADDRESS_LOW"),
                ("ADDRESS_LOW", address[:8], "ADDRESS_HIGH"),
                ("ADDRESS_HIGH", address[8:], "COUNT"),
            ):
                with m.State(state), fetched():
                    m.d.sync += target.eq(self.read_data)
                    next_byte()
                    m.next = following
            with m.State("COUNT"), fetched():
                m.d.sync += words.eq(Mux(is_read & (self.read_data < 32), self.read_data[:5], 0))
                with m.If(is_write):
                    m.d.sync += words.eq((self.length - HEAD_BYTES) >> 1)
                m.d.sync += wait.eq(0)
                m.next = "JUDGE"
            with m.State("JUDGE"):
                m.d.sync += [wait.eq(wait + 1), words_left.eq(words), head.eq(0), byte.eq(HEAD_BYTES)]
                with m.If(wait == 1):
                    m.d.sync += [wait.eq(0), last_byte.eq(0)]
                    with m.If(~(is_read | is_write) | ~number_fits):
                        m.d.sync += self.taken.eq(1)
                        m.next = "IDLE"
                    with m.Elif(is_read):
                        m.d.sync += last_valid.eq(0)
                        m.next = "HEAD"
                    with m.Elif(repeated):
                        m.d.sync += status.eq(last_status)
                        m.next = "HEAD"
                    with m.Else():
                        m.d.sync += writes.eq(0)
                        m.next = "WORD_LOW"

            # A WRITE: all words are checked first, then all are written.
            with m.State("WORD_LOW"), fetched():
                m.d.sync += bus.write_word[:8].eq(self.read_data)
                next_byte()
                m.next = "WORD_HIGH"
            with m.State("WORD_HIGH"), fetched():
                m.d.sync += [
                    bus.write_word[8:].eq(self.read_data),
                    bus.valid.eq(1),
                    bus.request.eq(Mux(writes, Request.WRITE, Request.CHECK)),
                ]
                next_byte()
                m.next = "WORD"
            with m.State("WORD"), m.If(bus.done):
                m.d.sync += [address.eq(address + 1), words_left.eq(words_left - 1), first_word.eq(0)]
                m.next = "WORD_LOW"
                with m.If(~writes & (bus.status != Status.DONE)):
                    m.d.sync += status.eq(bus.status)
                    m.next = "REMEMBER"
                with m.Elif(words_left == 1):
                    m.next = "PASS"
            with m.State("PASS"):
                m.d.sync += [byte.eq(HEAD_BYTES), wait.eq(0), last_byte.eq(0), first_word.eq(1), words_left.eq(words)]
                with m.If(writes):
                    m.next = "REMEMBER"
                with m.Else():
                    m.d.sync += [writes.eq(1), address.eq(address - words)]
                    m.next = "WORD_LOW"
            with m.State("REMEMBER"):
                m.d.sync += [last_number.eq(number), last_valid.eq(1), last_status.eq(status)]
                m.next = "HEAD"

            # The answer: kind, number, status, address as the request has it, then the words of a READ.
            with m.State("HEAD"):
                m.d.sync += byte.eq(Mux(head == HEAD_BYTES, 3, 2))  # the address is taken from the request's own bytes
                with m.If(wait != 3):
                    m.d.sync += wait.eq(wait + 1)
                with m.Else():
                    m.d.sync += [wait.eq(0), head.eq(head + 1)]
                    with m.Switch(head):
                        with m.Case(0):
                            push(Mux(is_read, Kind.READ_ANSWER, Kind.WRITE_ANSWER))
                        with m.Case(1):
                            push(number)
                        with m.Case(2):
                            push(status)
                        with m.Default():
                            push(self.read_data)
                    with m.If(head == HEAD_BYTES):
                        m.d.sync += first_word.eq(1)
                        m.next = "READ"
                        with m.If(~is_read):
                            m.next = "FINISH"
            with m.State("READ"):
                m.d.sync += [bus.valid.eq(1), bus.request.eq(Request.READ)]
                m.next = "READING"
            with m.State("READING"), m.If(bus.done):
                m.d.sync += [
                    address.eq(address + 1),
                    words_left.eq(words_left - 1),
                    first_word.eq(0),
                    read_word.eq(bus.read_word),
                    wait.eq(0),
                ]
                push(bus.read_word[:8])
                m.next = "PUSH_HIGH"
            with m.State("PUSH_HIGH"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(wait == 3):
                    push(read_word[8:])
                    m.next = "READ"
                    with m.If(words_left == 0):
                        m.next = "FINISH"
            with m.State("FINISH"):
                m.d.sync += wait.eq(wait + 1)
                with m.If(wait == 3):
                    m.d.sync += [self.finish.eq(1), self.taken.eq(1), self.obeyed.eq(self.obeyed + 1)]
                    m.next = "IDLE"
        wants = Signal()
        m.d.comb += [
            wants.eq(~states.ongoing("IDLE") | (self.ready & ~self.taken)),
            self.wants_sender.eq(wants),
            self.wants_bus.eq(wants & self.has_sender),  # SPI has it while an answer is being sent
        ]
        return m
