"""The UART's door to the registers against the golden model, over its two lines."""

import random

import pytest
from uart_bench import CONSTANT_VALUES, exchange

from arcref.link.packet import MOST_WORDS, Kind, Packet, Status
from arcref.link.packet_stream import PacketStream
from arcref.link.register import UNKNOWN_WORD, Access
from arcref.link.registers import REGISTERS
from arcref_gateware.golden.link import LinkModel
from arcref_gateware.link.register_layout import is_recorded, live_registers

READABLE = [r for r in REGISTERS.registers if r.access is not Access.COMMAND and not is_recorded(r)]
# The link's own counters move with the requests, and reading the number of a snapshot takes one.
STILL = [r for r in READABLE if r.name not in ("packets_refused", "link_state", "snapshot_number")]

INSTANT = {
    "raw_position": -123_456_789_012,
    "position": -123_456_789_019,
    "time": 0x0123_4567_89AB,
    "flags": 0b0000_0010,
    "homed": 1,
}


def live_values(seed=0):
    """What every register reads that cannot be written; counted ones stand at 0."""
    rng = random.Random(seed)
    counted = {r.name: 0 for r in READABLE if r.access is Access.READ}
    return counted | CONSTANT_VALUES | {r.name: rng.getrandbits(r.width) for r in live_registers()}


def read(number, address, count):
    return Packet(Kind.READ, number, address.to_bytes(2, "little") + bytes([count])).encode()


def write(number, address, words):
    return Packet(Kind.WRITE, number, b"".join(w.to_bytes(2, "little") for w in [address, *words])).encode()


def packets(data):
    stream = PacketStream()
    return list(stream.feed(b"\0" + data))


def words_of(answer):
    return [int.from_bytes(answer.payload[i : i + 2], "little") for i in range(3, len(answer.payload), 2)]


def model_of(live, acted, **loading):
    model = LinkModel(
        lambda register: live[register.name],
        lambda name, value: acted.append((name, value)),
        lambda name, place, word: acted.append((f"{name}[{place}]", word)),
    )
    model.loading = loading.get("loading", False)
    return model


def test_every_register_reads_what_the_declaration_says():
    live = live_values()
    blocks: dict[int, list] = {}
    for register in STILL:
        blocks.setdefault(register.address >> 4, []).append(register)
    requests = [
        read(n, block[0].address, block[-1].addresses[-1] + 1 - block[0].address) for n, block in blocks.items()
    ]
    answers, acted = exchange(requests, live, INSTANT)
    for block, answer in zip(blocks.values(), answers, strict=True):
        words = words_of(packets(answer)[0])
        for register in block:
            value = live[register.name] if register.access is Access.READ else register.reset
            expected = register.decode([value >> 16 * i & 0xFFFF for i in range(register.words)])
            got = register.decode(words[register.address - block[0].address :][: register.words])
            assert got == expected, register.name
    assert acted == []


def test_random_requests_are_answered_as_the_model_answers_them():
    rng = random.Random(5)
    live = live_values(1)
    settings = [r for r in REGISTERS.registers if r.access is not Access.READ]
    wires = []
    for _ in range(40):
        number = rng.choice([7, 8, 9])  # few numbers, so that some are repeated
        if rng.random() < 0.35:
            register = rng.choice(STILL)
            count = rng.choice([0, 1, register.words, 3, MOST_WORDS, MOST_WORDS + 1, 255])
            first = rng.choice([register.address, 0x0FFF, 0x00D0, 0x0120])
            if any(place in range(0x10, 0x70) for place in range(first, first + count)):
                first = 0x0080
            wires.append(read(number, first, count))
        else:
            register = rng.choice(settings)
            words = [rng.choice([0, 1, 2, rng.getrandbits(16)]) for _ in range(rng.choice([1, register.words, 2, 3]))]
            address = rng.choice([register.address] * 6 + [0x0001, 0x00FE, 0x0200, 0x1000])
            wires.append(write(number, address, words))
    expected_acts = []
    model = model_of(live, expected_acts)
    expected = [model.feed(b"\0" + wire) for wire in wires]
    answers, acted = exchange(wires, live, INSTANT)
    for n, (answer, right) in enumerate(zip(answers, expected, strict=True)):
        assert answer == right, f"request {n}: {wires[n].hex()}"
    # The bench sees a setting change; one written with the value it has cannot be told from none.
    values = {r.name: r.reset for r in REGISTERS.registers}
    changes = []
    for name, value in expected_acts:
        if REGISTERS[name].access is Access.COMMAND:
            if value:
                changes.append((name, value))
        elif values[name] != value:
            values[name] = value
            changes.append((name, value))
    assert acted == changes


def test_windows_are_written_while_loading_and_at_no_other_time():
    wires = [write(1, 0x1000, [1, 2, 3]), write(2, 0x0400 + 511, [9]), write(3, 0x0200, list(range(MOST_WORDS)))]
    answers, acted = exchange(wires, live_values(), INSTANT)
    assert [packets(answer)[0].payload[0] for answer in answers] == [Status.NOT_NOW] * 3
    assert acted == []
    answers, acted = exchange(wires, live_values(), INSTANT, loading=True)
    assert [packets(answer)[0].payload[0] for answer in answers] == [Status.DONE] * 3
    expected = [("line_table[0]", 1), ("line_table[1]", 2), ("line_table[2]", 3), ("subdivision_table[511]", 9)]
    assert acted == expected + [(f"identity[{i}]", i) for i in range(MOST_WORDS)]


def test_a_snapshot_is_of_one_instant_and_numbered():
    first, count = REGISTERS["snapshot_number"].address, 11
    answers, _ = exchange([read(1, first, count), read(2, first, count)], live_values(), INSTANT)
    for number, answer in enumerate(answers, 1):
        words = words_of(packets(answer)[0])

        def value(name, words=words):
            register = REGISTERS[name]
            return register.decode(words[register.address - first :][: register.words])

        assert value("snapshot_number") == number
        assert value("snapshot_raw") == INSTANT["raw_position"]
        assert value("snapshot_position") == INSTANT["position"]
        assert value("snapshot_time") == INSTANT["time"]
        assert value("snapshot_flags") == 0x100 | INSTANT["flags"]


def test_unknown_addresses_read_the_known_constant():
    answers, _ = exchange([read(1, 0x0100, 4), read(2, 0xFFFF, 1)], live_values(), INSTANT)
    assert words_of(packets(answers[0])[0]) == [UNKNOWN_WORD] * 4
    assert words_of(packets(answers[1])[0]) == [UNKNOWN_WORD]


@pytest.mark.parametrize("seed", range(3))
def test_abuse_changes_nothing_and_the_next_request_is_answered(seed):
    rng = random.Random(seed)
    good = write(1, REGISTERS["strobe_delay"].address, [4000])
    abuse = []
    for _ in range(15):
        wire = bytearray(write(rng.randrange(256), REGISTERS["strobe_delay"].address, [rng.getrandbits(16)]))
        what = rng.randrange(4)
        if what == 0:
            del wire[rng.randrange(len(wire) - 1)]
        elif what == 1:
            wire[rng.randrange(len(wire) - 1)] ^= 1 << rng.randrange(8)
        elif what == 2:
            wire = bytearray(rng.randbytes(rng.randrange(1, 120)))
        else:
            wire = wire[: rng.randrange(1, len(wire) - 1)] + b"\0"
        abuse.append(bytes(wire))
    answers, acted = exchange([b"".join(abuse), b"\0" + good], live_values(), INSTANT)
    assert packets(answers[0]) == []
    assert [p.payload[0] for p in packets(answers[1])] == [Status.DONE]
    assert acted == [("strobe_delay", 4000)]
