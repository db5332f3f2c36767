"""The build fails on a missed constraint, on a clock that nobody constrained, and on a constraint that was ignored."""

import pytest

from arcref_gateware.boards.timing_report import UNCONSTRAINED_MHZ, read_timing_report

ICE40_LOG = """\
Info: constrained 'clk12_0__io' to bel 'X12/Y31/io1'
Info: constraining clock net 'clocks.start_clk' to 12.00 MHz
Info: constraining clock net 'clocks.word_clk' to 84.00 MHz
Info: Max frequency for clock 'clocks.word_clk': 85.10 MHz (PASS at 84.01 MHz)
"""

ECP5_LOG = """\
Info: constraining clock net 'clk25_0__io' to 25.00 MHz
Info:     Derived frequency constraint of 400.0 MHz for net clocks.edge_clk
Info:     Derived frequency constraint of 114.3 MHz for net clocks.pattern_clk
Info:     Derived frequency constraint of 200.0 MHz for net clocks.word_clk
"""


def report(family: str, **clocks) -> dict:
    """nextpnr's JSON: each clock as (constraint, reached) in MHz."""
    used = {
        "ice40": {"ICESTORM_LC": (1616, 5280), "ICESTORM_RAM": (20, 30)},
        "ecp5": {"TRELLIS_COMB": (1192, 83640), "TRELLIS_FF": (1255, 83640), "DP16KD": (6, 208)},
    }[family]
    return {
        "fmax": {name: {"constraint": wanted, "achieved": reached} for name, (wanted, reached) in clocks.items()},
        "utilization": {kind: {"used": some, "available": all_} for kind, (some, all_) in used.items()},
    }


def ice40(log=ICE40_LOG, **clocks):
    clocks = {"start_clk": (12.00005, 97.6), "word_clk": (84.00537, 85.1)} | clocks
    return read_timing_report(report("ice40", **clocks), log, "ice40", 84e6)


def test_a_report_without_a_fault():
    good = ice40()
    assert good.problems == ()
    assert good.word_clock_reached_hz == pytest.approx(85.1e6)
    assert (good.cells, good.cells_available, good.flip_flops) == (1616, 5280, None)
    assert (good.block_rams, good.block_rams_available) == (20, 30)
    clocks = {"i": (25, 243.7), "word_clk": (200, 201.9), "pattern_clk": (114.28571, 655.7)}
    good = read_timing_report(report("ecp5", **clocks), ECP5_LOG, "ecp5", 200e6)
    assert good.problems == ()
    assert (good.cells, good.flip_flops, good.block_rams) == (1192, 1255, 6)


@pytest.mark.parametrize("clock", ["start_clk", "word_clk"])
def test_a_missed_constraint_of_any_clock(clock):
    wanted = {"start_clk": 12.00005, "word_clk": 84.00537}[clock]
    bad = ice40(**{clock: (wanted, wanted - 0.01)})
    assert len(bad.missed) == 1
    assert bad.missed[0].startswith(f"{clock} reaches")
    assert bad.misuse == ()


def test_a_constraint_met_to_the_last_digit_holds():
    assert ice40(word_clk=(84.00537, 84.00537)).problems == ()


@pytest.mark.parametrize(
    "line",
    [
        "Warning: net 'clocks.word_clock' does not exist in design, ignoring clock constraint",
        "Warning: net 'x' is a constant, ignoring clock constraint.",
        "Warning: Unmatched constraint 'arcref_q' (on line 3)",
        "ERROR: Ignoring the frequency constraint of port 'clk'",
    ],
)
def test_an_ignored_constraint(line):
    bad = ice40(ICE40_LOG + line + "\n")
    assert len(bad.misuse) == 1
    assert "constraint" in bad.misuse[0]


@pytest.mark.parametrize("mhz", [UNCONSTRAINED_MHZ, 12.0])
def test_a_clock_that_no_constraint_names(mhz):
    # The oscillator of this board is no 12 MHz one, so nothing may be checked at 12 MHz.
    log = ICE40_LOG.replace("12.00", "25.00")
    bad = ice40(log, start_clk=(25, 90.0), lost=(mhz, 300.0))
    assert bad.misuse == (f"lost was checked at {mhz:.2f} MHz, nextpnr's choice for a clock without a constraint",)
    assert bad.missed == ()


def test_nextpnrs_own_choice_shows_on_a_board_with_a_12_mhz_oscillator():
    assert len(ice40(lost=(UNCONSTRAINED_MHZ, 300.0)).misuse) == 1


def test_a_clock_checked_at_another_frequency_than_asked_for():
    bad = ice40(word_clk=(48.0, 90.0))
    assert bad.word_clock_reached_hz is None
    assert any("no clock was checked at the word clock of 84 MHz" in text for text in bad.misuse)


def test_the_slower_half_of_a_word_clock_used_on_both_edges_counts():
    log = ICE40_LOG + "Info: constraining clock net 'inverted' to 84.00 MHz\n"
    assert ice40(log, inverted=(84.00537, 84.5)).word_clock_reached_hz == pytest.approx(84.5e6)
