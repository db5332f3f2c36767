"""Packets on the wire, and the stream they are cut from, under abuse."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from arcref.link.capture_record import RECORD_BYTES, CaptureRecord
from arcref.link.packet import BrokenPacket, Kind, Packet, crc16
from arcref.link.packet_stream import LONGEST_WIRE_BYTES, PacketStream

PACKETS = st.one_of(
    st.builds(Packet, st.just(Kind.READ), st.integers(0, 255), st.binary(min_size=3, max_size=3)),
    st.builds(
        Packet,
        st.just(Kind.WRITE),
        st.integers(0, 255),
        st.integers(1, 24).flatmap(lambda n: st.binary(min_size=2 + 2 * n, max_size=2 + 2 * n)),
    ),
    st.builds(Packet, st.just(Kind.CAPTURE), st.integers(0, 255), st.binary(min_size=15, max_size=15)),
    st.builds(Packet, st.just(Kind.OVERRUN), st.integers(0, 255), st.binary(min_size=4, max_size=4)),
)


def test_the_crc_has_the_catalogue_s_check_value():
    assert crc16(b"123456789") == 0x29B1  # CRC-16/IBM-3740


@given(PACKETS)
def test_a_packet_comes_back_and_holds_no_zero_but_its_end(packet):
    wire = packet.encode()
    assert wire.index(0) == len(wire) - 1
    assert len(wire) <= LONGEST_WIRE_BYTES
    assert Packet.decode(wire[:-1]) == packet


@given(st.lists(PACKETS, max_size=20), st.randoms(use_true_random=False))
def test_a_stream_gives_every_packet_however_its_bytes_are_bunched(packets, rng):
    data = b"\0" + b"".join(packet.encode() for packet in packets)
    stream, found = PacketStream(), []
    while data:
        cut = rng.randint(1, len(data))
        found += stream.feed(data[:cut])
        data = data[cut:]
    assert found == packets
    assert stream.broken == 0


@pytest.mark.parametrize("abuse", ["lost byte", "broken byte", "doubled byte", "zero in the middle", "noise between"])
def test_abuse_costs_the_packet_it_hits_and_no_other(abuse):
    rng = random.Random(abuse)
    for _ in range(200):
        packets = [Packet(Kind.CAPTURE, n, rng.randbytes(RECORD_BYTES)) for n in range(5)]
        wires = [packet.encode() for packet in packets]
        hit = bytearray(wires[2])
        place = rng.randrange(len(hit) - 1)
        if abuse == "lost byte":
            del hit[place]
        elif abuse == "broken byte":
            hit[place] ^= 1 << rng.randrange(8)
        elif abuse == "doubled byte":
            hit.insert(place, hit[place])
        elif abuse == "zero in the middle":
            hit.insert(place, 0)
        else:
            hit = bytearray(bytes(rng.randrange(1, 256) for _ in range(rng.randrange(400))) + b"\0" + hit)
        stream = PacketStream()
        found = list(stream.feed(b"\0" + b"".join([*wires[:2], bytes(hit), *wires[3:]])))
        expected = packets if abuse == "noise between" else packets[:2] + packets[3:]
        # A zero put in front of a packet ends an empty one, and costs nothing.
        assert found in (expected, packets if abuse == "zero in the middle" and place == 0 else expected)


def test_a_million_random_bytes_make_no_packet_and_the_next_one_is_taken():
    rng = random.Random(1)
    stream = PacketStream()
    found = [packet for _ in range(250) for packet in stream.feed(rng.randbytes(4000))]
    assert found == []
    assert stream.broken > 1000
    packet = Packet(Kind.READ, 7, b"\x10\0\x0b")
    assert list(stream.feed(b"\0" + packet.encode())) == [packet]


def test_bytes_before_the_first_delimiter_are_no_fault():
    stream = PacketStream()
    assert list(stream.feed(b"\x11\x22\x33\0")) == []
    assert stream.broken == 0


@pytest.mark.parametrize("body", [b"", b"\x01", b"\x01\x02\x03\x04\x05"])
def test_what_is_no_packet_is_refused(body):
    with pytest.raises(BrokenPacket):
        Packet.decode(body)


@pytest.mark.parametrize(("kind", "length"), [(Kind.READ, 2), (Kind.WRITE, 5), (Kind.CAPTURE, 14), (Kind.WRITE, 52)])
def test_a_packet_of_the_wrong_length_is_refused(kind, length):
    with pytest.raises(BrokenPacket, match=f"{length} bytes in a packet of kind {kind.name}"):
        Packet.decode(Packet(kind, 0, bytes(length)).encode()[:-1])


@given(st.integers(0, 2**48 - 1), st.integers(-(2**47), 2**47 - 1), st.integers(-4096, 4096), st.integers(0, 255))
def test_a_capture_record_comes_back(time, raw, correction, flags):
    record = CaptureRecord(time, raw, raw + correction, flags)
    assert len(record.encode()) == RECORD_BYTES
    assert CaptureRecord.decode(record.encode()) == record
