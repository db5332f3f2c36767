"""PLL settings: legal by the data sheet, exact, and the same as the tools' own calculators find."""

import re
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest

from arcref.input_error import InputError
from arcref_gateware.boards import pll_ecp5, pll_ice40
from arcref_gateware.boards.pattern_clock import CLOCK_SAMPLES, pattern_clocks, pattern_divider
from arcref_gateware.boards.pll_choice import in_range
from arcref_gateware.boards.pll_ecp5 import ecp5_pll
from arcref_gateware.boards.pll_ice40 import ice40_pll


def tool(name: str, *options) -> str:
    executable = Path(sysconfig.get_path("scripts")) / name
    return subprocess.run([executable, *map(str, options)], capture_output=True, text=True, check=True).stdout


def test_ecp5_settings_are_legal_and_exact_for_every_frequency_they_are_given_for(rng):
    had = 0
    for reference_hz in rng.choice([8e6, 10e6, 12e6, 16e6, 25e6, 48e6, 50e6, 100e6, 125e6], 60):
        wanted_hz = float(reference_hz * rng.integers(1, 60) / rng.integers(1, 6))
        try:
            pll = ecp5_pll(reference_hz, wanted_hz)
        except InputError:
            continue
        had += 1
        assert pll.output_hz == pytest.approx(wanted_hz, rel=1e-9)
        assert reference_hz / pll.reference_divider * pll.feedback_divider * pll.output_divider == pytest.approx(
            pll.vco_hz
        )
        assert in_range(pll.phase_detector_hz, pll_ecp5.PHASE_DETECTOR_HZ)
        assert in_range(pll.vco_hz, pll_ecp5.VCO_HZ)
        for divider in (pll.reference_divider, pll.feedback_divider, pll.output_divider):
            assert divider in range(1, 129)
    assert had > 10


def test_ice40_settings_are_legal_and_exact_for_every_frequency_they_are_given_for(rng):
    had = 0
    for reference_hz in rng.choice([10e6, 12e6, 16e6, 25e6, 48e6, 100e6, 133e6], 60):
        wanted_hz = float(reference_hz * rng.integers(20, 128) / rng.choice([2, 4, 8, 16]))
        try:
            pll = ice40_pll(reference_hz, wanted_hz)
        except InputError:
            continue
        had += 1
        assert pll.output_hz == pytest.approx(wanted_hz, rel=1e-9)
        assert reference_hz / (pll.divr + 1) * (pll.divf + 1) / 2**pll.divq == pytest.approx(wanted_hz)
        assert in_range(pll.phase_detector_hz, pll_ice40.PHASE_DETECTOR_HZ)
        assert in_range(pll.vco_hz, pll_ice40.VCO_HZ)
        assert pll.divr in range(16)
        assert pll.divf in range(128)
        assert pll.divq in range(1, 7)
    assert had > 10


@pytest.mark.parametrize(
    ("reference_mhz", "output_mhz"), [(12, 201), (12, 96), (12, 84), (16, 112), (48, 120), (100, 275)]
)
def test_ice40_agrees_with_icepll(reference_mhz, output_mhz):
    text = tool("yowasp-icepll", "-i", reference_mhz, "-o", output_mhz)
    pll = ice40_pll(reference_mhz * 1e6, output_mhz * 1e6)
    found = {key: int(value) for key, value in re.findall(r"(DIVR|DIVF|DIVQ|FILTER_RANGE):\s+(\d+)", text)}
    assert float(re.search(r"F_PLLOUT:\s+([\d.]+) MHz \(achieved\)", text)[1]) == output_mhz
    assert found == {"DIVR": pll.divr, "DIVF": pll.divf, "DIVQ": pll.divq, "FILTER_RANGE": pll.filter_range}


@pytest.mark.parametrize(("reference_mhz", "output_mhz"), [(25, 400), (25, 325), (100, 400), (48, 96), (12, 144)])
def test_ecp5_reaches_what_ecppll_reaches(reference_mhz, output_mhz):
    text = tool("yowasp-ecppll", "-i", reference_mhz, "-o", output_mhz)
    pll = ecp5_pll(reference_mhz * 1e6, output_mhz * 1e6)
    assert float(re.search(r"clkout0 frequency: ([\d.]+) MHz", text)[1]) == pytest.approx(output_mhz)
    # ecppll takes any dividers of the same ratio; the ratio must be the same.
    ratio = int(re.search(r"Feedback divisor: (\d+)", text)[1]) / int(re.search(r"Refclk divisor: (\d+)", text)[1])
    assert pll.feedback_divider / pll.reference_divider == pytest.approx(ratio)


@pytest.mark.parametrize(
    ("calculate", "reference_hz", "wanted_hz", "line"),
    [
        (ecp5_pll, 25e6, 320e6, "320 MHz cannot be had from 25 MHz; the nearest that can: 312.5 and 325 MHz"),
        (ecp5_pll, 25e6, 401e6, "the ECP5's PLL gives 3.125 .. 400 MHz, not 401 MHz"),
        (ecp5_pll, 5e6, 100e6, "the ECP5's PLL takes 8 .. 400 MHz, not 5 MHz"),
        (ice40_pll, 12e6, 200e6, "200 MHz cannot be had from 12 MHz; the nearest that can: 198 and 201 MHz"),
        (ice40_pll, 12e6, 10e6, "the iCE40's PLL gives 16 .. 275 MHz, not 10 MHz"),
        (ice40_pll, 8e6, 96e6, "the iCE40's PLL takes 10 .. 133 MHz, not 8 MHz"),
    ],
)
def test_a_frequency_that_cannot_be_had_is_refused_in_one_line(calculate, reference_hz, wanted_hz, line):
    with pytest.raises(InputError) as error:
        calculate(reference_hz, wanted_hz)
    assert str(error.value) == line


def test_the_neighbours_that_a_refusal_names_can_be_had():
    for calculate, reference_hz, wanted_hz in ((ecp5_pll, 27e6, 333e6), (ice40_pll, 14e6, 99.9e6)):
        with pytest.raises(InputError) as error:
            calculate(reference_hz, wanted_hz)
        for mhz in re.findall(r"[\d.]+", str(error.value).partition("can: ")[2]):
            exact_hz = _nearest_exact(calculate, reference_hz, float(mhz) * 1e6)
            assert exact_hz == pytest.approx(float(mhz) * 1e6, rel=1e-5)


def _nearest_exact(calculate, reference_hz, printed_hz):
    for numerator in range(1, 129):
        for denominator in range(1, 17):
            for halvings in range(7):
                candidate_hz = reference_hz * numerator / denominator / 2**halvings
                if abs(candidate_hz - printed_hz) < 1e-5 * printed_hz:
                    return calculate(reference_hz, candidate_hz).output_hz
    raise AssertionError(f"{printed_hz} Hz is no multiple of {reference_hz} Hz")


@pytest.mark.parametrize("output_divider", range(2, 33))
def test_rising_and_falling_edges_of_the_pattern_visit_every_place_in_the_word(output_divider):
    clock_samples = 2 * pattern_divider(output_divider) / output_divider
    assert clock_samples >= CLOCK_SAMPLES
    for samples_per_word in (2, 4):
        edges = 0.01 + np.arange(1000) * sum(pattern_clocks(output_divider)) * clock_samples
        assert set(np.floor(edges % samples_per_word)) == set(range(samples_per_word))
