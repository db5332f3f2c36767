# amaranth: UnusedElaboratable=no
"""Parameters that no core can be made with are refused with a ValueError when the core is made."""

import pytest

from arcref_gateware.quadrature import Quadrature
from arcref_gateware.reference_encoder import ReferenceEncoder


@pytest.mark.parametrize("samples_per_word", [0, 3, 5, 8, -1])
def test_word_sizes_other_than_1_2_and_4_are_refused(samples_per_word, random_rom):
    with pytest.raises(ValueError, match="samples per word"):
        Quadrature(samples_per_word)
    with pytest.raises(ValueError, match="samples per word"):
        ReferenceEncoder(random_rom, samples_per_word)


@pytest.mark.parametrize("delay", [-1, 65536, 1 << 20])
def test_a_strobe_delay_beyond_16_bits_is_refused(delay, random_rom):
    with pytest.raises(ValueError, match="delay"):
        ReferenceEncoder(random_rom, 4, strobe_delay=delay)


@pytest.mark.parametrize("delay", [0, 1, 65535])
def test_a_strobe_delay_of_16_bits_is_the_reset_value(delay, random_rom):
    assert ReferenceEncoder(random_rom, 4, strobe_delay=delay).strobe_delay.init == delay


@pytest.mark.parametrize("gate_state", [(2, 0), (0, -1), (1,), (1, 1, 1), "x1"])
def test_a_gate_state_that_is_no_pair_of_levels_is_refused(gate_state, random_rom):
    with pytest.raises(ValueError, match="gate state"):
        ReferenceEncoder(random_rom, 4, gate_state=gate_state)
