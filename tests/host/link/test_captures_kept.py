"""Nothing that was received is lost: a killed process, a full disk, a pulled cable, an instrument switched off."""

import os
import resource
import signal
import subprocess
import sys
import threading
import time

import pytest
from pseudo_instrument import PseudoInstrument

from arcref import Encoder, InputError
from arcref.instrument.capture_file import open_capture_file
from arcref.instrument.captures import capture_array
from arcref.instrument.kept_link import KeptLink
from arcref.instrument.recorded_captures import read_capture_file
from arcref.link.capture_record import CaptureRecord
from arcref.link.link import LinkLost

SNAPSHOT = {"snapshot_time": 1000, "snapshot_flags": 0x102, "flags": 2, "rom_crc32": 7}


def record(number):
    return CaptureRecord(10_000 + 1000 * number, 5000 + number, 4990 + number, 2)


def streams(instrument, first, number, then=lambda: None):
    """The instrument sends captures once it is told to stream, and then does something else."""

    def send():
        for n in range(first, first + number):
            instrument.send_capture(record(n))
        then()

    def on_write(name, value):
        if name == "capture_enable" and value:
            threading.Timer(0.02, send).start()

    instrument.on_write = on_write


def start_capture(port, output, *options, limit_bytes=None):
    """`arcref capture` in a process of its own."""
    command = [sys.executable, "-m", "arcref.command", "capture", "--port", str(port), "-o", str(output), *options]
    limits = None
    if limit_bytes:
        limits = lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit_bytes, limit_bytes))  # noqa: E731
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=limits)


def rows(path):
    return [line for line in path.read_text().splitlines() if line[:1].isdigit()] if path.exists() else []


@pytest.mark.parametrize("name", ["c.csv", "c.h5"])
def test_a_killed_process_loses_nothing_that_was_received(tmp_path, name):
    with PseudoInstrument(SNAPSHOT) as instrument:
        streams(instrument, 0, 300)
        process = start_capture(instrument.port, tmp_path / name, "-n", "1000")
        written = tmp_path / ("c.csv" if name == "c.csv" else "c.h5.csv")
        deadline = time.monotonic() + 30
        while len(rows(written)) < 300:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
        process.communicate()
    read = read_capture_file(written)
    assert read.captures["position_counts"].tolist() == [record(n).corrected for n in range(300)]
    assert read.provenance["rom_crc32"] == "0x00000007"
    if name == "c.h5":
        with pytest.raises(InputError, match=r"cut short; what was received is in .*c\.h5\.csv"):
            read_capture_file(tmp_path / name)


@pytest.mark.parametrize("name", ["c.csv", "c.h5"])
def test_a_full_disk_is_told_and_what_found_room_is_whole(tmp_path, name):
    with PseudoInstrument(SNAPSHOT) as instrument:
        streams(instrument, 0, 400)
        process = start_capture(instrument.port, tmp_path / name, "-n", "400", limit_bytes=10_000)
        _, stderr = process.communicate(timeout=60)
    assert process.returncode == 2
    assert "Traceback" not in stderr
    (line,) = [line for line in stderr.splitlines() if line.startswith("arcref: ")]
    assert "cannot be written (File too large)" in line
    captures = read_capture_file(tmp_path / ("c.csv" if name == "c.csv" else "c.h5.csv")).captures
    assert 50 < len(captures) < 400
    assert captures["position_counts"].tolist() == [record(n).corrected for n in range(len(captures))]
    assert f"{len(captures)} captures stand in it" in line


def test_an_hdf5_file_that_finds_no_room_leaves_the_captures_in_csv(tmp_path, monkeypatch):
    def full(path, content):
        raise InputError(f"{path}: cannot be written: No space left on device")

    monkeypatch.setattr("arcref.instrument.capture_file.write_bytes", full)
    file = open_capture_file(tmp_path / "c.h5", {})
    file.append(capture_array([(0, record(n)) for n in range(20)], 8e8))
    with pytest.raises(InputError, match=r"c\.h5: cannot be written: No space .*; the captures are in .*c\.h5\.csv"):
        file.close()
    assert [path.name for path in tmp_path.iterdir()] == ["c.h5.csv"]
    assert len(read_capture_file(tmp_path / "c.h5.csv").captures) == 20


@pytest.mark.parametrize("name", ["c.csv", "c.h5"])
def test_without_a_capture_no_file_stays_behind(tmp_path, name):
    with PseudoInstrument(SNAPSHOT) as instrument:
        process = start_capture(instrument.port, tmp_path / name, "-n", "5", "--timeout", "0.1")
        stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 1
    assert stderr == f"arcref: no capture came from {instrument.port} in 0.1 s; is there a strobe?\n"
    assert not list(tmp_path.iterdir())


def test_ctrl_c_keeps_what_came_and_says_how_many(tmp_path):
    with PseudoInstrument(SNAPSHOT) as instrument:
        streams(instrument, 0, 30)
        process = start_capture(instrument.port, tmp_path / "c.csv", "-n", "1000")
        deadline = time.monotonic() + 30
        while len(rows(tmp_path / "c.csv")) < 30:
            assert time.monotonic() < deadline
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
        assert instrument.written[-1] == ("capture_enable", 0)
    assert process.returncode == 130
    assert "c.csv: 30 of 1000 captures\narcref: interrupted\n" in stderr


class Bench:
    """A port's name that outlives the instrument behind it."""

    def __init__(self, folder):
        self.port = folder / "port"
        self._instruments = []

    def plug_in(self, prepare=lambda instrument: None, **values):
        instrument = PseudoInstrument(SNAPSHOT | values).__enter__()
        prepare(instrument)
        self._instruments.append(instrument)
        self.port.unlink(missing_ok=True)
        self.port.symlink_to(instrument.port)
        return instrument

    def close(self):
        for instrument in self._instruments:
            instrument.pull_cable()


@pytest.fixture
def bench(tmp_path):
    bench = Bench(tmp_path)
    yield bench
    bench.close()


def pulled_and_plugged_in(bench, first, **values):
    """After the first captures the cable is pulled, and plugged in again a moment later."""

    def change():
        time.sleep(0.1)  # what is on the wire arrives
        first.pull_cable()
        time.sleep(0.3)
        bench.plug_in(lambda second: streams(second, 100, 10), **values)

    return change


def test_a_stream_goes_on_after_the_cable_was_pulled_and_the_gap_is_recorded(bench, tmp_path):
    first = bench.plug_in()
    streams(first, 0, 10, pulled_and_plugged_in(bench, first, snapshot_time=2000))
    process = start_capture(bench.port, tmp_path / "c.csv", "-n", "20")
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 0, stderr
    captures = read_capture_file(tmp_path / "c.csv").captures
    assert captures["position_counts"].tolist() == [record(n).corrected for n in [*range(10), *range(100, 110)]]
    assert captures["lost_before"].tolist() == [0] * 10 + [-1] + [0] * 9
    assert "captures lost: 0, and 1 gap of unknown length" in stderr


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"snapshot_time": 999}, "its clock began anew"),
        ({"snapshot_time": 2000, "snapshot_flags": 2}, "its zero is gone"),
        ({"rom_crc32": 8}, "another instrument, or another ROM, is at"),
    ],
)
def test_an_instrument_that_is_not_as_it_was_ends_the_stream(bench, values, sentence):
    first = bench.plug_in()
    streams(first, 0, 3, pulled_and_plugged_in(bench, first, **values))
    with Encoder(str(bench.port), reconnect_s=20) as encoder:
        stream = encoder.stream()
        taken = [next(stream) for _ in range(3)]
        with pytest.raises(LinkLost, match=sentence):
            taken.append(next(stream))
    assert len(taken) == 3


def test_settings_that_were_lost_end_the_stream_and_are_named(bench):
    first = bench.plug_in()
    streams(first, 0, 3, pulled_and_plugged_in(bench, first, snapshot_time=2000))
    with Encoder(str(bench.port), reconnect_s=20) as encoder:
        encoder.registers.strobe_delay = 4000
        with pytest.raises(LinkLost, match="switched off meanwhile \\(strobe_delay is 0 and was 4000\\)"):
            list(encoder.stream())


def test_a_cable_that_does_not_come_back_keeps_what_came(bench, tmp_path):
    first = bench.plug_in()
    streams(first, 0, 10, lambda: (time.sleep(0.1), first.pull_cable()))
    process = start_capture(bench.port, tmp_path / "c.csv", "-n", "20", "--reconnect", "0.3")
    _, stderr = process.communicate(timeout=60)
    assert process.returncode == 1
    assert f"{bench.port} went away and did not come back in 0.3 s" in stderr
    assert "c.csv: 10 of 20 captures" in stderr
    assert len(rows(tmp_path / "c.csv")) == 10


def test_a_reading_after_the_cable_was_plugged_in_again_just_works(bench):
    first = bench.plug_in(snapshot_position=11)
    with Encoder(str(bench.port)) as encoder:
        assert encoder.position == 11
        first.pull_cable()
        os.unlink(bench.port)
        time.sleep(0.1)
        with pytest.raises(LinkLost, match="read of the position: .* is gone"):
            _ = encoder.position
        bench.plug_in(snapshot_position=12)
        assert encoder.position == 12
        assert encoder.interruptions == 1


def test_another_instrument_is_never_read_in_its_place(bench):
    first = bench.plug_in(snapshot_position=11)
    with Encoder(str(bench.port)) as encoder:
        first.pull_cable()
        bench.plug_in(snapshot_position=12, rom_crc32=99)
        time.sleep(0.1)
        with pytest.raises(LinkLost, match="is gone"):
            _ = encoder.position
        assert encoder.interruptions == 0


def test_captures_that_nobody_asked_for_are_not_kept(bench):
    instrument = bench.plug_in()
    with Encoder(str(bench.port)) as encoder:
        for number in range(50):
            instrument.send_capture(record(number))
        assert encoder.registers.protocol == 1
        assert not encoder.captures_waiting


def test_a_link_that_was_closed_is_not_opened_again(bench):
    bench.plug_in()
    link = KeptLink(str(bench.port), 3_000_000, lambda record: None)
    link.close()
    assert link.link.lost is False
    assert link.interruptions == 0


def test_times_go_on_when_the_clock_of_the_instrument_comes_round(bench):
    instrument = bench.plug_in()
    times = [2**48 - 10, 5, 2**47 + 5, 3, 20]
    sent = [CaptureRecord(time, 1, 1, 2) for time in times]

    def on_write(name, value):
        if name == "capture_enable" and value:
            threading.Timer(0.02, lambda: [instrument.send_capture(each) for each in sent]).start()

    instrument.on_write = on_write
    with Encoder(str(bench.port)) as encoder:
        captures = encoder.capture(5)
    assert captures["time_samples"].tolist() == [
        2**48 - 10,
        2**48 + 5,
        2**48 + 2**47 + 5,
        2**49 + 3,
        2**49 + 20,
    ]
