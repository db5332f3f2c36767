# amaranth: UnusedElaboratable=no
"""The on-board self-test: its course, and the whole instrument behind the samplers that the generator drives."""

import numpy as np
import pytest
from amaranth.hdl import Elaboratable, Module, ResetSignal
from amaranth_bench import Bench, as_bits, assert_rows
from core_bench import OUTPUTS, as_output, assert_same_output
from spi_lines import SpiLines, to_bytes

from arcref.angle import COUNTS_PER_TURN
from arcref.flags import Flag
from arcref.input_error import InputError
from arcref.link.registers import GENERATOR_FAULTS, REGISTERS
from arcref.position_frame import RegisterFrame, encode_read_register
from arcref_gateware.boards.alignment_check import AlignmentPattern
from arcref_gateware.boards.instrument import Instrument
from arcref_gateware.boards.self_test import SelfTest
from arcref_gateware.boards.self_test_course import LEG_WORDS, SelfTestCourse, course_of_words
from arcref_gateware.boards.square_wave_generator import GENERATOR_CLOCKS, RATE_BITS
from arcref_gateware.boards.square_wave_golden import square_wave_samples
from arcref_gateware.boards.word_domains import add_word_domains
from arcref_gateware.golden.core import CoreModel
from arcref_gateware.golden.signal_changes import A_BIT, B_BIT, STROBE_BIT, Z_BIT, SignalChanges
from arcref_gateware.latency import LATENCY_CLOCKS

LINES = {"a": A_BIT, "b": B_BIT, "z": Z_BIT, "strobe": STROBE_BIT}
SPI_INPUTS = ("spi_sck", "spi_cs_n", "spi_copi")
INSTRUMENT_PORTS = ("alignment", "led_homed", "led_fault", "led_heartbeat", "hold")


class _WholeInstrument(Elaboratable):
    """The instrument in its two domains, its inputs and the core's outputs by name."""

    def __init__(self, instrument: Instrument):
        self.instrument = instrument
        for name in (*LINES, *INSTRUMENT_PORTS, *SPI_INPUTS):
            setattr(self, name, getattr(instrument, name))
        for name in OUTPUTS:
            setattr(self, name, getattr(instrument.core, name))

    def elaborate(self, platform):
        m = Module()
        add_word_domains(m)
        m.submodules.instrument = self.instrument
        m.d.comb += ResetSignal("sync").eq(self.instrument.hold)
        return m


class _FixedRate(SelfTest):
    """A self-test whose legs are short enough to be simulated: the zero mark is passed in every one."""

    def rate(self, samples_per_s):
        return RATE

    def legs(self, samples_per_word, samples_per_s):
        return LEGS * 4 // samples_per_word


def course_lines(words, samples_per_word, legs, fault=None):
    """What the generator shows on that course, by the golden models."""
    return square_wave_samples(samples_per_word, np.full(words, RATE), **course_of_words(words, legs, fault))


RATE = 30000 << 8  # edges at least two samples apart
LEGS = 14  # for four samples a word: 6563 counts, from more than a line before the zero mark to more than one behind it


def run_instrument(rom, samples_per_word: int, words: int, fault=None, **parameters):
    """Rows of the instrument's LEDs and of the core's outputs, these from the core's first word on."""
    self_test = _FixedRate(fault=fault)
    instrument = Instrument(rom, samples_per_word, 1e6, self_test=self_test, **parameters)
    bench = Bench(_WholeInstrument(instrument), ["alignment"], [*OUTPUTS, *INSTRUMENT_PORTS[1:]])
    return bench


def as_input(lines: dict, end: int) -> SignalChanges:
    states = sum(lines[name][:end].astype(np.uint8) << bit for name, bit in LINES.items())
    return SignalChanges.from_samples(states)


@pytest.mark.parametrize(
    ("samples_per_word", "fault"),
    [(4, None), (2, "dropped_edge"), (4, "doubled_step"), (4, "missing_index"), (1, "wide_index")],
)
def test_the_whole_instrument_counts_its_generator_as_the_golden_core_does(random_rom, samples_per_word, fault):
    legs = LEGS * 4 // samples_per_word
    words = 2 * legs * LEG_WORDS + 200
    rows = run_instrument(random_rom, samples_per_word, words, fault).run(words + LATENCY_CLOCKS + 1)
    assert rows["hold"][0] == 1
    assert not rows["hold"][1:].any()
    core = {name: rows[name][1 + LATENCY_CLOCKS :] for name in OUTPUTS}
    piece = as_input(course_lines(words, samples_per_word, legs, fault), words * samples_per_word)
    model = CoreModel(random_rom, samples_per_word)
    assert_same_output(as_output(core), model.run(piece))

    flags = int(core["flags"][-1])
    faults = {None: 0, "missing_index": Flag.INDEX_FAULT}
    if fault == "doubled_step":
        assert core["illegal_steps"][-1] == 1
        assert flags & Flag.ILLEGAL_STEP
        assert flags & Flag.CLOSURE_ERROR
    else:
        assert core["illegal_steps"][-1] == 0
        assert flags & (Flag.CLOSURE_ERROR | Flag.INDEX_FAULT) == faults.get(fault, Flag.CLOSURE_ERROR)
    if fault in ("dropped_edge", "wide_index"):
        assert abs(core["largest_closure_error"][-1]) == 4
    assert rows["led_homed"][-1] == 1
    assert rows["led_fault"][-1] == (fault is not None)
    assert core["capture_valid"].sum() > 10


@pytest.mark.parametrize("fault", [None, "wide_index"])
def test_with_a_link_the_generator_turns_from_power_up_and_its_registers_say_so(random_rom, fault):
    self_test = SelfTest(speed_rps=6.0, fault=fault)
    instrument = Instrument(random_rom, 2, 64e6, self_test=self_test, has_link=True, baud=8e6)
    settings = self_test.settings(128e6)
    assert settings == {
        "generator_control": 1 if fault is None else 0b100001,
        "generator_rate": round(6 * COUNTS_PER_TURN / 128e6 * 2**24) * 256,
    }
    lines = SpiLines(start=200)
    rate = REGISTERS["generator_rate"].address
    places = [REGISTERS["generator_control"].address, rate, rate + 1]
    for place in places:
        lines.transfer(encode_read_register(place), gap=90)
        lines.transfer()
    spi = {f"spi_{name}": row for name, row in lines.rows().items()}
    words = len(spi["spi_sck"])
    bench = Bench(_WholeInstrument(instrument), ["a", *spi], ["raw_position", "illegal_steps", "spi_cipo"])
    # The pins are not counted, whatever they do.
    rows = bench.run(words, a=np.arange(words) % 4, **spi)
    answers = [RegisterFrame.decode(to_bytes(bits)) for bits in lines.received(rows["spi_cipo"])[1::2]]
    read = [answer.word for answer in answers]
    assert read[0] == settings["generator_control"]
    assert read[1] | read[2] << 16 == settings["generator_rate"]
    raw = rows["raw_position"]
    turned = (words - GENERATOR_CLOCKS - LATENCY_CLOCKS) * 2 * settings["generator_rate"] / 2**32
    assert raw[-1] - raw[0] == pytest.approx(turned, abs=5)
    assert rows["illegal_steps"][-1] == 0


def test_the_core_is_held_until_the_alignment_check_has_passed(random_rom):
    pattern = AlignmentPattern(7, 14)
    samples = ((np.arange(4 * 4000) % 21) < 7).astype(int)
    rows = run_instrument(random_rom, 4, 4000, pattern=pattern).run(4000, alignment=as_bits(samples.reshape(-1, 4)))
    released = 1 + int(np.argmin(rows["hold"][1:]))  # it comes from the second clock on
    assert 1000 < released < 4000
    assert not rows["hold"][released:].any()
    assert not rows["raw_position"][:released].any()
    assert rows["raw_position"][-1] != 0
    assert not rows["led_fault"].any()


def test_a_wrong_order_holds_the_core_for_good_and_lights_the_fault_led(random_rom):
    pattern = AlignmentPattern(7, 14)
    samples = ((np.arange(4 * 3000) % 21) < 7).astype(int).reshape(-1, 4)[:, ::-1]
    rows = run_instrument(random_rom, 4, 3000, pattern=pattern).run(3000, alignment=as_bits(samples))
    assert rows["hold"][1:].all()
    assert rows["led_fault"][-1] == 1
    assert not rows["raw_position"].any()
    assert not rows["spi_cipo"].any()


def test_the_heartbeat_beats_with_the_word_clock_also_while_the_core_is_held(random_rom):
    instrument = Instrument(random_rom, 1, 100.0, pattern=None)
    rows = Bench(_WholeInstrument(instrument), ["alignment"], ["led_heartbeat"]).run(600)
    beats = np.flatnonzero(np.diff(rows["led_heartbeat"]))
    assert list(np.diff(beats)) == [64] * (len(beats) - 1)
    assert len(beats) >= 8


@pytest.mark.parametrize("samples_per_s", [800e6, 348e6, 168e6])
def test_speed_of_the_self_test_is_what_was_asked_for(samples_per_s):
    test = SelfTest(speed_rps=10.0)
    assert test.reached_rps(samples_per_s) == pytest.approx(10.0, rel=1e-6)
    rate, legs = test.rate(samples_per_s), test.legs(4, samples_per_s)
    turns = rate / (1 << RATE_BITS) * legs * LEG_WORDS * 4 / COUNTS_PER_TURN
    assert 2.001 <= turns < 2.01


def test_a_speed_beyond_the_samples_or_an_unknown_fault_is_refused_in_one_line():
    with pytest.raises(InputError, match="at most 95.37 r/s"):
        SelfTest(speed_rps=96).rate(800e6)
    with pytest.raises(InputError, match="more than 0"):
        SelfTest(speed_rps=-1).rate(800e6)
    with pytest.raises(InputError, match="dropped_edge, doubled_step, missing_index, wide_index"):
        SelfTest(fault="dropped_egde")
    with pytest.raises(InputError, match="at most 1000 turns"):
        SelfTest(leg_turns=0)
    with pytest.raises(ValueError, match="1 and more"):
        SelfTestCourse(0)


@pytest.mark.parametrize("fault", [None, *GENERATOR_FAULTS])
@pytest.mark.parametrize("legs", [1, 2, 5])
def test_the_course_asks_for_what_its_model_says(legs, fault):
    words = 4 * legs * LEG_WORDS + 3
    rows = Bench(SelfTestCourse(legs, fault), [], ["reverse", "fault"]).run(words)
    expected = course_of_words(words, legs, fault)
    for name, row in rows.items():
        assert_rows(name, row, expected[name])
    assert bool(expected["fault"].any()) == (fault is not None)
