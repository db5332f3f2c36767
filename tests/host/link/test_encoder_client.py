"""The client against an instrument on a pseudo-terminal."""

import threading
import time

import numpy as np
import pytest
from pseudo_instrument import PseudoInstrument

from arcref import Encoder, Flag, InputError, InstrumentError
from arcref.angle import COUNTS_PER_TURN
from arcref.link import link
from arcref.link.capture_record import CaptureRecord
from arcref.link.link import LinkLost
from arcref_sim.twin.noisy_wire import noisy_wire

POSITION = 3 * COUNTS_PER_TURN + 1_000_000
SNAPSHOT = {
    "snapshot_position": POSITION,
    "snapshot_raw": POSITION + 7,
    "snapshot_time": 800_000_000 * 5,
    "snapshot_flags": 0x100 | int(Flag.CORRECTION_ACTIVE | Flag.ILLEGAL_STEP),
    "flags": int(Flag.CORRECTION_ACTIVE | Flag.ILLEGAL_STEP),
}


def records(number):
    return [CaptureRecord(1000 * n, POSITION + n, POSITION + n - 7, 2) for n in range(number)]


@pytest.fixture
def instrument():
    with PseudoInstrument(SNAPSHOT) as instrument:
        yield instrument


@pytest.fixture
def encoder(instrument):
    with Encoder(instrument.port) as encoder:
        yield encoder


def test_a_snapshot_tells_position_time_and_flags_of_one_instant(encoder):
    snapshot = encoder.snapshot()
    assert (snapshot.position, snapshot.raw_position, snapshot.turns) == (POSITION, POSITION + 7, 3)
    assert snapshot.time_s == 5.0
    assert snapshot.homed
    assert snapshot.flags == Flag.CORRECTION_ACTIVE | Flag.ILLEGAL_STEP
    assert encoder.angle_deg == pytest.approx(1_000_000 / COUNTS_PER_TURN * 360)


def test_negative_positions_keep_their_sign(instrument, encoder):
    instrument.values |= {"snapshot_position": -5, "snapshot_raw": -(2**47)}
    snapshot = encoder.snapshot()
    assert (snapshot.position, snapshot.raw_position, snapshot.turns) == (-5, -(2**47), -1)


def test_settings_are_written_and_read_back_as_attributes(instrument, encoder):
    encoder.registers.strobe_delay = 4000
    encoder.registers.strobe_period = 123_456_789
    assert encoder.registers.strobe_delay == 4000
    assert encoder.registers.strobe_period == 123_456_789
    assert instrument.written == [("strobe_delay", 4000), ("strobe_period", 123_456_789)]


@pytest.mark.parametrize(
    ("name", "value", "sentence"),
    [
        ("strobe_dealy", 1, "there is no register 'strobe_dealy'; did you mean strobe_delay?"),
        ("strobe_delay", 65536, "strobe_delay is 65536, it must lie in 0 .. 65535"),
        ("strobe_delay", -1, "strobe_delay is -1, it must lie in 0 .. 65535"),
        ("strobe_delay", 1.5, "strobe_delay is 1.5, a whole number was expected"),
        ("closure_error", 0, "the register closure_error can only be read"),
    ],
)
def test_what_cannot_be_written_is_refused_in_a_sentence(instrument, encoder, name, value, sentence):
    with pytest.raises(InputError) as error:
        encoder.registers.write(name, value)
    assert str(error.value) == sentence
    assert instrument.written == []


def test_captures_come_as_an_array_with_units(instrument, encoder):
    sent = records(500)
    instrument.on_write = lambda name, value: name == "capture_enable" and value and send_later(instrument, sent)
    captures = encoder.capture(500)
    assert captures["position_counts"].tolist() == [record.corrected for record in sent]
    assert captures["raw_position_counts"].tolist() == [record.raw for record in sent]
    assert captures["time_s"] == pytest.approx([record.time / 8e8 for record in sent])
    assert not captures["lost_before"].any()
    assert instrument.written[-1] == ("capture_enable", 0)


def test_lost_captures_are_told_where_they_were_lost(instrument, encoder):
    first, second, third, fourth = records(4)

    def stream():
        instrument.send_capture(first)
        instrument.send_overrun(17)
        instrument.send_capture(second)
        instrument.skip_number()
        instrument.send_capture(third)
        instrument.send_capture(fourth)

    instrument.on_write = lambda name, value: name == "capture_enable" and value and later(stream)
    assert encoder.capture(4)["lost_before"].tolist() == [0, 17, -1, 0]


def test_no_capture_says_what_was_asked(encoder):
    with pytest.raises(InstrumentError, match=r"capture of 3: 0 came, then: no capture came .* is there a strobe\?"):
        encoder.capture(3, timeout_s=0.1)


def test_a_pulled_cable_is_told_and_not_waited_for(instrument, encoder):
    instrument.pull_cable()
    time.sleep(0.1)
    with pytest.raises(LinkLost, match="read of strobe_delay: .* is gone"):
        _ = encoder.registers.strobe_delay


def test_a_noisy_line_brings_no_wrong_value(monkeypatch):
    monkeypatch.setattr(link, "ANSWER_TIMEOUT_S", 0.03)  # the pseudo-terminal answers at once or never
    with PseudoInstrument(SNAPSHOT, corrupt=noisy_wire(3, 1e-3)) as instrument, Encoder(instrument.port) as encoder:
        for n in range(400):
            encoder.registers.strobe_delay = n
            assert encoder.registers.strobe_delay == n
            assert encoder.snapshot().position == POSITION
        # Repeated because an answer was lost, and yet carried out once.
        assert instrument.written == [("strobe_delay", n) for n in range(400)]


@pytest.mark.parametrize(
    ("values", "error", "sentence"),
    [
        ({"magic": 0x1234}, InputError, "its first word is 0x1234; 0x4152 was expected"),
        ({"protocol": 0}, InputError, "speaks protocol 0, older than this arcref's 1; build and flash"),
        ({"protocol": 9}, InputError, "speaks protocol 9, newer than this arcref's 1; update arcref"),
    ],
)
def test_a_port_that_is_not_ours_is_refused(values, error, sentence):
    with PseudoInstrument(values) as instrument, pytest.raises(error, match=sentence):
        Encoder(instrument.port)


def test_a_port_that_is_missing_or_busy_is_refused_in_a_sentence(instrument, tmp_path):
    with pytest.raises(InputError, match="no such port"):
        Encoder(str(tmp_path / "none"))
    with Encoder(instrument.port), pytest.raises(InputError, match="busy: another program has it open"):
        Encoder(instrument.port)
    with pytest.raises(InputError, match="no serial port behind this name"):
        Encoder(str(__file__))


def test_the_fields_of_a_capture_have_their_units_in_their_names(instrument, encoder):
    instrument.on_write = lambda name, value: name == "capture_enable" and value and send_later(instrument, records(1))
    captures = encoder.capture(1)
    assert isinstance(captures, np.ndarray)
    assert {"time_s", "angle_deg", "position_counts", "raw_position_counts"} <= set(captures.dtype.names)


def send_later(instrument, sent):
    later(lambda: [instrument.send_capture(record) for record in sent])


def later(act):
    threading.Timer(0.02, act).start()
