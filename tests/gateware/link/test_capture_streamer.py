"""The streamer behind the FIFO: its packets, byte by byte, hold every capture and every loss in their order."""

import random

import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import connect
from amaranth.sim import Simulator

from arcref.link.capture_record import RECORD_BYTES, CaptureRecord
from arcref.link.packet import Kind
from arcref_gateware.link.capture_fifo import CaptureFifo
from arcref_gateware.link.capture_streamer import PUSH_CLOCKS, CaptureStreamer

DEPTH = 16


class Stream(wiring.Component):
    """FIFO and streamer."""

    def __init__(self):
        super().__init__({})
        self.fifo, self.streamer = CaptureFifo(DEPTH), CaptureStreamer()

    def elaborate(self, platform):
        m = Module()
        m.submodules += [self.fifo, self.streamer]
        connect(m, self.streamer.oldest, self.fifo.oldest)
        return m


def packets_of(offers, enabled, rng, clears=()):
    """The packets that come of a capture in each clock of `offers`, given the sender at random times."""
    dut = Stream()
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    packets = []

    async def bench(ctx):
        fifo, streamer = dut.fifo, dut.streamer
        packet, last_push, has_sender = bytearray(), -100, False
        for clock, offer in enumerate(offers):
            ctx.set(fifo.valid, offer)
            ctx.set(fifo.clear, clock in clears)
            for name in ("time", "raw", "corrected"):
                ctx.set(getattr(fifo, name), clock * (1 if name == "time" else -3))
            ctx.set(fifo.flags, clock & 0xFF)
            ctx.set(streamer.enable, enabled(clock))
            ctx.set(streamer.has_sender, has_sender)
            _, _, push, data, finish, wants = await ctx.tick().sample(
                streamer.push_valid, streamer.push_data, streamer.finish, streamer.wants_sender
            )
            if push:
                assert has_sender
                assert clock - last_push >= PUSH_CLOCKS
                packet.append(data)
                last_push = clock
            if finish:
                assert clock - last_push >= 3
                packets.append(bytes(packet))
                packet.clear()
                has_sender = False
            elif not wants:
                assert not packet
                has_sender = False
            elif not has_sender:
                has_sender = rng.random() < 0.05

    simulator.add_testbench(bench)
    simulator.run()
    return packets


def unpack(packets):
    """(Total of lost captures or None, time) of each capture; checks the packets."""
    records, lost = [], None
    for number, packet in enumerate(packets):
        assert packet[1] == number & 0xFF
        if packet[0] == Kind.OVERRUN:
            assert len(packet) == 6
            assert lost is None
            lost = int.from_bytes(packet[2:], "little")
            continue
        assert packet[0] == Kind.CAPTURE
        assert len(packet) == 2 + RECORD_BYTES
        record = CaptureRecord.decode(packet[2:])
        assert (record.raw, record.corrected, record.flags) == (-3 * record.time, -3 * record.time, record.time & 0xFF)
        records.append((lost, record.time))
        lost = None
    assert lost is None
    return records


@pytest.mark.parametrize("seed", range(6))
def test_every_capture_is_sent_or_told_as_lost(seed):
    rng = random.Random(seed)
    offers = [False] * 2  # the FIFO is cleared just after reset
    while len(offers) < 12_000:
        rate = rng.choice([0.0, 0.003, 0.02, 1.0])
        offers += [rng.random() < rate for _ in range(rng.randrange(1, 800 if rate < 1 else 40))]
    offers += [False] * 5000 + [True] + [False] * 500
    off = [rng.randrange(len(offers) - 6000) for _ in range(5)]
    records = unpack(packets_of(offers, lambda clock: not any(start <= clock < start + 300 for start in off), rng))
    offered = [clock for clock, offer in enumerate(offers) if offer]
    places = {clock: place for place, clock in enumerate(offered)}
    sent = [places[time] for _, time in records]
    lost_so_far, expected = 0, []
    for k, place in enumerate(sent):
        gap = place - (sent[k - 1] + 1 if k else 0)
        lost_so_far += gap
        expected.append(lost_so_far if gap else None)
    assert [lost for lost, _ in records] == expected
    assert sent[-1] == len(offered) - 1
    assert len(sent) > 50
    assert lost_so_far > 0


@pytest.mark.parametrize("seed", range(6))
def test_a_clear_in_the_middle_spoils_no_packet(seed):
    rng = random.Random(seed)
    offers = [False, *(rng.random() < 0.02 for _ in range(6000))]
    for start in (500, 2500, 4500):
        offers[start : start + 40] = [True] * 40
    clears = {start + rng.randrange(30, 700) for start in (500, 1500, 2500, 3500, 4500)}
    records = []
    for packet in packets_of(offers, lambda clock: True, rng, clears):
        if packet[0] == Kind.CAPTURE:
            record = CaptureRecord.decode(packet[2:])
            assert (record.raw, record.flags) == (-3 * record.time, record.time & 0xFF)
            assert offers[record.time]
            records.append(record.time)
    assert len(records) > 20
    assert records == sorted(set(records))
