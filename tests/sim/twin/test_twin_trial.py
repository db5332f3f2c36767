"""Trial tables over the pseudo-terminal: loaded, verified by the gateware, in force after the next index."""

import numpy as np
import pytest
from twin_truth import assert_captures, wait_until, wait_until_homed

from arcref import Encoder, Flag, InstrumentError
from arcref.correction_rom import CorrectionRom
from arcref.instrument.trial import BEGIN, FINISH


@pytest.fixture
def other_rom(random) -> CorrectionRom:
    """Tables in which no entry says what another does, with a correction inside the lines."""
    line = random.integers(-2000, 2000, 4096).astype(np.int16)
    return CorrectionRom(line, random.integers(-60, 60, 512).astype(np.int16), {"encoder_serial": "trial"})


def turn_past_the_index(twin, encoder) -> None:
    """Over the zero mark and back again, until the trial is in force or has had every chance."""
    before = encoder.registers.index_count
    twin.set_speed(-10.0 if twin.status().raw_position > 0 else 10.0)
    wait_until(lambda: encoder.registers.index_count != before)


def test_a_trial_is_in_force_after_the_next_index_and_not_before(make_twin, other_rom):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        built_in = encoder.identity.rom_crc32
        assert built_in == twin.rom.crc32 != other_rom.crc32
        encoder.load_trial(other_rom)
        identity = encoder.identity
        assert (identity.rom_state, identity.rom_is_trial) == ("waiting for the index", True)
        assert identity.rom_crc32 == other_rom.crc32
        assert identity.rom.values["serial"] == "trial"
        snapshot = encoder.snapshot()
        assert snapshot.position == snapshot.raw_position
        assert not snapshot.flags & Flag.CORRECTION_ACTIVE
        turn_past_the_index(twin, encoder)
        wait_until(lambda: encoder.flags & Flag.CORRECTION_ACTIVE)
        twin.rom = other_rom
        twin.set_strobe(90_000)
        captures = encoder.capture(600)
        assert_captures(twin, captures)
        assert np.ptp(captures["position_counts"] - captures["raw_position_counts"]) > 100


def test_tables_that_did_not_arrive_whole_never_come_into_force(make_twin, other_rom):
    with make_twin(speed_rps=10.0) as twin, Encoder(twin.port) as encoder:
        wait_until_homed(twin)
        twin.set_speed(0.0)
        write = encoder.registers.write_window
        spoilt = []

        def spoil_one_word(name, first, words):
            if name == "line_table" and first > 1000 and not spoilt:
                spoilt.append(first)
                words = [words[0] ^ 1, *words[1:]]
            write(name, first, words)

        object.__setattr__(encoder.registers, "write_window", spoil_one_word)
        with pytest.raises(InstrumentError, match="did not arrive whole"):
            encoder.load_trial(other_rom)
        assert spoilt
        turn_past_the_index(twin, encoder)
        assert not encoder.flags & Flag.CORRECTION_ACTIVE
        assert encoder.identity.rom_state == "fault"


def test_the_windows_are_open_while_a_trial_is_loaded_and_no_longer(make_twin):
    with make_twin() as twin, Encoder(twin.port) as encoder:
        with pytest.raises(InstrumentError, match="cannot be written now"):
            encoder.registers.write_window("line_table", 0, [1])
        encoder.registers.trial = BEGIN
        encoder.registers.write_window("line_table", 0, [1])
        encoder.registers.trial = FINISH
        with pytest.raises(InstrumentError, match="cannot be written now"):
            encoder.registers.write_window("line_table", 0, [1])
