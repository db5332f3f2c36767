"""The zero-return test on an instrument: what passes, what fails, and what is said while it waits."""

import json

import numpy as np
import pytest
from moving_shaft import MovingShaft
from pseudo_instrument import PseudoInstrument

from arcref import CorrectionRom, Encoder, InputError, InstrumentError
from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.instrument import zero_return_leg
from arcref.link.link import LinkLost
from arcref.link.registers import GENERATOR_FAULTS
from arcref.zero_return.figures import figures
from arcref.zero_return.page import zero_return_page

QUICK = {"readings_per_s": 1000.0, "timeout_s": 20.0}


@pytest.fixture
def run():
    """Runs the test on a shaft: `run(revolutions, options=..., **shaft)` gives result, shaft, instrument and lines."""

    def run_on(revolutions=2, *, options=None, shaft=None, **motion):
        shaft = shaft or MovingShaft(**{"turn_at": revolutions + 0.2} | motion)
        lines = []
        with PseudoInstrument() as instrument:
            shaft.attach(instrument)
            with Encoder(instrument.port) as encoder:
                result = encoder.zero_return(revolutions=revolutions, **QUICK | {"ask": lines.append} | (options or {}))
        return result, shaft, instrument, lines

    return run_on


def marks(result):
    return [(index.turn, index.direction, index.closure_error_counts) for index in result.index_passes]


def failed(result):
    return [check.sentence for check in result.checks if not check.passed]


def test_an_instrument_that_was_not_homed_homes_and_returns(run):
    result, shaft, instrument, lines = run(3, start=-0.7)
    assert result.passed, failed(result)
    assert marks(result) == [(t, 1, 0) for t in range(4)] + [(t, -1, 0) for t in (3, 2, 1, 0)]
    assert [index.homes for index in result.index_passes] == [True] + 7 * [False]
    assert result.counts_per_turn == 6 * [COUNTS_PER_TURN]
    assert result.zero_drift_counts == 0
    assert result.speed_rps == pytest.approx(10, rel=0.05)
    assert result.illegal_steps == 0
    assert ("clear_flags", 0xFC) in instrument.written
    assert "home" not in [name for name, _ in instrument.written]
    assert lines == [
        "Turn the shaft forward past the zero mark, which homes, and then 3 turns and a little further.",
        "Now turn it back the same 3 turns and a little further.",
    ]


def test_times_of_the_marks_are_told_to_a_reading(run):
    result, *_ = run(3, start=-0.3)
    times = [index.time_s for index in result.index_passes if index.direction > 0]
    assert np.diff(times) == pytest.approx(0.1, abs=0.012)


def test_a_homed_instrument_keeps_its_zero(run):
    result, shaft, instrument, _ = run(2, homed=True, start=6.4, turn_at=9.2, end_at=6.5)
    assert result.passed, failed(result)
    assert result.first_turn == 7
    assert [turn for turn, _, _ in marks(result)] == [7, 8, 9, 9, 8, 7]
    assert not any(index.homes for index in result.index_passes)
    assert shaft.zero == 0


@pytest.mark.parametrize("seed", range(4))
def test_rehome_sets_the_zero_at_the_first_mark(run, seed):
    motion = {"homed": True, "zero": 777, "start": 4.9, "turn_at": 7.5, "end_at": 4.7, "seed": seed}
    result, shaft, instrument, _ = run(2, options={"rehome": True}, **motion)
    assert result.passed, failed(result)
    assert result.index_passes[0].homes
    assert result.first_turn == 0
    assert ("home", 1) in instrument.written
    assert shaft.zero == -5 * COUNTS_PER_TURN


def test_lost_counts_fail_at_every_later_mark(run):
    result, *_, lines = run(3, lost={1.5: 4})
    assert failed(result) == ["every closure error is 0", "zero drift is 0", "no fault flag but edge spacing"]
    assert marks(result)[1:] == [(1, 1, 0), (2, 1, -4), (3, 1, -4), (3, -1, -4), (2, -1, -4), (1, -1, -4), (0, -1, -4)]
    assert result.zero_drift_counts == -4
    (fault,) = result.instrument.faults
    assert (fault.name, fault.words, fault.position_counts) == ("closure error", 6, 2 * COUNTS_PER_TURN - 4)
    assert any(line.startswith("Fault: closure error, at turn ") for line in lines)


def test_counts_lost_faster_than_the_readings_are_not_hidden(run):
    result, *_ = run(12, turn_at=24, end_at=-12, speed_rps=60, step_s=0.08, lost={8.5: 3, 9.5: -3})
    assert result.instrument.largest_closure_error_counts == -3
    assert failed(result)[0] == "every closure error is 0"
    assert None in result.closure_errors_counts
    assert "-3 at most" in dict(figures(result))["closure error, each"]


def test_marks_faster_than_the_readings_are_all_told(run):
    result, *_ = run(30, turn_at=40.5, end_at=-10.5, speed_rps=60, step_s=0.08)
    assert result.passed, failed(result)
    first = result.index_passes[0].turn
    there_and_back = [(t, 1, 0) for t in range(first, 41)] + [(t, -1, 0) for t in range(40, -11, -1)]
    assert marks(result) == there_and_back[: len(result.index_passes)]
    assert result.instrument.readings < 40


def test_a_missing_mark_fails(run):
    result, *_ = run(3, dark={2})
    assert failed(result) == ["every zero mark was seen", "no fault flag but edge spacing"]
    assert [turn for turn, _, _ in marks(result)] == [0, 1, 3, 3, 1, 0]
    assert result.checks[0].found == "6 of 8; missing: turn 2 forward, turn 2 reverse"
    (fault,) = result.instrument.faults
    assert fault.words == 2
    assert round(fault.position_counts / COUNTS_PER_TURN) == 2


def test_an_illegal_step_fails_and_earlier_ones_do_not(run):
    shaft = MovingShaft(turn_at=2.2, flags=int(Flag.ILLEGAL_STEP | Flag.CLOSURE_ERROR))
    assert run(2, shaft=shaft)[0].passed
    shaft = MovingShaft(turn_at=2.2)

    def slip():
        if shaft.place > COUNTS_PER_TURN and shaft["illegal_steps"] == 3:
            shaft["illegal_steps"] = 5
            shaft.fault(Flag.ILLEGAL_STEP, "illegal_step")

    shaft.on_step = slip
    result = run(2, shaft=shaft)[0]
    assert result.illegal_steps == 2
    assert failed(result) == ["no illegal step", "no fault flag but edge spacing"]


def test_a_hand_may_waver_over_a_mark(run):
    shaft = MovingShaft(speed_rps=5)
    shaft.goals = [turns * COUNTS_PER_TURN for turns in (1.01, 0.99, 1.001, 0.999, 2.3, 1.9, 2.2, -0.1, 0.1, -0.3)]
    result, *_ = run(2, shaft=shaft)
    assert result.passed, failed(result)
    assert len(result.index_passes) + result.instrument.further_marks > 6
    assert result.missing_passes == []


def test_the_wrong_direction_is_told_at_once_and_at_the_time_out(run, monkeypatch):
    monkeypatch.setattr(zero_return_leg, "AGAINST_S", 0.05)
    lines = []
    with pytest.raises(
        InstrumentError,
        match=r"zero-return test: the shaft turned \d\.\d\d turns in the wrong direction, reverse, while the zero mark "
        r"was awaited on the way out; where it did turn the right way, swap A and B",
    ):
        run(2, options={"timeout_s": 0.4, "ask": lines.append}, homed=True, start=3.5, turn_at=-4, end_at=-4)
    assert lines[1:] == ["The shaft turns reverse: turn it forward."]


def test_no_motion_says_what_was_awaited(run):
    sentence = r"the shaft stood still for 0\.2 s while the zero mark was awaited; turn it"
    with pytest.raises(InstrumentError, match=sentence):
        run(2, options={"timeout_s": 0.2}, start=-0.3, turn_at=-0.3)
    sentence = r"the shaft stood still for 0\.2 s while turn 3 of 10 back was awaited"
    with pytest.raises(InstrumentError, match=sentence):
        run(10, options={"timeout_s": 0.2}, end_at=7.4)


def test_no_zero_mark_at_all_is_told(run):
    with pytest.raises(InstrumentError, match=r"no zero mark came in 1\.5 turns; look at the Z line"):
        run(3, dark=set(range(9)))


def test_a_reset_in_between_is_told(run):
    shaft = MovingShaft(turn_at=3.2)
    shaft.on_step = lambda: shaft.place > 1.5 * COUNTS_PER_TURN and setattr(shaft, "time", 0)
    with pytest.raises(InstrumentError, match="the instrument was reset meanwhile"):
        run(3, shaft=shaft)


def test_a_pulled_cable_is_told_with_the_turn():
    shaft = MovingShaft(turn_at=5.2)
    with PseudoInstrument() as instrument:
        shaft.attach(instrument)
        shaft.on_step = lambda: shaft.place > 2.5 * COUNTS_PER_TURN and instrument.pull_cable()
        with (
            Encoder(instrument.port) as encoder,
            pytest.raises(LinkLost, match=r"zero-return test, while turn 3 of 5 forward was awaited: .* is gone"),
        ):
            encoder.zero_return(revolutions=5, ask=lambda line: None, **QUICK)


def test_readings_are_compared_with_the_rom_image(run):
    rom = CorrectionRom.from_fit(lambda deg: 2 * np.sin(np.radians(deg)))
    state = {"rom_crc32": rom.crc32, "correct": lambda raw: int(rom.correct(raw))}
    result, *_ = run(2, options={"rom": rom}, **state)
    assert result.passed, failed(result)
    assert result.instrument.rom_readings_wrong == 0
    result, *_ = run(2, options={"rom": rom}, **state | {"correct": lambda raw: raw})
    assert failed(result) == ["every reading is corrected as the ROM image says"]
    with pytest.raises(InputError, match="the instrument carries 0x00000000: it belongs to another encoder"):
        run(2, options={"rom": rom}, rom_crc32=0)


def test_a_bad_rom_in_the_instrument_fails(run):
    assert failed(run(1, rom_state=2)[0]) == ["the correction ROM is good"]


def test_a_correction_that_is_off_is_stated(run):
    told = dict(figures(run(1, corrects=False)[0]))["corrected, off the ROM"]
    assert told == "the correction was off; not checked: no ROM image was named"
    assert dict(figures(run(1)[0]))["corrected, off the ROM"] == "not checked: no ROM image was named"


class GeneratedShaft(MovingShaft):
    """Turned by the test generator's registers."""

    def __init__(self, control=0, rate=0, **more):
        super().__init__(features=1, **more)
        self |= {"generator_control": control, "generator_rate": rate}
        self.goals, self.on_step = [], self.follow

    def attach(self, instrument):
        """Put this behind the instrument, whose registers hold what they do at power-up."""
        instrument.model.settings |= {name: self[name] for name in ("generator_control", "generator_rate")}
        return super().attach(instrument)

    def follow(self):
        """Take goal and speed from the registers."""
        self.stands = not self["generator_control"] & 1
        self.goals = [-1e12 if self["generator_control"] & 2 else 1e12]
        self.speed_rps = self["generator_rate"] / 2**32 * 8e8 / COUNTS_PER_TURN

    def write(self, name, value):
        super().write(name, value)
        if name.startswith("generator_"):
            self[name] = value


def test_the_generator_turns_forward_and_back_and_is_stopped(run):
    result, shaft, instrument, lines = run(3, options={"generator_speed_rps": 25.0}, shaft=GeneratedShaft(step_s=0.004))
    assert result.passed, failed(result)
    assert result.speed_rps == pytest.approx(25)
    assert result.instrument.driven_by == "test generator"
    names = [pair for pair in instrument.written if pair[0].startswith(("generator", "clear"))]
    rate = round(25 * COUNTS_PER_TURN / 8e8 * 2**24) * 256
    assert names == [
        ("generator_rate", 0),
        ("generator_control", 1),
        ("clear_flags", 0xFC),
        ("generator_control", 1),
        ("generator_rate", rate),
        ("generator_control", 3),
        ("generator_rate", rate),
        ("generator_rate", 0),
        ("generator_control", 0),
    ]
    assert lines == ["The zero is the test generator's now: home again on the encoder with `arcref registers home=1`."]


def test_the_generator_is_stopped_after_a_failure(run):
    shaft = GeneratedShaft(dark=set(range(9)))
    with pytest.raises(InstrumentError, match="no zero mark came"):
        run(3, options={"generator_speed_rps": 10.0}, shaft=shaft)
    assert shaft["generator_control"] == 0


@pytest.mark.parametrize(
    ("options", "shaft", "sentence"),
    [
        ({"generator_speed_rps": 10.0}, {}, "this bitstream has no test generator; leave --generator out"),
        ({"generator_speed_rps": 96.0}, {"features": 1}, r"cannot turn at 96 r/s: .* 95\.37 r/s at most"),
        ({"generator_speed_rps": float("nan")}, {"features": 1}, "cannot turn at nan r/s"),
        ({"generator_speed_rps": 10.0}, {"features": 1, "homed": True}, "allow it with --rehome"),
        ({"generator_speed_rps": 1e-7}, {"features": 1}, r"must be 5\.7e-06 r/s at least and"),
        ({"generator_fault": "wide_index"}, {"features": 1}, "only the test generator makes faults"),
        (
            {"generator_speed_rps": 9.0, "generator_fault": "wide"},
            {"features": 1},
            "makes no fault 'wide'; it makes dropped_edge, doubled_step, missing_index, wide_index",
        ),
        ({"revolutions": 1001}, {}, r"1001 revolutions were asked for, 0 \.\. 1000 were expected"),
        ({"timeout_s": 0.0}, {}, "time-out and readings a second must be above 0"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is_written(options, shaft, sentence):
    with PseudoInstrument() as instrument:
        MovingShaft(**shaft).attach(instrument)
        with Encoder(instrument.port) as encoder, pytest.raises(InputError, match=sentence):
            encoder.zero_return(**options)
        assert instrument.written == []


def test_a_generator_that_turns_from_power_up_is_used_as_it_is_and_left_so(run):
    """A self-test bitstream: nothing is wired and nothing is named, and it was homed on the generator long ago."""
    rate = round(20 * COUNTS_PER_TURN / 8e8 * 2**24) * 256
    shaft = GeneratedShaft(1, rate, step_s=0.004, homed=True)
    result, shaft, _, lines = run(2, shaft=shaft)
    assert result.passed, failed(result)
    assert result.instrument.driven_by == "test generator"
    assert result.speed_rps == pytest.approx(20)
    assert (shaft["generator_control"], shaft["generator_rate"]) == (1, rate)
    assert lines == []


@pytest.mark.parametrize("fault", GENERATOR_FAULTS)
def test_the_generator_is_asked_for_the_fault(run, fault):
    bits = 4 << list(GENERATOR_FAULTS).index(fault)
    options = {"generator_speed_rps": 25.0, "generator_fault": fault}
    _, _, instrument, _ = run(1, options=options, shaft=GeneratedShaft(step_s=0.004))
    assert [value for name, value in instrument.written if name == "generator_control"] == [1, 1 | bits, 3 | bits, 0]


def test_a_fault_that_the_register_asks_for_stays(run):
    shaft = GeneratedShaft(0b100001, 1 << 28, step_s=0.004)
    _, shaft, instrument, _ = run(1, shaft=shaft)
    assert [value for name, value in instrument.written if name == "generator_control"] == [1, 0x21, 0x23, 0x21]


def test_a_shaft_that_is_not_seen_is_refused():
    with PseudoInstrument({"features": 1}) as instrument, Encoder(instrument.port) as encoder:
        encoder.registers.generator_control = 1
        with pytest.raises(InputError, match="in place of the shaft and stands; name a speed with --generator"):
            encoder.zero_return()


def test_the_page_says_what_was_not_checked(run):
    page = zero_return_page(run(2)[0])
    assert "Not checked on hardware" in page
    assert "an instrument does not know the true angle" in page
    assert page.count("<svg") == 2
    assert "Error over the turn" not in page
    assert "<h2>Faults</h2>" not in page
    page = zero_return_page(run(2, lost={0.5: 3})[0])
    assert "FAIL" in page
    assert "<h2>Faults</h2>" in page


def test_the_command_passes_fails_and_writes_its_files(arcref, tmp_path):
    page, json_path = tmp_path / "page.html", tmp_path / "figures.json"
    arguments = ["--revolutions", 2, "--rate", 1000, "--page", page, "--json", json_path]
    for lost, status, verdict in (({}, 0, "PASS"), ({1.5: 5}, 1, "FAIL")):
        with PseudoInstrument() as instrument:
            MovingShaft(turn_at=2.2, lost=lost).attach(instrument)
            result = arcref("zero-return", "--port", instrument.port, *arguments)
        assert result.exit_code == status, result.output
        assert result.stdout.rstrip().endswith(verdict)
        assert "Turn the shaft forward past the zero mark" in result.stderr
        told = json.loads(json_path.read_text())
        assert told["passed"] is (status == 0)
        assert told["format"] == "arcref-zero-return"
        assert told["lost_counts"] is told["error_after_rms_arcsec"] is told["words"] is None
        assert told["instrument"]["largest_closure_error_counts"] == (-5 if lost else 0)
        assert f">{verdict}<" in page.read_text()


def test_the_command_leaves_no_file_when_the_cable_is_pulled(arcref, tmp_path):
    page = tmp_path / "page.html"
    shaft = MovingShaft(turn_at=5.2)
    with PseudoInstrument() as instrument:
        shaft.attach(instrument)
        shaft.on_step = lambda: shaft.place > 2.5 * COUNTS_PER_TURN and instrument.pull_cable()
        result = arcref("zero-return", "--port", instrument.port, "--revolutions", 5, "--page", page, "--rate", 1000)
    assert result.exit_code == 1
    assert "is gone" in result.stderr
    assert not page.exists()


def test_bad_files_are_refused_before_the_shaft_need_turn(arcref, tmp_path):
    for options, sentence in (
        (["--page", tmp_path / "none" / "page.html"], "its folder does not exist"),
        (["--page", tmp_path / "a", "--json", tmp_path / "a"], "this name is given to two files"),
        (["--rom", tmp_path / "none.rom.json"], "none.rom.json"),
    ):
        with PseudoInstrument() as instrument:
            result = arcref("zero-return", "--port", instrument.port, *options)
            assert instrument.written == []
        assert result.exit_code == 2
        assert sentence in result.stderr
        assert result.stderr.count("\n") == 1
