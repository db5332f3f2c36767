"""Obeys the packets that came over the UART: reads and writes registers, and answers."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from arcref.link.packet import MOST_WORDS, Kind, Status
from arcref_gateware.buffer_memory import READ_CLOCKS
from arcref_gateware.link.packet_memory import PART_BITS
from arcref_gateware.link.register_bus import STATUS_BITS, RegisterBus, Request

HEAD_BYTES = 4
"""Bytes before the words of a WRITE, and before the number of words of a READ: kind, number, address."""

assert READ_CLOCKS <= 2, "a tick is too short for a byte"

STATES = ("idle", "parse", "word", "acting", "answer", "read", "reading", "sending", "finish")


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
        # Everything goes by ticks, one in eight clocks. Between two of them a byte comes from the memory and is judged,
        # and what the next tick does becomes known, a clock for each step.
        beat, tick = Signal(3), Signal()
        m.d.sync += [beat.eq(beat + 1), tick.eq(beat == 6)]
        state = {name: Signal(name=f"in_{name}", init=name == "idle") for name in STATES}
        byte = Signal(PART_BITS)
        at_end, at_byte = Signal(), Signal(HEAD_BYTES + 1)
        head, at_head = Signal(3), Signal(HEAD_BYTES + 1)
        is_read, is_write = Signal(), Signal()
        last_number, last_valid = Signal(8), Signal()
        words_left, is_last_word = Signal(range(MOST_WORDS + 1)), Signal()
        status = Signal(STATUS_BITS)  # of the last WRITE, which may be repeated
        writes = Signal()  # the second time through its words
        first_word, answering = Signal(), Signal()

        # What is known of the byte that is there, and of where it stands.
        length_of_read, length_of_write = Signal(), Signal()
        says_read, says_write, same_number, count_fits, refused = Signal(), Signal(), Signal(), Signal(), Signal()
        seen = Signal(8)  # the byte once more, near where it is judged
        m.d.sync += [
            seen.eq(self.read_data),
            at_end.eq(byte == self.length),
            at_byte.eq(Cat(byte == k for k in range(HEAD_BYTES + 1))),
            at_head.eq(Cat(head == k for k in range(HEAD_BYTES + 1))),
            is_last_word.eq(words_left == 1),
            length_of_read.eq(self.length == HEAD_BYTES + 1),
            length_of_write.eq(
                ~self.length[0] & (self.length >= HEAD_BYTES + 2) & (self.length <= HEAD_BYTES + 2 * MOST_WORDS)
            ),
            says_read.eq(seen == Kind.READ),
            says_write.eq(seen == Kind.WRITE),
            same_number.eq(seen == last_number),
            count_fits.eq((seen != 0) & (seen <= MOST_WORDS)),
            refused.eq(~writes & (bus.status != Status.DONE)),
        ]
        # What comes from outside is taken at a tick and counts at the next one.
        came, answered, asked = Signal(), Signal(), Signal()
        m.d.sync += came.eq(bus.done | (came & ~tick))
        with m.If(tick):
            m.d.sync += [answered.eq(came), asked.eq(state["idle"] & self.ready & self.has_sender & self.has_bus)]

        does = {}

        def do(name: str, condition):
            """What the next tick does."""
            does[name] = Signal(name=f"does_{name}")
            m.d.sync += does[name].eq(condition)

        parse, word, acting, answer = (state[name] for name in ("parse", "word", "acting", "answer"))
        do("start", asked)
        do("kind", parse & at_byte[0])
        do("drop", (parse & at_byte[1] & ~is_read & ~is_write) | (parse & at_byte[4] & ~count_fits))
        do("new_write", parse & at_byte[1] & is_write & ~(same_number & last_valid))
        do("repeated", parse & at_byte[1] & is_write & same_number & last_valid)
        do("low_address", parse & at_byte[2])
        do("high_address", parse & at_byte[3])
        do("first_word", parse & at_byte[3] & is_write)
        do("count", parse & at_byte[4] & count_fits)
        do("low_byte", word & ~byte[0])
        do("high_byte", word & byte[0])
        do("refuse", acting & answered & refused)
        do("next_word", acting & answered & ~refused & ~at_end)
        do("second_time", acting & answered & ~refused & at_end & ~writes)
        do("written", acting & answered & at_end & writes)
        do("next_head", answer)
        do("end_head", answer & at_head[HEAD_BYTES])
        do("read", state["read"])
        do("word_read", state["reading"] & answered)
        do("word_sent", state["sending"])
        do("last_sent", state["sending"] & is_last_word)
        do("finish", state["finish"])

        moves = (
            ("start", "idle", "parse"),
            ("drop", "parse", "finish"),
            ("repeated", "parse", "answer"),
            ("first_word", "parse", "word"),
            ("count", "parse", "answer"),
            ("high_byte", "word", "acting"),
            ("refuse", "acting", "answer"),
            ("next_word", "acting", "word"),
            ("second_time", "acting", "parse"),
            ("written", "acting", "answer"),
            ("end_head", "answer", "read"),
            ("read", "read", "reading"),
            ("word_read", "reading", "sending"),
            ("word_sent", "sending", "read"),
            ("finish", "finish", "idle"),
        )
        # After the head of a WRITE's answer, and after a READ's last word, there is nothing more to read.
        no_more = does["last_sent"] | (does["end_head"] & ~is_read)
        for name, here in state.items():
            enters, leaves = Signal(name=f"enters_{name}"), Signal(name=f"leaves_{name}")
            into = [does[move] for move, _, to in moves if to == name]
            if name == "read":
                into = [does["end_head"] & ~no_more, does["word_sent"] & ~no_more]
            if name == "finish":
                into = [does["drop"], no_more]
            m.d.sync += [
                enters.eq(Cat(into).any()),
                leaves.eq(Cat(does[move] for move, origin, _ in moves if origin == name).any()),
                here.eq((here & ~(tick & leaves)) | (tick & enters)),
            ]

        def now(name: str):
            return m.If(tick & does[name])

        m.d.comb += [
            self.read_address.eq(Cat(byte, self.part, 0)),
            bus.is_last.eq(at_end),
            bus.following.eq(~first_word),
        ]
        # The byte: on and on through the request, again from its address on, and as the answer's head needs it.
        steps_on, moves_byte, next_byte = Signal(), Signal(), Signal(PART_BITS)
        # 1, 2, 2, 3: the status comes before the address.
        head_byte = Cat(at_head[0] | at_head[3], ~at_head[0]) & does["next_head"].replicate(2)
        m.d.sync += [
            steps_on.eq(parse | word),
            moves_byte.eq(parse | word | asked | does["second_time"] | does["next_head"]),
            next_byte.eq(((byte + 1) & steps_on.replicate(PART_BITS)) | Cat(0, does["second_time"]) | head_byte),
        ]
        with m.If(tick & moves_byte):
            m.d.sync += byte.eq(next_byte)
        with now("next_head"):
            m.d.sync += head.eq(head + 1)
        with now("end_head"):
            m.d.sync += head.eq(0)

        with now("kind"):
            m.d.sync += [is_read.eq(says_read & length_of_read), is_write.eq(says_write & length_of_write)]
        with now("new_write"):
            m.d.sync += [last_number.eq(self.read_data), status.eq(Status.DONE)]
        with now("refuse"):
            m.d.sync += status.eq(bus.status)
        with now("count"):
            m.d.sync += words_left.eq(self.read_data)
        with now("word_sent"):
            m.d.sync += words_left.eq(words_left - 1)
        counts_address, starts_words = Signal(), Signal()
        m.d.sync += [
            counts_address.eq(does["word_sent"] | does["next_word"]),
            starts_words.eq(state["idle"] | does["second_time"]),
        ]
        m.d.sync += [
            last_valid.eq((last_valid | (tick & does["new_write"])) & ~(tick & does["count"])),
            writes.eq((writes & ~state["idle"]) | (tick & does["second_time"])),
            first_word.eq((first_word & ~(tick & counts_address)) | (tick & starts_words)),
        ]

        # The address counts in two halves, a clock apart.
        low, high, carry = Signal(8), Signal(8), Signal()
        m.d.comb += bus.address.eq(Cat(low, high))
        m.d.sync += carry.eq(tick & counts_address & low.all())
        with m.If(tick & counts_address):
            m.d.sync += low.eq(low + 1)
        with m.If(carry):
            m.d.sync += high.eq(high + 1)
        with now("low_address"):
            m.d.sync += low.eq(self.read_data)
        with now("high_address"):
            m.d.sync += high.eq(self.read_data)

        with now("low_byte"):
            m.d.sync += bus.write_word[:8].eq(self.read_data)
        with now("high_byte"):
            m.d.sync += bus.write_word[8:].eq(self.read_data)
        with m.If(tick):
            m.d.sync += bus.request.eq(Mux(state["read"], Request.READ, Mux(writes, Request.WRITE, Request.CHECK)))
        ends = does["finish"] & tick
        m.d.sync += [
            bus.valid.eq(tick & (does["high_byte"] | does["read"])),
            self.taken.eq(ends),
            self.finish.eq(ends & answering),
            self.obeyed.eq(self.obeyed ^ (ends & answering)),
        ]

        # The answer: kind, number, status, address as the request has them, then the words of a READ.
        from_memory, from_low, from_high, code = Signal(), Signal(), Signal(), Signal(8)
        pushes = Signal()
        kind = Mux(is_read, Kind.READ_ANSWER, Kind.WRITE_ANSWER)
        shown_status = status & (~is_read).replicate(STATUS_BITS)
        m.d.sync += [
            from_memory.eq(answer & (at_head[1] | at_head[3] | at_head[4])),
            from_low.eq(state["reading"]),
            from_high.eq(state["sending"]),
            code.eq((kind & (answer & at_head[0]).replicate(8)) | (shown_status & (answer & at_head[2]).replicate(8))),
            pushes.eq(does["next_head"] | does["word_read"] | does["word_sent"]),
            self.push_valid.eq(tick & pushes),
            self.push_data.eq(
                (self.read_data & from_memory.replicate(8))
                | (bus.read_word[:8] & from_low.replicate(8))
                | (bus.read_word[8:] & from_high.replicate(8))
                | code
            ),
            answering.eq((answering & ~state["idle"]) | answer),
        ]
        wants = Signal()
        m.d.comb += [
            wants.eq(~state["idle"] | (self.ready & ~self.taken)),
            self.wants_sender.eq(wants),
            self.wants_bus.eq(self.has_sender),  # and not before: SPI has it while an answer is being sent
        ]
        return m
