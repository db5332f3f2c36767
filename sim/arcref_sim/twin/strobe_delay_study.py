"""What an interpolator's delay does to captures, and what the strobe delay does about it, on the true gateware.

The instrument is driven at its pins without a clock on the wall, so the figures are the same each time.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from arcref.angle import ARCSEC_PER_COUNT
from arcref.correction_rom import CorrectionRom
from arcref.link.capture_record import CaptureRecord
from arcref.link.packet import Kind, Packet
from arcref.link.packet_stream import PacketStream
from arcref.link.registers import REGISTERS
from arcref_gateware.connected_encoder import ConnectedEncoder
from arcref_sim.square_waves import SquareWaves
from arcref_sim.twin.live_encoder import LiveEncoder
from arcref_sim.twin.live_motion import LiveMotion
from arcref_sim.twin.twin_core import CompiledTwin, TwinCore

DELAY_NS = 5000.0
"""Delay of the interpolator: 5 us, from its maker's product page."""

SPEEDS_RPS = (-60.0, -10.0, -1.0, 1.0, 10.0, 60.0)
WORDS_PER_RUN = 1 << 13
STROBE_HZ = 100_000.0


@dataclass(frozen=True)
class DelayStudy:
    """Captured angle less the shaft's true angle at the strobe, for one speed and one setting of the strobe delay.

    `error_counts`: one value a capture; a count stands for its middle.
    """

    speed_rps: float
    strobe_delay_samples: int
    error_counts: np.ndarray

    @property
    def mean_arcsec(self) -> float:
        """Mean error."""
        return float(self.error_counts.mean() * ARCSEC_PER_COUNT)


def formula_arcsec(speed_rps):
    """The error that a delay makes: delay times speed."""
    return -np.asarray(speed_rps) * DELAY_NS * 1e-9 * 360 * 3600


def delay_study(rom: CorrectionRom, folder: Path, baud: float = 25e6, captures: int = 60) -> list[DelayStudy]:
    """The study over `SPEEDS_RPS`, each with the strobe delay at 0 and set to match. The encoder is perfect and the
    correction off, so that nothing but the delay is seen.
    """
    compiled = CompiledTwin.of(ConnectedEncoder(rom, baud=baud), folder)
    matching = round(DELAY_NS * 1e-9 * compiled.word_clock_hz * compiled.description["samples_per_word"])
    return [_run(compiled, speed, delay, captures) for delay in (0, matching) for speed in SPEEDS_RPS]


def _run(compiled: CompiledTwin, speed_rps: float, delay: int, captures: int) -> DelayStudy:
    core = TwinCore(compiled)
    samples = core.samples_per_word
    rate_hz = compiled.word_clock_hz * samples
    start = -5000.5 if speed_rps > 0 else 5000.5
    # At 10 r/s until the zero mark was met: slower, that would take long.
    motion = LiveMotion(start, float(np.copysign(10.0, speed_rps)))
    encoder = LiveEncoder(motion, rate_hz, samples, waves=SquareWaves(delay_ns=DELAY_NS))
    stream, records = PacketStream(), []
    settings = {"strobe_delay": delay, "correction_enable": 0, "capture_enable": 1}
    sent = b"\0" + b"".join(_write(number, name, value) for number, (name, value) in enumerate(settings.items()))
    while len(records) < captures:
        if core.output("homed") and not encoder.strobes.rate_hz:
            encoder.set_speed(speed_rps)
            encoder.strobes.set_rate(encoder.sample + WORDS_PER_RUN * samples * 2, STROBE_HZ, is_random=True)
        piece, _ = encoder.next_piece(WORDS_PER_RUN)
        log = core.run(piece.changes, sent)
        sent = sent[log.taken :]
        packets = stream.feed(log.received)
        records += [CaptureRecord.decode(packet.payload) for packet in packets if packet.kind is Kind.CAPTURE]
    records = records[:captures]
    strobe = np.array([record.time for record in records]) - delay
    captured = np.array([record.corrected for record in records])
    return DelayStudy(speed_rps, delay, captured + 0.5 - encoder.true_counts_at(strobe))


def _write(number: int, name: str, value: int) -> bytes:
    register = REGISTERS[name]
    words = b"".join(word.to_bytes(2, "little") for word in register.encode(value))
    return Packet(Kind.WRITE, number, register.address.to_bytes(2, "little") + words).encode()
